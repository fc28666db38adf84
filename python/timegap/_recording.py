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
        from pyarrow import csv, float64

        file = self._file("trajectory.csv")
        names = file.open(encoding="utf-8").readline().strip().split(",")
        types = {name: float64() for name in names}
        return csv.read_csv(file, convert_options=csv.ConvertOptions(column_types=types))

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


def open(path: Union[str, "PathLike[str]"]) -> Recorded:
    """Opens a run's directory of results, or its recording.

    Raises:
        RunError: there is neither.
    """
    found = Path(path)
    if not found.exists():
        raise RunError(f"{found} does not exist, expected a directory of results or a recording (.mcap)")
    if found.is_dir() and not any((found / name).is_file() for name in ("summary.json", "recording.mcap")):
        raise RunError(f"{found} has neither summary.json nor recording.mcap, expected a directory of results")
    return Recorded(found)
