"""Model-predictive control with three states and one input: build once, solve each cycle.

    import numpy as np
    from timegap import mpc

    plan = mpc.Mpc(
        50,
        A=[[1, 0.1, 0], [0, 1, 0.1], [0, 0, 0.8]], B=[0, 0, 0.2],
        Q=np.diag([1.0, 5.0, 0.0]), R=1.0, bounds=(-4.9, 2.0),
    )
    x = np.array([-30.0, 8.0, 0.0])
    for _ in range(20):
        solution = plan.solve(x, shift=1)
        x = solution.states[1]

The problem, with N steps (`shared/mpc-solver` has the method and all symbols):

    minimise    sum_k [ 1/2 x'Qx + q_k'x + (x's) u + 1/2 R u^2 + rho_k u ] + 1/2 x_N'P x_N + p'x_N
    subject to  x_{k+1} = A x_k + B u_k + d_k,  u_min <= u_k <= u_max,  rows g'x_k <= h_k (hard or soft),
                x_N = terminal (if given)

`A` is upper triangular. A system of one or two states gets zeros for the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from . import _timegap

__all__ = ["Light", "Mpc", "Row", "Solution"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """A bound g'x_k <= limit at the stages first to last; soft with a penalty on the violation."""

    gradient: npt.ArrayLike
    limit: float
    first: int = 1
    last: Optional[int] = None
    #: Linear and quadratic penalty; None: the limit holds, or the problem is infeasible.
    soft: Optional[Tuple[float, float]] = None


@dataclass(frozen=True)
class Light:
    """The barrier weight * (1/D - 1/threshold) on margins D_k = c_k'x_k + o_k, which `set_light` sets."""

    weight: float
    threshold: float
    #: Linear penalty of a soft barrier.
    soft: Optional[float] = None


@dataclass(frozen=True)
class Solution:
    """Result of one solve."""

    #: "solved", "infeasible", "iteration limit" or "invalid input".
    status: str
    #: u_0 to u_{N-1}, within their bounds for every status; shape (N,).
    inputs: Array
    #: x_0 to x_N; shape (N + 1, 3).
    states: Array
    #: Factorisations of the horizon or a part of it.
    iterations: int
    objective: float
    #: Scaled residuals of stationarity, complementarity and feasibility.
    residuals: Tuple[float, float, float]

    @property
    def ok(self) -> bool:
        """True if the conditions of optimality hold to 1e-8."""
        return self.status == "solved"


class Mpc:
    """A problem with its solver. Nothing allocates inside a solve but the arrays that it returns."""

    def __init__(
        self,
        horizon: int,
        *,
        A: npt.ArrayLike,
        B: npt.ArrayLike,
        Q: npt.ArrayLike,
        R: float,
        bounds: Tuple[float, float],
        S: Optional[npt.ArrayLike] = None,
        P: Optional[npt.ArrayLike] = None,
        rows: Sequence[Row] = (),
        terminal: Optional[npt.ArrayLike] = None,
        light: Optional[Light] = None,
    ) -> None:
        """Builds the problem. Shapes: A, Q, P (3, 3); B, S, terminal (3,). Raises ValueError if it is not convex."""
        self.horizon = horizon
        given = [
            (
                _vector("gradient", row.gradient),
                row.first,
                horizon if row.last is None else row.last,
                float(row.limit),
                row.soft,
            )
            for row in rows
        ]
        self._mpc = _timegap.Mpc(
            horizon,
            _matrix("A", A),
            _vector("B", B),
            _matrix("Q", Q),
            _vector("S", np.zeros(3) if S is None else S),
            float(R),
            _matrix("P", np.zeros((3, 3)) if P is None else P),
            (float(bounds[0]), float(bounds[1])),
            given,
            None if terminal is None else _vector("terminal", terminal),
            None if light is None else (light.weight, light.threshold, light.soft),
        )

    def set_disturbances(self, d: npt.ArrayLike) -> None:
        """Sets d_k; shape (N, 3)."""
        self._mpc.set_disturbances(_bytes("disturbances", d, (self.horizon, 3)))

    def set_state_gradients(self, q: npt.ArrayLike) -> None:
        """Sets q_k; shape (N, 3)."""
        self._mpc.set_state_gradients(_bytes("state gradients", q, (self.horizon, 3)))

    def set_input_gradients(self, rho: npt.ArrayLike) -> None:
        """Sets rho_k; shape (N,)."""
        self._mpc.set_input_gradients(_bytes("input gradients", rho, (self.horizon,)))

    def set_terminal_gradient(self, p: npt.ArrayLike) -> None:
        """Sets p; shape (3,)."""
        self._mpc.set_terminal_gradient(_vector("p", p))

    def set_terminal(self, target: npt.ArrayLike) -> None:
        """Sets the state at the end of a problem that was built with one; shape (3,)."""
        self._mpc.set_target(_vector("terminal", target))

    def set_row_limits(self, row: int, limits: npt.ArrayLike) -> None:
        """Sets h_k of a row; shape (N + 1,), entry 0 is not used, infinity means no limit."""
        self._mpc.set_row_limits(row, _bytes("limits", limits, (self.horizon + 1,)))

    def set_light(self, gradients: npt.ArrayLike, offsets: npt.ArrayLike) -> None:
        """Sets the margins of stages 1 to K; shapes (K, 3) and (K,). K = 0 switches the barrier off."""
        o = np.asarray(offsets, dtype=float)
        c = np.asarray(gradients, dtype=float).reshape(len(o), 3)
        self._mpc.set_light(np.ascontiguousarray(np.column_stack([c, o])).tobytes())

    def solve(self, x0: npt.ArrayLike, shift: Optional[int] = None) -> Solution:
        """Solves from x0, shape (3,). `shift` starts from the last solution, moved by that number of steps."""
        status, inputs, states = self._mpc.solve(_vector("x0", x0), shift)
        report = self._mpc.report()
        assert report is not None, "it was solved above"
        iterations, objective, *residuals = report
        return Solution(
            status,
            np.frombuffer(inputs),
            np.frombuffer(states).reshape(-1, 3),
            iterations,
            objective,
            (residuals[0], residuals[1], residuals[2]),
        )


def _array(name: str, value: npt.ArrayLike, shape: Tuple[int, ...]) -> Array:
    array = np.asarray(value, dtype=float)
    if array.shape != shape:
        raise ValueError(f"{name} has the shape {array.shape}, expected {shape}")
    return array


def _vector(name: str, value: npt.ArrayLike) -> Any:
    return _array(name, value, (3,)).tolist()


def _matrix(name: str, value: npt.ArrayLike) -> Any:
    return _array(name, value, (3, 3)).tolist()


def _bytes(name: str, value: npt.ArrayLike, shape: Tuple[int, ...]) -> bytes:
    return _array(name, value, shape).tobytes()
