"""Many runs: laws side by side, figures as functions of keys."""

from __future__ import annotations

import copy
import html
import itertools
import json
import os
import pickle
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import cached_property
from typing import TYPE_CHECKING, Any, Union

from . import _figures, _timegap
from ._laws import LawLike, check, laws as own_laws, name_of
from ._options import ScenarioLike
from ._run import Run, run
from ._tables import Table, of_rows, to_pandas, to_polars

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl

Laws = Union[LawLike, Sequence[LawLike], Mapping[str, LawLike]]
"""A law, several, or several under names of their own."""


def _shown(value: object) -> str:
    """A value in a cell."""
    return f"{value:.3g}" if isinstance(value, float) else "" if value is None else str(value)


def _html(names: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """Rows under the names of their columns."""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(_shown(row.get(name)))}</td>" for name in names) + "</tr>" for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"


def _each(seeds: Iterable[int] | None) -> list[int | None]:
    """The seeds; one that is the scenario's own if None."""
    return [None] if seeds is None else [*seeds]


class Rows:
    """Rows of figures with their runs."""

    def __init__(self, rows: list[dict[str, Any]], runs: list[Run] | None, first: Sequence[str]) -> None:
        self.rows = rows
        self.runs = runs
        self._first = first

    @property
    def ok(self) -> bool:
        """Every run completed."""
        return all(row["outcome"] == "completed" for row in self.rows)

    @property
    def table(self) -> Table:
        """The rows as a `pyarrow.Table`, units in the names."""
        return of_rows(self.rows, self._first)

    def to_pandas(self) -> pd.DataFrame:
        """The rows as a pandas DataFrame."""
        return to_pandas(self.table)

    def to_polars(self) -> pl.DataFrame:
        """The rows as a polars DataFrame."""
        return to_polars(self.table)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        completed = sum(row["outcome"] == "completed" for row in self.rows)
        return f"<{type(self).__name__}: {completed} of {len(self.rows)} runs completed>"

    def _repr_html_(self) -> str:
        return _html([*self._first, "outcome", *_figures.shown(self.rows, weight=1)], self.rows)


class Comparison(Rows):
    """Laws side by side on the same scenarios."""

    def __init__(self, rows: list[dict[str, Any]], runs: list[Run] | None, summaries: list[dict[str, Any]]) -> None:
        super().__init__(rows, runs, ["scenario", "law"])
        self._summaries = summaries

    @cached_property
    def _over_seeds(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(_timegap.over_seeds(json.dumps(self._summaries)))
        return found

    @property
    def means(self) -> Table:
        """Figures over the seeds as a `pyarrow.Table`: scenario, law, runs, completed, figure, mean, deviation, n.

        The deviation is that of a sample, and None for one seed. n is the number of seeds for which the figure exists.
        """
        rows = [
            {
                "scenario": of["scenario"],
                "law": of["controller"],
                "runs": of["runs"],
                "completed": of["completed"],
                "figure": figure,
                **spread,
            }
            for of in self._over_seeds["means"]
            for figure, spread in of["figures"].items()
            if spread["n"] > 0
        ]
        return of_rows(rows, ["scenario", "law", "runs", "completed", "figure", "mean", "deviation", "n"])

    @property
    def differences(self) -> Table:
        """Each law minus the first one, seed by seed, as a `pyarrow.Table`; empty for one seed.

        Columns: scenario, law, reference, figure, mean, low, high, n, real, better. `rule` says when a difference is
        called real. With too few seeds low, high and real are None.
        """
        rows = [{"law": one.pop("controller"), **one} for one in map(dict, self._over_seeds["differences"])]
        names = ["scenario", "law", "reference", "figure", "mean", "low", "high", "n", "real", "better"]
        return of_rows(rows, names)

    @property
    def rule(self) -> str | None:
        """When a difference is called real, in words; None for one seed."""
        rule: str | None = self._over_seeds["rule"]
        return rule

    def _repr_html_(self) -> str:
        if self.rule is None:
            return super()._repr_html_()
        real = [one for one in self.differences.to_pylist() if one["real"]]
        names = ["scenario", "law", "reference", "figure", "mean", "low", "high", "n", "better"]
        shown = _html(names, real) if real else "<p>No difference is real.</p>"
        return f"{super()._repr_html_()}{shown}<p>{html.escape(self.rule)}</p>"

    def plot(self, scenario: str | None = None) -> Any:
        """Draws the drives of one scenario, the first if None, over each other; returns the figure."""
        from ._plot import plot

        if self.runs is None:
            raise ValueError("there are no drives to draw, expected compare(..., keep=True)")
        wanted = self.rows[0]["scenario"] if scenario is None else scenario
        drawn = [(row["law"], each) for row, each in zip(self.rows, self.runs) if row["scenario"] == wanted]
        return plot(drawn, None, wanted)


class Sweep(Rows):
    """Figures as functions of keys."""

    def plot(self, figure: str = "min_gap_m", key: str | None = None) -> Any:
        """Draws a figure over a key, the first if None, a curve for each law; returns the matplotlib figure."""
        import matplotlib.pyplot as plt

        key = self._first[1] if key is None else key
        drawing, axis = plt.subplots(layout="constrained")
        for law in dict.fromkeys(row["law"] for row in self.rows):
            points = [(row[key], row.get(figure)) for row in self.rows if row["law"] == law]
            axis.plot(*zip(*points), marker="o", label=law)
        axis.set_xlabel(key)
        axis.set_ylabel(figure)
        axis.legend()
        return drawing


def named(laws: Laws | None) -> dict[str, LawLike]:
    """Laws by name; all of timegap's own that drive cars if None."""
    if laws is None:
        return {law.name: law.name for law in own_laws() if not law.trucks_alone}
    if isinstance(laws, Mapping):
        found = dict(laws)
    else:
        listed: Iterable[LawLike] = laws if isinstance(laws, (list, tuple)) else [laws]  # type: ignore[list-item]
        found = {}
        for law in listed:
            check(law)
            name = name_of(law)
            if name in found:
                raise ValueError(f"two laws are named {name}, expected a dict with a name for each")
            found[name] = law
    for law in found.values():
        check(law)
    return found


Done = tuple[dict[str, Any], Union[Run, None], dict[str, Any]]
"""The row of a run, the run if it is kept, and what a comparison over seeds reads of it."""


def _one(job: tuple[Any, ...]) -> Done:
    first, scenario, name, law, keys, options, keep = job
    own = None if isinstance(law, str) else name
    # Runs at once do not share a law's state.
    result = run(scenario, law if isinstance(law, str) else copy.deepcopy(law), keys, name=own, **options)
    summary = result.summary
    row = {**first, "law": result.law, "outcome": result.outcome, "error": result.error, **result.figures}
    read = {**{key: summary[key] for key in ("controller", "seed", "mode", "outcome")}, "figures": result.figures}
    return row, result if keep else None, read


def _all(jobs: list[tuple[Any, ...]], workers: int | None, processes: bool) -> list[Done]:
    """Does the runs, several at once. An interrupt ends those in progress.

    Python gives it to this thread alone, so the others are told.
    """
    count = max(1, min(len(jobs), workers or os.cpu_count() or 1))
    if count == 1:
        return [_one(job) for job in jobs]
    pool: Executor
    if processes:
        pool = ProcessPoolExecutor(count)
    else:
        pool = ThreadPoolExecutor(count, initializer=_timegap.work_since, initargs=(_timegap.interrupts(),))
    try:
        return list(pool.map(_one, jobs))
    except BaseException:
        _timegap.interrupt_runs()
        raise
    finally:
        pool.shutdown(wait=not processes, cancel_futures=True)


def _can_travel(laws: Mapping[str, LawLike]) -> None:
    """Refuses laws that no other process can have."""
    for name, law in laws.items():
        try:
            pickle.dumps(law)
        except Exception as error:
            expected = "expected a function or class at the top of a module, or processes=False"
            raise TypeError(f"the law {name} cannot go to another process ({error}): {expected}") from None


def compare(
    scenarios: ScenarioLike | Sequence[ScenarioLike],
    laws: Laws | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    seeds: Iterable[int] | None = None,
    keep: bool = True,
    workers: int | None = None,
    processes: bool = False,
) -> Comparison:
    """Drives each scenario with each law.

    Args:
        scenarios: one scenario, or several.
        laws: a law, several, or a dict of names and laws; all of timegap's own that drive cars if None.
        set: keys of every scenario by their dotted paths.
        seeds: seeds with which each is driven; the scenario's own if None.
        keep: keep the runs with their trajectories.
        workers: runs at once; one for each core if None.
        processes: do the runs in other processes; laws in Python are then not bound to one interpreter, and must be
            functions of a module. The runs are not kept.

    Returns:
        A row for each run, in the order of scenarios, laws and seeds. With several seeds `.means` has the figures over
        the seeds. `.differences` has each law against the first one, seed by seed.
    """
    by_name = named(laws)
    if processes:
        _can_travel(by_name)
    listed = [scenarios] if isinstance(scenarios, (str, os.PathLike)) else list(scenarios)
    jobs = []
    for scenario, (name, law), seed in itertools.product(listed, by_name.items(), _each(seeds)):
        first = {"scenario": os.fspath(scenario), "law": name}
        options = {}
        if seed is not None:
            first["seed"] = seed  # type: ignore[assignment]
            options["seed"] = seed
        jobs.append((first, scenario, name, law, set, options, keep and not processes))
    done = _all(jobs, workers, processes)
    runs = [each for _, each, _ in done if each is not None]
    summaries = [{"scenario": row["scenario"], **summary} for row, _, summary in done]
    return Comparison([row for row, _, _ in done], runs if keep and not processes else None, summaries)


def sweep(
    scenario: ScenarioLike,
    param: Mapping[str, Iterable[Any]],
    law: Laws | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    seeds: Iterable[int] | None = None,
    keep: bool = False,
    workers: int | None = None,
    processes: bool = False,
) -> Sweep:
    """Drives a scenario at every point of a grid of keys.

    Args:
        scenario: the scenario.
        param: keys by their dotted paths with the values that they take, such as `{"set_speed_mps": [20, 25]}`.
        law: a law, several, or a dict of names and laws; the scenario's own if None.
        set: other keys by their dotted paths.
        seeds: seeds with which each point is driven; the scenario's own if None.
        keep: keep the runs with their trajectories.
        workers: runs at once; one for each core if None.
        processes: as for `compare`.

    Returns:
        A row for each run: the law, the keys, the figures.
    """
    if not isinstance(param, Mapping) or not param:
        raise TypeError('param is empty or no dict, expected keys with lists of values, such as {"set_speed_mps": [20, 25]}')
    grid = [(key, list(values)) for key, values in param.items()]
    empty = [key for key, values in grid if not values]
    if empty:
        raise ValueError(f"param {empty[0]} has no values, expected one at least")
    by_name: dict[str, LawLike | None] = {"": None} if law is None else {**named(law)}
    if processes:
        _can_travel({name: each for name, each in by_name.items() if each is not None})
    keys = [key for key, _ in grid]
    jobs = []
    for (name, each), point, seed in itertools.product(
        by_name.items(), itertools.product(*(values for _, values in grid)), _each(seeds)
    ):
        first: dict[str, Any] = {"law": name, **dict(zip(keys, point))}
        options = {}
        if seed is not None:
            first["seed"] = seed
            options["seed"] = seed
        together = {**(set or {}), **dict(zip(keys, point))}
        jobs.append((first, scenario, name or None, each, together, options, keep and not processes))
    done = _all(jobs, workers, processes)
    runs = [each for _, each, _ in done if each is not None]
    return Sweep([row for row, _, _ in done], runs if keep and not processes else None, ["law", *keys])
