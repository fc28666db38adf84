"""Figures of a drive, as the extension declares them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Union

from . import _timegap

Value = Union[int, float, None]
"""A figure's value; None where it does not apply."""


class Figure(NamedTuple):
    """A figure of a drive."""

    name: str
    """Name, with the unit."""
    unit: str
    """Unit; empty for a count."""
    decimals: int
    """Decimals for people; 0 for a count."""
    weight: int
    """Those of small weight matter most."""
    meaning: str
    """Meaning in a few words."""


ALL = [Figure(*figure) for figure in _timegap.figures()]
"""All figures, in the order of `runs.csv`."""


def of(summary: Mapping[str, Any]) -> dict[str, Value]:
    """The figures of a run by its summary."""
    values = dict(_timegap.figures_of(json.dumps(summary)))
    return {one.name: _number(one, values[one.name]) for one in ALL}


def shown(rows: Sequence[Mapping[str, Any]], weight: int) -> list[str]:
    """The figures of at most this weight that one of the rows has."""
    light = [one.name for one in ALL if one.weight <= weight]
    return [name for name in light if any(row.get(name) is not None for row in rows)]


def _number(figure: Figure, value: float | None) -> Value:
    return int(value) if value is not None and figure.decimals == 0 else value
