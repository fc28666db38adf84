"""timegap.mpc: solutions are optimal, bad shapes are refused, the notebook runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from timegap import mpc

A, B = [[1, 0.1, 0], [0, 1, 0.1], [0, 0, 0.8]], [0, 0, 0.2]


def build(**more: Any) -> mpc.Mpc:
    return mpc.Mpc(30, A=A, B=B, Q=np.diag([1.0, 5.0, 0.0]), R=1.0, bounds=(-4.9, 2.0), **more)


def test_a_solution_follows_the_dynamics_and_is_optimal() -> None:
    plan = build()
    solution = plan.solve([-10.0, 0.0, 0.0])
    assert solution.ok and max(solution.residuals) < 1e-8
    assert solution.inputs.shape == (30,) and solution.states.shape == (31, 3)
    steps = solution.states[:-1] @ np.array(A).T + np.outer(solution.inputs, B)
    assert np.allclose(steps, solution.states[1:], atol=1e-12)
    assert solution.inputs.max() <= 2.0 and solution.inputs.min() >= -4.9
    # No other inputs near it cost less.
    rng = np.random.default_rng(1)

    def cost(u: Any) -> float:
        x, total = np.array([-10.0, 0.0, 0.0]), 0.0
        for value in u:
            total += 0.5 * (x[0] ** 2 + 5 * x[1] ** 2 + value**2)
            x = np.array(A) @ x + np.array(B) * value
        return float(total)

    best = cost(solution.inputs)
    assert best == pytest.approx(solution.objective)
    for _ in range(100):
        other = np.clip(solution.inputs + 1e-3 * rng.standard_normal(30), -4.9, 2.0)
        assert cost(other) >= best


def test_rows_hold_and_soft_ones_give_way() -> None:
    row = mpc.Row([0, 1, 0], limit=1.0)
    hard = build(rows=[row]).solve([-10.0, 0.0, 0.0])
    assert hard.ok and hard.states[1:, 1].max() <= 1.0 + 1e-7
    infeasible = build(rows=[row]).solve([-10.0, 9.0, 0.0])
    assert infeasible.status == "infeasible"
    soft = mpc.Row([0, 1, 0], limit=1.0, soft=(1e3, 0.0))
    assert build(rows=[soft]).solve([-10.0, 9.0, 0.0]).ok


def test_a_warm_start_gives_the_same_solution() -> None:
    plan = build()
    x = np.array([-10.0, 3.0, 0.0])
    for _ in range(10):
        warm, cold = plan.solve(x, shift=1), build().solve(x)
        assert np.allclose(warm.inputs, cold.inputs, atol=1e-7)
        x = warm.states[1]


def test_many_active_rows_are_solved_in_every_object() -> None:
    # The ball on a plate of S. Richter's dissertation (2012), section 9.6.1, with its state bounds active.
    box = [([1, 0, 0], 0.01), ([-1, 0, 0], 0.2), ([0, 1, 0], 0.1), ([0, -1, 0], 0.1)]
    plate = dict(A=[[1, 0.01, 0], [0, 1, 0], [0, 0, 0]], B=[-0.0004, -0.0701, 0], R=1.0)
    cost = np.diag([100.0, 10.0, 0.0])
    kept = []
    for _ in range(4):
        rows = [mpc.Row(gradient, limit) for gradient, limit in box]
        plan = mpc.Mpc(25, Q=cost, P=cost, bounds=(-0.0524, 0.0524), rows=rows, **plate)  # type: ignore[arg-type]
        kept.append(plan)
        x = np.array([-0.15, 0.0, 0.0])
        for _ in range(100):
            solution = plan.solve(x)
            assert solution.ok and max(solution.residuals) < 1e-8, (x, solution)
            x = solution.states[1]


def test_bad_input_is_one_clear_error() -> None:
    with pytest.raises(ValueError, match=r"x0 has the shape \(2,\), expected \(3,\)"):
        build().solve([1, 2])
    with pytest.raises(ValueError, match=r"disturbances has the shape"):
        build().set_disturbances(np.zeros((3, 3)))
    with pytest.raises(ValueError):
        mpc.Mpc(30, A=[[1, 0, 0], [1, 1, 0], [0, 0, 1]], B=B, Q=np.eye(3), R=1.0, bounds=(-1, 1))
    with pytest.raises(ValueError, match="row 4 of 0"):
        build().set_row_limits(4, np.zeros(31))
    assert build().solve([np.nan, 0, 0]).status == "invalid input"


def test_the_notebook_of_solvers_runs(capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(__file__).parents[2] / "examples" / "mpc_solvers.ipynb"
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    exec(compile(code, file.name, "exec"), {})
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert any(line[:1] == ["timegap.mpc"] and line[3] == "60/60" for line in lines), lines
