"""timegap: an adaptive-cruise stack in simulated time, with your own law in Python.

    import timegap

    def law(q: timegap.Question) -> float:
        '''Keeps a time gap of two seconds; m/s².'''
        free = 0.4 * (q.set_speed_mps - q.speed_mps)
        follow = 0.2 * (q.gap_m - 5.0 - 2.0 * q.speed_mps) + 0.7 * q.relative_speed_mps
        return min(free, follow)

    run = timegap.run("following", law=law)
    print(run.outcome, run.summary["control"]["min_gap_m"])
    run.plot()

A run has no wall clock: it repeats to the byte. Units are in the names.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._compare import Comparison, Sweep, compare, sweep
from ._laws import LawInfo, LawLike, ScenarioInfo, laws, scenarios
from ._recording import Recorded, Study, open
from ._run import Run, run
from ._string import String, string
from ._timegap import Answer, Question, RunError, ScenarioError, __version__

if TYPE_CHECKING:
    from .env import Env

__all__ = [
    "Answer",
    "Comparison",
    "Env",
    "LawInfo",
    "LawLike",
    "Question",
    "Recorded",
    "Run",
    "RunError",
    "ScenarioError",
    "ScenarioInfo",
    "String",
    "Study",
    "Sweep",
    "__version__",
    "compare",
    "laws",
    "open",
    "run",
    "scenarios",
    "string",
    "sweep",
]


def __getattr__(name: str) -> object:
    # Gymnasium is an optional dependency: it is imported when an environment is asked for.
    if name == "Env":
        from .env import Env

        return Env
    raise AttributeError(f"module 'timegap' has no attribute {name!r}")
