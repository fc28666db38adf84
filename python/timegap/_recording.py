"""Results on disk."""

from __future__ import annotations

import json
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Union

from . import _timegap
from ._run import Results
from ._tables import Table, of_typed
from ._timegap import RunError


class Recorded(Results):
    """A run on disk: a directory of results, or a recording alone."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def summary(self) -> dict[str, Any]:
        """`summary.json` of the run. Units are in the names; a figure that does not apply is None."""
        summary: dict[str, Any] = json.loads(self._file("summary.json").read_text(encoding="utf-8"))
        return summary

    @cached_property
    def trajectory(self) -> Table:
        """The drive as a `pyarrow.Table`: a row for each step of the vehicle, units in the names."""
        from pyarrow import float64

        file = self._file("trajectory.csv")
        names = file.open(encoding="utf-8").readline().strip().split(",")
        return _csv(file, {name: float64() for name in names})

    @cached_property
    def topics(self) -> dict[str, int]:
        """The topics of the recording, with their numbers of messages."""
        return dict(self._recording.topics())

    def topic(self, name: str, list: str | None = None) -> Table:
        """The messages of a topic as a `pyarrow.Table`, a row for each.

        Nested arrays count from 0: `tracks.0.range_m`. `log_time_s` is the time of publication in the run.

        Args:
            name: the topic, such as `radar/tracks`.
            list: one of the message's long lists, such as `detections` of `radar/detections`: a row for each entry.
        """
        return of_typed(self._recording.topic(name, list))

    @cached_property
    def _recording(self) -> _timegap.Recording:
        return _timegap.Recording(fspath(self.path))

    def _file(self, name: str) -> Path:
        file = (self.path if self.path.is_dir() else self.path.parent) / name
        if not file.is_file():
            raise RunError(f"{file} is missing, expected a directory of results of `timegap run`")
        return file


class Study:
    """Results of a study on disk, such as of `timegap compare --out DIR`."""

    def __init__(self, path: Path, file: Path) -> None:
        self.path = path
        self.name = file.stem
        """The study's command."""
        self.results: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        """The study's JSON as a dict. Units are in the names."""

    @property
    def ok(self) -> bool:
        """The study met what it asks for."""
        return bool(self.results["ok"])

    @property
    def tables(self) -> list[str]:
        """Names of the study's tables."""
        return sorted(file.stem for file in self.path.glob("*.csv"))

    def table(self, name: str = "runs") -> Table:
        """A table as a `pyarrow.Table`: `runs` has a row for each drive, with its figures."""
        if name not in self.tables:
            raise KeyError(f"no table {name}, expected one of {', '.join(self.tables)}")
        return _csv(self.path / f"{name}.csv", {})

    def __repr__(self) -> str:
        return f"<Study {self.name}: {'ok' if self.ok else 'not ok'}, tables {', '.join(self.tables)}>"


def _csv(file: Path, types: dict[str, Any]) -> Table:
    from pyarrow import csv

    return csv.read_csv(file, convert_options=csv.ConvertOptions(column_types=types))


def _study(path: Path) -> Study | None:
    """The study whose results stand in a directory."""
    files = [file for file in path.glob("*.json") if (path / "runs.csv").is_file() and file.name != "part.json"]
    return Study(path, min(files, key=lambda file: len(file.name))) if files else None


def open(path: Union[str, "PathLike[str]"]) -> Recorded | Study:
    """Opens a directory of results of a run or of a study, or a run's recording.

    Raises:
        RunError: there is none of them.
    """
    found = Path(path)
    if not found.exists():
        raise RunError(f"{found} does not exist, expected a directory of results or a recording (.mcap)")
    if not found.is_dir() or any((found / name).is_file() for name in ("summary.json", "recording.mcap")):
        return Recorded(found)
    study = _study(found)
    if study is None:
        raise RunError(f"{found} has no results, expected summary.json, recording.mcap, or runs.csv and a study's JSON")
    return study
