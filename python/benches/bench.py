"""The package's three goals, measured: `.ci/python bench`. On a busy machine read the smallest times.

| goal | limit |
| --- | --- |
| `run` of 60 s with a trivial law in Python | 20 ms |
| a step of `Env` | 20 µs |
| throughput of two threads over one, laws of timegap's own | 1.8 |
"""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable

import numpy as np
import timegap


def times(work: Callable[[], object], count: int) -> list[float]:
    """Times of `count` calls behind one that is not counted, s."""
    work()
    found = []
    for _ in range(count):
        begun = time.perf_counter()
        work()
        found.append(time.perf_counter() - begun)
    return found


def row(what: str, values: list[float], unit: str, limit: float, is_least: bool = False) -> None:
    best = max(values) if is_least else min(values)
    met = best >= limit if is_least else best <= limit
    sign = "≥" if is_least else "≤"
    median = statistics.median(values)
    verdict = "met" if met else "MISSED"
    print(f"{what:<44} {best:>8.2f} {median:>8.2f} {unit:<3} {sign} {limit:<5} n={len(values):<3} {verdict}")


def trivial(q: timegap.Question) -> float:
    return 0.0


def following(q: timegap.Question) -> float:
    free = 0.4 * (q.set_speed_mps - q.speed_mps)
    return min(free, 0.2 * (q.gap_m - 5.0 - 2.0 * q.speed_mps) + 0.7 * q.relative_speed_mps)


def episode(env: timegap.Env) -> tuple[float, int]:
    """Time of all steps of an episode, s, and their number."""
    env.reset(seed=1)
    steps, action = 0, np.zeros(1, dtype=np.float32)
    begun = time.perf_counter()
    while True:
        action[0] = following(env.question)
        _, _, terminated, truncated, _ = env.step(action)
        steps += 1
        if terminated or truncated:
            return time.perf_counter() - begun, steps


def ratio() -> float:
    """Runs a second of two threads over those of one."""

    def work() -> None:
        for _ in range(4):
            timegap.run("following", law="acc-mpc", set={"duration_s": 60})

    begun = time.perf_counter()
    work()
    work()
    alone = time.perf_counter() - begun
    threads = [threading.Thread(target=work) for _ in range(2)]
    begun = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return alone / (time.perf_counter() - begun)


def main() -> None:
    print(f"{'what':<44} {'best':>8} {'median':>8}")
    whole = [1e3 * each for each in times(lambda: timegap.run("following", law=trivial, set={"duration_s": 60}), 15)]
    row("run of 60 s, trivial law", whole, "ms", 20.0)
    own = [1e3 * each for each in times(lambda: timegap.run("following", law=following, set={"duration_s": 60}), 15)]
    row("run of 60 s, law of two lines", own, "ms", 20.0)
    env = timegap.Env("following", {"duration_s": 60})
    episode(env)
    steps = [1e6 * total / count for total, count in (episode(env) for _ in range(15))]
    row("step of Env", steps, "µs", 20.0)
    ratio()
    row("throughput of two threads", [ratio() for _ in range(5)], "", 1.8, is_least=True)


if __name__ == "__main__":
    main()
