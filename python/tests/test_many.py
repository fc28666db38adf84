"""Comparisons, sweeps and strings."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import timegap
from laws import Counting, two_seconds


def test_laws_are_compared_side_by_side() -> None:
    found = timegap.compare(
        ["following", "cut-in"], {"mine": two_seconds, "acc": "acc-mpc"}, set={"duration_s": 10}, seeds=[1, 2]
    )
    assert len(found) == 8 and found.ok
    assert found.table.column_names[:2] == ["scenario", "law"]
    assert [row["law"] for row in found.rows[:4]] == ["mine", "mine", "acc-mpc", "acc-mpc"]
    assert all(row["min_gap_m"] > 0.0 for row in found.rows)
    assert found.runs is not None and len(found.runs) == 8
    assert "<table>" in found._repr_html_() and len(found.to_pandas()) == 8


def test_differences_over_seeds_are_judged() -> None:
    found = timegap.compare("cut-in", ["acc-mpc", "six-mode"], set={"duration_s": 12}, seeds=range(1, 11), keep=False)
    means = {(row["law"], row["figure"]): row for row in found.means.to_pylist()}
    gaps = [row["min_gap_m"] for row in found.rows if row["law"] == "six-mode"]
    own = means["six-mode", "min_gap_m"]
    assert own["n"] == 10 and abs(own["mean"] - sum(gaps) / 10) < 1e-9 and own["deviation"] > 0.0
    by_figure = {row["figure"]: row for row in found.differences.to_pylist()}
    gap = by_figure["min_gap_m"]
    assert gap["law"] == "six-mode" and gap["reference"] == "acc-mpc" and gap["n"] == 10
    assert gap["low"] <= gap["mean"] <= gap["high"] and gap["real"] is (gap["low"] > 0.0 or gap["high"] < 0.0)
    assert found.rule is not None and "called real" in found.rule and "called real" in found._repr_html_()
    few = timegap.compare("cut-in", ["acc-mpc", "six-mode"], set={"duration_s": 2}, seeds=[1, 2])
    assert few.differences.num_rows > 0 and set(few.differences["real"].to_pylist()) == {None}
    one = timegap.compare("cut-in", ["acc-mpc"], set={"duration_s": 2})
    assert one.rule is None and one.differences.num_rows == 0


def test_runs_at_once_do_not_share_what_a_law_remembers() -> None:
    alone = timegap.run("following", law=Counting(), duration_s=5).summary["control"]["min_gap_m"]
    found = timegap.compare("following", {"mine": Counting()}, set={"duration_s": 5}, seeds=[1] * 4, workers=4)
    assert {row["min_gap_m"] for row in found.rows} == {alone}


def test_a_grid_of_keys_is_swept() -> None:
    found = timegap.sweep(
        "following",
        {"set_speed_mps": [20, 25], "controller.time_headway_s": [1.2, 1.8, 2.4]},
        law=["acc-mpc"],
        set={"duration_s": 8},
    )
    assert len(found) == 6 and found.runs is None
    assert found.table.column_names[:3] == ["law", "set_speed_mps", "controller.time_headway_s"]
    assert [(row["set_speed_mps"], row["controller.time_headway_s"]) for row in found.rows][:3] == [
        (20, 1.2),
        (20, 1.8),
        (20, 2.4),
    ]
    assert timegap.sweep("following", {"set_speed_mps": [20]}, set={"duration_s": 2}).rows[0]["law"] != ""


def test_runs_in_other_processes_give_the_same_figures() -> None:
    here = timegap.compare("following", {"mine": two_seconds}, set={"duration_s": 3}, seeds=[1, 2])
    there = timegap.compare("following", {"mine": two_seconds}, set={"duration_s": 3}, seeds=[1, 2], processes=True)
    assert there.rows == here.rows and there.runs is None


def test_a_string_mixes_laws() -> None:
    found = timegap.string("following", 4, [two_seconds, "acc-mpc"], duration_s=20)
    laws = found.vehicles["controller"].to_pylist()
    assert laws == ["two_seconds", "acc-mpc", "two_seconds", "acc-mpc"]
    assert len(found.runs) == 4 and found.summary["head_to_tail_gain"] is not None
    ahead = found.runs[1].trajectory["lead_speed_mps"].drop_null().to_numpy()
    first = found.runs[0].trajectory["speed_mps"].to_numpy()
    assert abs(ahead.mean() - first.mean()) < 0.1, "the second car follows the first one's motion"


SLEEPLESS = """
import timegap
print("begun", flush=True)
timegap.sweep("following", {"seed": range(1, 100_000)}, workers=%d)
"""


@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_ends_a_long_sweep(workers: int) -> None:
    program = subprocess.Popen(
        [sys.executable, "-c", SLEEPLESS % workers], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert program.stdout is not None and program.stdout.readline() == "begun\n"
    program.send_signal(signal.SIGINT)
    _, words = program.communicate(timeout=60)
    assert "KeyboardInterrupt" in words, words
    assert program.returncode in (1, -signal.SIGINT, 130)


SLOW = """
import time, timegap
def slow(q):
    time.sleep(0.01)
    return 0.0
print("begun", flush=True)
timegap.sweep("udds", {"set_speed_mps": list(range(15, 40))}, slow, workers=2)
"""


@pytest.mark.parametrize("wait_s", [0.0, 1.0])
def test_ctrl_c_does_not_wait_for_slow_runs(wait_s: float) -> None:
    program = subprocess.Popen(
        [sys.executable, "-c", SLOW], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert program.stdout is not None and program.stdout.readline() == "begun\n"
    time.sleep(wait_s)
    program.send_signal(signal.SIGINT)
    # A run of its own takes 137 s.
    _, words = program.communicate(timeout=60)
    assert "KeyboardInterrupt" in words, words


@pytest.fixture(scope="module")
def command() -> str:
    """The command line; tests of both need it."""
    found = os.environ.get("TIMEGAP_COMMAND")
    if not found or not Path(found).exists():
        pytest.skip("TIMEGAP_COMMAND does not name the command line")
    return found


def test_digests_and_figures_are_the_command_lines(command: str, tmp_path: Path) -> None:
    import json

    for scenario, law in (("following", "acc-mpc"), ("cacc-a", "cacc-mpc"), ("cut-in", "six-mode")):
        options = [command, "run", scenario, "--controller", law, "--mode", "lockstep", "--in-process", "--json", "--digests"]
        printed = subprocess.run([*options, "--out", str(tmp_path / scenario)], capture_output=True, check=False)
        there = json.loads(printed.stdout)
        here = timegap.run(scenario, law=law, digests=True)
        topics = {topic: counts["digests"] for topic, counts in there["messages"].items()}
        assert any(topics.values())
        assert {topic: counts["digests"] for topic, counts in here.summary["messages"].items()} == topics
        assert here.summary["control"] == there["control"]
        on_disk = timegap.open(tmp_path / scenario)
        assert isinstance(on_disk, timegap.Recorded)
        assert on_disk.trajectory.column_names == here.trajectory.column_names
        assert on_disk.to_pandas()["speed_mps"].tolist() == here.to_pandas()["speed_mps"].tolist()
        assert on_disk.outcome == here.outcome and on_disk.ok == here.ok


def test_the_results_of_a_study_are_opened(command: str, tmp_path: Path) -> None:
    options = ["compare", "following", "cut-in", "--controllers", "acc-mpc", "--set", "duration_s=2"]
    subprocess.run([command, *options, "--out", str(tmp_path / "study")], capture_output=True, check=True)
    study = timegap.open(tmp_path / "study")
    assert isinstance(study, timegap.Study) and study.name == "compare" and study.ok
    assert len(study.results["rows"]) == 2 and study.table("runs").num_rows == 2
    figures = list(timegap.run("following", set={"duration_s": 1}).figures)
    assert study.table("runs").column_names[-len(figures) :] == figures
    assert "runs" in study.tables and "compare" in repr(study)
    with pytest.raises(KeyError, match="expected one of"):
        study.table("run")


def test_a_recording_is_read_by_topic(command: str, tmp_path: Path) -> None:
    options = ["run", "following", "--mode", "lockstep", "--duration", "3", "--out", str(tmp_path / "run")]
    subprocess.run([command, *options], capture_output=True, check=True)
    recorded = timegap.open(tmp_path / "run")
    assert isinstance(recorded, timegap.Recorded)
    assert recorded.topics["radar/tracks"] > 30
    tracks = recorded.topic("radar/tracks")
    assert tracks.num_rows == recorded.topics["radar/tracks"]
    assert "log_time_s" in tracks.column_names and any(name.endswith("range_m") for name in tracks.column_names)
    detections = recorded.topic("radar/detections", list="detections")
    assert detections.num_rows > recorded.topics["radar/detections"]
    odometry = recorded.topic("vehicle/odometry")
    assert odometry["speed_mps"].to_numpy().min() > 10.0
    with pytest.raises(KeyError, match="expected one of"):
        recorded.topic("radar/track")
    alone = timegap.open(tmp_path / "run" / "recording.mcap")
    assert isinstance(alone, timegap.Recorded)
    assert alone.topic("vehicle/odometry").equals(odometry)
    (tmp_path / "broken.mcap").write_bytes(b"no recording")
    with pytest.raises(timegap.RunError):
        broken = timegap.open(tmp_path / "broken.mcap")
        assert isinstance(broken, timegap.Recorded) and broken.topics


def test_a_row_has_the_figures_of_the_run() -> None:
    found = timegap.compare("cut-in", ["acc-mpc"], set={"duration_s": 5})
    assert found.runs is not None
    row, run = found.rows[0], found.runs[0]
    names = list(run.figures)
    assert list(row)[-len(names) :] == names
    assert row["min_gap_m"] == run.summary["control"]["min_gap_m"]
    assert row["data_age_p50_ms"] == run.summary["timing"]["data_age_us"]["p50"] / 1e3
    assert isinstance(row["interventions"], int) and row["fuel_l_per_100km"] is None
