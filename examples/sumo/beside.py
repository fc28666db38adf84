"""The ego by SUMO's own models and by timegap's stack, deployed well and badly, on one route among the same traffic.

    python3 examples/sumo/beside.py --seeds 1..5

It needs `timegap` (or --timegap PROGRAM) and `sumo` on the PATH. A trip begins at rest and ends at the end of the route.
Energy is the one at the wheels, by timegap's formula: services/plant/src/wheel_energy.rs.
"""

import argparse
import csv
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

HERE = Path(__file__).resolve().parent
BEGIN_S, STEP_S, LATEST_S = 300, 0.1, 300
# The ends of timegap's way on the route: links/sumo/src/route.rs.
DEPART_M, BEFORE_END_M = 4.6, 5.0
# A compact car with two persons: services/plant/src/numbers.rs.
MASS_KG, ROLLING, DRAG_KGPM, GRAVITY_MPS2 = 1600.0, 0.011, 0.766, 9.81
MODELS = ["Krauss", "IDM", "ACC", "CACC"]
SUMO = ["sumo", "-c", HERE / "grid.sumocfg", "--step-length", str(STEP_S), "--collision.action", "none", "--no-step-log",
        "--no-warnings", "--duration-log.disable", "--xml-validation", "never"]
# Times that the cost is measured over, s: SUMO alone, and the stack, which has come to the end after 110 s.
ALONE_S, DRIVEN_S = 600, 90
NO_UNIT = ",".join(f'{{kind="drop",topic="v2x/{it}",at_s=0,for_s=1000}}' for it in ("spat", "map", "preview"))
DEAD = ",".join(f'{{kind="drop",topic="control/command",at_s={at_s},for_s=2}}' for at_s in range(10, 300, 20))
# What a deployment does to the stack: the arguments of `timegap compare`.
STACKS = {
    "cacc-mpc": ["cacc-mpc"],
    "acc-mpc": ["acc-mpc"],
    "cacc-mpc, 200 ms late": ["cacc-mpc", "--set", "runtime.extra_delay_ms=200"],
    "cacc-mpc, dead for 2 s in 20": ["cacc-mpc", "--set", f"faults=[{DEAD}]"],
    "cacc-mpc, no roadside unit": ["cacc-mpc", "--set", f"faults=[{NO_UNIT}]"],
}


def sumo_trip(model: str, seed: int, work: Path) -> dict[str, float]:
    """The trip of an ego that a model of SUMO drives."""
    route = ElementTree.parse(HERE / "grid.rou.xml").find("./route[@id='through']")
    assert route is not None
    added, track, hits = work / "ego.add.xml", work / "fcd.xml", work / "collisions.xml"
    # `startup` delays and imperfection stay at the model's defaults.
    added.write_text(
        f'<additional><vType id="of-ego" carFollowModel="{model}" length="4.5" width="1.8"/>'
        f'<vehicle id="ego" type="of-ego" depart="{BEGIN_S}" departSpeed="0" departPos="{DEPART_M}" '
        f'arrivalPos="-{BEFORE_END_M}"><route edges="{route.get("edges")}"/></vehicle></additional>')
    subprocess.run(
        [*SUMO, "--additional-files", added, "--seed", str(seed), "--begin", "0", "--end", str(BEGIN_S + LATEST_S),
         "--fcd-output", track, "--fcd-output.attributes", "speed", "--device.fcd.explicit", "ego",
         "--device.fcd.begin", str(BEGIN_S), "--collision-output", hits], check=True)
    speeds = [float(it.get("speed", 0)) for it in ElementTree.parse(track).iterfind(".//vehicle[@id='ego']")]
    energy_j, way_m, stops, drives = 0.0, 0.0, 0, False
    for before, after in zip(speeds, speeds[1:]):
        speed = (before + after) / 2
        force = MASS_KG * ((after - before) / STEP_S + ROLLING * GRAVITY_MPS2) + DRAG_KGPM / 2 * speed * speed
        energy_j += max(force, 0) * speed * STEP_S
        way_m += speed * STEP_S
        stops += drives and after < 0.1
        drives = after > 1 or (drives and after >= 0.1)
    hit = [it for it in ElementTree.parse(hits).iterfind("collision") if "ego" in (it.get("collider"), it.get("victim"))]
    return {"trip_s": len(speeds) * STEP_S, "stops": stops, "collisions": len(hit),
            "kwh": energy_j / 3.6e6 / (way_m / 1e5), "hardest": min(b - a for a, b in zip(speeds, speeds[1:])) / STEP_S}


def stack_trips(program: str, arguments: list[str], seeds: str, work: Path) -> list[dict[str, float]]:
    """The trips of timegap's stack."""
    done = subprocess.run(
        [program, "compare", HERE / "grid.toml", "--controllers", *arguments, "--seeds", seeds, "--out", work / "runs",
         "--force", "--set", f"traffic.begin_s={BEGIN_S}"], stdout=subprocess.DEVNULL, check=False)
    # Status 1: a run with a collision or a red light, which is a result here.
    if done.returncode not in (0, 1):
        sys.exit(done.returncode)
    with (work / "runs/runs.csv").open() as file:
        return [{"trip_s": float(row["duration_s"]), "stops": float(row["stops"] or 0),
                 "collisions": float("collision" in row["outcome"].lower()), "red": float("red" in row["outcome"].lower()),
                 "kwh": float(row["wheel_energy_kwh_per_100km"] or "nan"), "hardest": float(row["min_accel_mps2"]),
                 "brake": float(row["interventions"] or 0)} for row in csv.DictReader(file)]


def least_s(*command: object) -> tuple[float, float]:
    """The least processor and wall time of five runs of a program and those that it starts: others disturb it least."""
    def clocks_s() -> tuple[float, float]:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime, time.monotonic()
    times_s = [clocks_s()]
    for _ in range(5):
        subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL, check=True)
        times_s.append(clocks_s())
    processor_s, wall_s = (min(b[k] - a[k] for a, b in zip(times_s, times_s[1:])) for k in range(2))
    return processor_s, wall_s


def cost(program: str, work: Path) -> str:
    """The steps in a second, without the start and the time before the ego comes."""
    stack = [program, "run", HERE / "grid.toml", "--mode", "lockstep", "--in-process", "--out", work / "cost", "--force",
             "--set", f"traffic.begin_s={BEGIN_S}", "--duration"]
    alone = least_s(*SUMO, "--end", BEGIN_S + ALONE_S), least_s(*SUMO, "--end", BEGIN_S)
    driven = least_s(*stack, DRIVEN_S), least_s(*stack, 1)
    lines = []
    for k, clock in enumerate(["processor", "wall"]):
        sumo, both = ALONE_S / (alone[0][k] - alone[1][k]) / STEP_S, (DRIVEN_S - 1) / (driven[0][k] - driven[1][k]) / STEP_S
        lines.append(f"steps of {STEP_S} s in a second of {clock} time: SUMO alone {sumo:.0f}, the stack with SUMO {both:.0f}, "
                     f"ratio {sumo / both:.1f}")
    return "\n".join(lines)


def main() -> None:
    """Drives all, and prints a row each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1..5", help="A..B, as in `timegap compare`")
    parser.add_argument("--timegap", default="timegap", help="the program")
    parser.add_argument("--cost", action="store_true", help="print the cost of a step alone")
    options = parser.parse_args()
    first, last = (int(it) for it in options.seeds.split(".."))
    egos = [] if options.cost else [*MODELS, *STACKS]
    if egos:
        print(f"{'ego':28}{'trip, s':>9}{'stops':>7}{'kWh/100 km':>12}{'hardest':>9}{'hits':>6}{'reds':>6}{'brake':>7}  s of wall")
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for ego in egos:
            begun = time.monotonic()
            if ego in STACKS:
                rows = stack_trips(options.timegap, STACKS[ego], options.seeds, work)
            else:
                rows = [sumo_trip(ego, seed, work) for seed in range(first, last + 1)]
            mean = {key: statistics.fmean(row[key] for row in rows) for key in ("trip_s", "stops", "kwh")}
            total = {key: sum(row.get(key, 0) for row in rows) for key in ("collisions", "red", "brake")}
            title = f"SUMO's {ego}" if ego in MODELS else ego
            print(f"{title:28}{mean['trip_s']:9.1f}{mean['stops']:7.1f}{mean['kwh']:12.1f}"
                  f"{min(row['hardest'] for row in rows):9.1f}{total['collisions']:6.0f}{total['red']:6.0f}"
                  f"{total['brake']:7.0f}{(time.monotonic() - begun) / len(rows):11.1f}", flush=True)
        print(cost(options.timegap, work))


if __name__ == "__main__":
    main()
