"""Laws: their form, and their names."""

from __future__ import annotations

import inspect
import re
from typing import Any, Callable, NamedTuple, Union

from . import _timegap
from ._timegap import Answer, Question

LawLike = Union[str, Callable[[Question], Union[float, Answer]]]
"""The name of one of timegap's own laws, or a law of yours: a callable that takes a question and returns a request in
m/s², or an `Answer`. An object with a method `reset()` is told when it is to forget its history."""


class LawInfo(NamedTuple):
    """One of timegap's own laws."""

    name: str
    description: str
    source: str
    trucks_alone: bool


class ScenarioInfo(NamedTuple):
    """A built-in scenario."""

    name: str
    description: str


def laws() -> list[LawInfo]:
    """timegap's own laws."""
    return [LawInfo(*law) for law in _timegap.laws()]


def scenarios() -> list[ScenarioInfo]:
    """The built-in scenarios."""
    return [ScenarioInfo(*scenario) for scenario in _timegap.scenarios()]


def name_of(law: LawLike, name: str | None = None) -> str:
    """Name of a law in results: `name`, else that of its function or class."""
    if name is not None:
        return name
    if isinstance(law, str):
        return law
    own = getattr(law, "__name__", None) or type(law).__name__
    known = {info.name for info in laws()} | {"external"}
    own = re.sub(r"[^A-Za-z0-9_-]+", "", own)[:64] or "law"
    return f"{own}-python" if own in known else own


def check(law: Any) -> None:
    """Refuses what cannot be called with one question.

    Raises:
        TypeError: what was found, and what was expected.
    """
    if isinstance(law, str):
        return
    expected = "expected a callable that takes one argument, the question"
    if isinstance(law, type):
        raise TypeError(f"the law is the class {law.__name__}, not an object of it: {expected}")
    if not callable(law):
        raise TypeError(f"the law is {type(law).__name__} {law!r}: {expected}")
    try:
        signature = inspect.signature(law)
    except (TypeError, ValueError):
        return  # Some built-in functions have no signature.
    try:
        signature.bind(None)
    except TypeError:
        raise TypeError(f"the law {name_of(law)}{signature} cannot be called so: {expected}") from None
