"""Strings of cars."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _timegap
from ._compare import Laws, named
from ._options import ScenarioLike, scenario as open_scenario
from ._run import Run
from ._tables import Table, of_rows, to_pandas

if TYPE_CHECKING:
    import pandas as pd


class String:
    """A string of cars that was driven: each behind the true motion of the car before it."""

    def __init__(self, results: dict[str, Any], runs: list[Run]) -> None:
        self.summary = results
        self.runs = runs

    @property
    def ok(self) -> bool:
        """Every car completed, and none amplified the disturbance."""
        completed = all(car["outcome"] == "completed" for car in self.summary["vehicles"])
        return completed and bool(self.summary["string_stable"])

    @property
    def vehicles(self) -> Table:
        """A row for each car, first to last, as a `pyarrow.Table`: law, gains, smallest gap."""
        return of_rows(self.summary["vehicles"])

    def to_pandas(self) -> pd.DataFrame:
        """The cars as a pandas DataFrame."""
        return to_pandas(self.vehicles)

    def plot(self, axes: Any = None) -> Any:
        """Draws speed, gap and acceleration of all cars; returns the figure."""
        from ._plot import plot

        drawn = [(f"car {number}", each) for number, each in enumerate(self.runs, 1)]
        return plot(drawn, axes, self.summary["scenario"])

    def __repr__(self) -> str:
        gain = self.summary["head_to_tail_gain"]
        shown = "" if gain is None else f", head-to-tail gain {gain:.3f}"
        stable = "string stable" if self.summary["string_stable"] else "not string stable"
        return f"<String of {len(self.runs)} cars: {stable}{shown}>"


def string(
    scenario: ScenarioLike,
    vehicles: int,
    law: Laws | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    seed: int | None = None,
    duration_s: float | None = None,
) -> String:
    """Drives cars one behind the other.

    Args:
        scenario: what the first car meets.
        vehicles: number of cars.
        law: a law, or several, which are repeated along the string; the scenario's own if None.
        set: keys that all cars have in common.
        seed: seed of the first car; each of the others has its own.
        duration_s: length of the run, s.
    """
    by_name = {None: None} if law is None else {**named(law)}
    opened = [
        open_scenario(scenario, each, set, law_name=None if isinstance(each, str) else name, seed=seed, duration_s=duration_s)
        for name, each in by_name.items()
    ]
    laws = list(by_name.values())
    whole = _timegap.CarString(opened, vehicles)
    runs: list[Run] = []
    while (car := whole.next()) is not None:
        each = laws[len(runs) % len(laws)]
        driven = _timegap.drive(car, None if each is None or isinstance(each, str) else each)
        whole.drove(car, driven)
        runs.append(Run(driven))
    return String(json.loads(whole.results()), runs)
