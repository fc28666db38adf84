"""Each wrong input has one clear error, with its place and what was expected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import timegap
from laws import Counting, two_seconds


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (None, "returned None"),
        ("fast", "returned 'fast'"),
        (True, "returned True"),
        (np.zeros(3), "an array of shape (3,)"),
        ([1.0], "a value of type list"),
        ({}, "a value of type dict"),
    ],
)
def test_what_is_no_request_is_named(returned: Any, words: str) -> None:
    run = timegap.run("following", law=lambda q: returned)
    assert run.outcome == "aborted" and isinstance(run.exception, TypeError)
    assert run.error is not None and words in run.error, run.error
    assert "expected a number in m/s², or timegap.Answer" in run.error


@pytest.mark.parametrize("request_mps2", [float("nan"), float("inf"), np.float64("nan")])
def test_a_request_that_no_vehicle_can_follow_ends_the_run(request_mps2: float) -> None:
    run = timegap.run("following", law=lambda q: request_mps2)
    assert run.outcome == "aborted"
    assert run.error is not None and "expected a finite number" in run.error, run.error


@pytest.mark.parametrize("request_mps2", [np.float32(0.1), np.int64(0), np.array(0.1), 0, -3])
def test_numbers_of_every_kind_are_requests(request_mps2: Any) -> None:
    assert timegap.run("following", law=lambda q: request_mps2, duration_s=1).error is None


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (lambda: 0.0, "takes one argument"),
        (lambda q, gain: 0.0, "takes one argument"),
        (Counting, "not an object of it"),
        (3.0, "expected a callable"),
    ],
)
def test_what_cannot_be_asked_is_refused_before_the_run(law: Any, words: str) -> None:
    with pytest.raises(TypeError, match=words):
        timegap.run("following", law=law)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"set_sped_mps": 25}, "did you mean `set_speed_mps`"),
        ({"plant.period_ms": -10}, "expected a period from 1 to 10000"),
        ({"controller.name": "cac-mpc"}, "did you mean `cacc-mpc`"),
        ({"no key": 1}, "names joined by dots"),
        ({"schema_version": 2}, "version 2 of the schema is not known"),
    ],
)
def test_a_wrong_key_is_shown_with_its_place(keys: dict[str, Any], words: str) -> None:
    with pytest.raises(timegap.ScenarioError) as raised:
        timegap.run("following", set=keys)
    assert words in str(raised.value), raised.value
    assert str(raised.value).startswith("set: ") and "--" not in str(raised.value)


def test_other_wrong_arguments_are_refused(tmp_path: Path) -> None:
    with pytest.raises(timegap.ScenarioError, match="did you mean `?following"):
        timegap.run("folowing")
    with pytest.raises(timegap.ScenarioError, match="^law: acc-mcp(.|\n)*did you mean `acc-mpc`"):
        timegap.run("following", law="acc-mcp")
    with pytest.raises(TypeError, match="cannot be a key's value"):
        timegap.run("following", set={"seed": object()})
    with pytest.raises(TypeError, match="expected a dict"):
        timegap.run("following", set=[("seed", 1)])  # type: ignore[arg-type]
    with pytest.raises(timegap.ScenarioError, match="a law of timegap's own"):
        timegap.run("following", law=two_seconds, name="acc-mpc")
    with pytest.raises(timegap.RunError, match="does not exist"):
        timegap.open(tmp_path / "none")
    with pytest.raises(timegap.RunError, match="has no results"):
        timegap.open(tmp_path)
    with pytest.raises(ValueError, match="expected at most 96"):
        timegap.Answer(0.0, plan_mps2=[0.0] * 97)
    with pytest.raises(ValueError, match="expected at most 7"):
        timegap.Answer(0.0, mode=8)


def test_a_lambda_cannot_go_to_another_process() -> None:
    with pytest.raises(TypeError, match="expected a function or class at the top of a module"):
        timegap.compare("following", {"mine": lambda q: 0.0}, processes=True)


def test_a_sweep_without_values_is_refused() -> None:
    with pytest.raises(TypeError, match="expected keys with lists of values"):
        timegap.sweep("following", {})
    with pytest.raises(ValueError, match="has no values"):
        timegap.sweep("following", {"set_speed_mps": []})
    with pytest.raises(ValueError, match="expected a dict with a name for each"):
        timegap.compare("following", [two_seconds, two_seconds])
