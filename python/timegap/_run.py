"""One run."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import _figures, _timegap
from ._laws import LawLike, check
from ._options import ScenarioLike, scenario as open_scenario
from ._tables import Table, of_floats, of_rows, to_pandas, to_polars

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl


_BRAKING, _HOLDING = 2.0, 3.0
"""States of the emergency brake in the trajectory."""


class Results:
    """Common part of runs in memory and runs on disk."""

    @property
    def summary(self) -> dict[str, Any]:
        """`summary.json` of the run. Units are in the names; a figure that does not apply is None."""
        raise NotImplementedError

    @property
    def trajectory(self) -> Table:
        """The drive as a `pyarrow.Table`: a row for each step of the vehicle, units in the names."""
        raise NotImplementedError

    @property
    def modes(self) -> list[str]:
        """Names of the law's modes, in the order of the numbers in the trajectory's column `mode`."""
        return []

    @cached_property
    def figures(self) -> dict[str, _figures.Value]:
        """Figures of the drive by name, as in `runs.csv`; one that does not apply is None."""
        return _figures.of(self.summary)

    @property
    def ok(self) -> bool:
        """The run came to its end and kept what the scenario requires."""
        return self.outcome == "completed"

    @property
    def outcome(self) -> str:
        """`completed`, `collision`, `red_light`, `safe_stop`, `driven_by_backup` or `aborted`."""
        return str(self.summary["outcome"])

    @property
    def error(self) -> str | None:
        """Why the run was aborted, with the traceback of a law in Python; None otherwise."""
        why = self.summary.get("aborted_because")
        return None if why is None else str(why)

    @property
    def scenario(self) -> str:
        """Name of the scenario."""
        return str(self.summary["scenario"])

    @property
    def law(self) -> str:
        """Name of the law."""
        return str(self.summary["controller"])

    @property
    def events(self) -> Table:
        """Events, as a `pyarrow.Table`: `t_s`, `kind` (mode, brake, fault, end), `what`, `why`."""
        changes = self.summary["control"].get("mode_changes") or []
        rows = [
            {"t_s": change["t_s"], "kind": "mode", "what": f"{change['from']} -> {change['to']}", "why": change["reason"]}
            for change in changes
        ]
        rows += [{"t_s": t_s, "kind": "brake", "what": "emergency braking"} for t_s in self._interventions_s()]
        for fault in self.summary.get("faults") or []:
            target = fault.get("service") or fault.get("topic") or ""
            rows.append({"t_s": fault.get("t_s"), "kind": "fault", "what": f"{fault.get('kind')} {target}".strip()})
        rows.append({"t_s": self.summary["duration_s"], "kind": "end", "what": self.outcome, "why": self.error})
        rows.sort(key=lambda row: float("inf") if row["t_s"] is None else row["t_s"])
        return of_rows(rows, ["t_s", "kind", "what", "why"])

    def _interventions_s(self) -> list[float]:
        """Times at which the emergency brake began to brake."""
        if not self.summary["aebs"]["interventions"]:
            return []
        times_s, states = (self.trajectory[name].to_pylist() for name in ("time_s", "brake_state"))
        # Not every step has a message of the brake.
        seen = [(t_s, state in (_BRAKING, _HOLDING)) for t_s, state in zip(times_s, states) if state is not None]
        return [t_s for (t_s, now), (_, before) in zip(seen, [(0.0, False), *seen]) if now and not before]

    def to_pandas(self) -> pd.DataFrame:
        """The trajectory as a pandas DataFrame."""
        return to_pandas(self.trajectory)

    def to_polars(self) -> pl.DataFrame:
        """The trajectory as a polars DataFrame."""
        return to_polars(self.trajectory)

    def plot(self, axes: Any = None) -> Any:
        """Draws speed, gap and acceleration over time with matplotlib.

        Args:
            axes: three axes to draw on; new ones if None.

        Returns:
            The figure.
        """
        from ._plot import plot

        return plot([(self.law, self)], axes, self.scenario)

    def __repr__(self) -> str:
        gap, braked = self.figures["min_gap_m"], self.figures["interventions"]
        shown = "" if gap is None else f", min_gap_m={gap:.2f}"
        shown += f", interventions={braked}" if braked else ""
        return f"<{type(self).__name__} {self.scenario}, {self.law}: {self.outcome}{shown}>"

    def _repr_html_(self) -> str:
        """A table for notebooks."""
        rows = [("law", self.law), ("outcome", self.outcome), ("duration_s", self.summary["duration_s"])]
        rows += [(name, f"{self.figures[name]:.3g}") for name in _figures.shown([self.figures], weight=2)]
        if self.error is not None:
            rows.append(("error", self.error))
        lines = "".join(f"<tr><th>{_cell(name)}</th><td>{_cell(value)}</td></tr>" for name, value in rows)
        return f"<table><caption>{html.escape(self.scenario)}</caption>{lines}</table>"


def _cell(value: object) -> str:
    """A value in a cell; of several lines as they are."""
    text = html.escape(str(value))
    return f"<pre>{text}</pre>" if "\n" in text else text


class Run(Results):
    """A run of this process, with its results in memory."""

    def __init__(self, driven: _timegap.Driven) -> None:
        self._driven = driven

    def __reduce__(self) -> tuple[Any, ...]:
        """Part that goes to another process: the results, without the exception, whose traceback is in `error`."""
        return _Copied, (self.summary, self.trajectory, self.modes)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """`summary.json` of the run. Units are in the names; a figure that does not apply is None."""
        summary: dict[str, Any] = json.loads(self._driven.summary())
        return summary

    @cached_property
    def trajectory(self) -> Table:
        """The drive as a `pyarrow.Table`: a row for each step of the vehicle, units in the names."""
        return of_floats(self._driven.trajectory())

    @property
    def modes(self) -> list[str]:
        """Names of the law's modes, in the order of the numbers in the trajectory's column `mode`."""
        return self._driven.modes

    @property
    def exception(self) -> BaseException | None:
        """The exception of the law that ended the run."""
        return self._driven.exception


class _Copied(Run):
    """A run of another process."""

    def __init__(self, summary: dict[str, Any], trajectory: Table, modes: list[str]) -> None:
        self.summary = summary
        self.trajectory = trajectory
        self._modes = modes

    @property
    def modes(self) -> list[str]:
        return self._modes

    @property
    def exception(self) -> BaseException | None:
        return None


def run(
    scenario: ScenarioLike,
    law: LawLike | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    name: str | None = None,
    seed: int | None = None,
    duration_s: float | None = None,
    digests: bool = False,
) -> Run:
    """Drives a scenario in simulated time.

    Args:
        scenario: name of a built-in scenario, or the path of a file.
        law: name of one of timegap's laws, or a law of yours; the scenario's own if None.
        set: keys of the scenario by their dotted paths, such as `{"set_speed_mps": 25}`.
        name: name of your law in results; that of its function or class if None.
        seed: seed of all random numbers.
        duration_s: length of the run, s.
        digests: compute the digests of all messages, which are those of the command line.

    Returns:
        The run. An exception in the law ends it with the outcome `aborted` and the traceback in `error`.

    Raises:
        ScenarioError: the scenario, a key or a value is wrong.
        TypeError: the law cannot be called with a question.
    """
    check(law) if law is not None else None
    opened = open_scenario(scenario, law, set, law_name=name, seed=seed, duration_s=duration_s)
    own = None if law is None or isinstance(law, str) else law
    return Run(_timegap.drive(opened, own, digests))
