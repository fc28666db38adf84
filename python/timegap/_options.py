"""Values of Python as keys of a scenario."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any, Union

from . import _timegap
from ._laws import LawLike, name_of

ScenarioLike = Union[str, "PathLike[str]"]
"""The name of a built-in scenario, or the path of a file."""


def toml(value: Any) -> str:
    """A value as TOML."""
    if hasattr(value, "tolist"):
        value = value.tolist()  # numpy
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        # JSON's strings are TOML's basic strings, but for characters beyond the first plane.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        keys = ", ".join(f"{json.dumps(str(key))} = {toml(item)}" for key, item in value.items())
        return f"{{ {keys} }}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    if isinstance(value, PathLike):
        return toml(fspath(value))
    expected = "expected a number, a text, a truth value, or a list or dict of them"
    raise TypeError(f"a value of type {type(value).__name__} cannot be a key's value: {expected}")


def assignments(keys: Mapping[str, Any] | None) -> list[str]:
    """Keys as arguments of `--set`."""
    if keys is None:
        return []
    if not isinstance(keys, Mapping):
        raise TypeError(f"set is {type(keys).__name__}, expected a dict of keys and values")
    return [f"{key}={toml(value)}" for key, value in keys.items()]


def scenario(
    name: ScenarioLike,
    law: LawLike | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    law_name: str | None = None,
    seed: int | None = None,
    duration_s: float | None = None,
) -> _timegap.Scenario:
    """Opens a scenario and lays the arguments over it.

    Raises:
        ScenarioError: the place, and what was expected.
    """
    is_own = law is not None and not isinstance(law, str)
    return _timegap.Scenario(
        fspath(name),
        set=assignments(set),
        controller=law if isinstance(law, str) else None,
        seed=None if seed is None else toml(seed),
        duration=None if duration_s is None else toml(duration_s),
        own=name_of(law, law_name) if is_own and law is not None else None,
    )
