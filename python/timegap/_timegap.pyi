"""The compiled part."""

from typing import Any, Callable, Union

import numpy as np
from numpy.typing import NDArray

__version__: str

class ScenarioError(ValueError):
    """A scenario, a key or a value is wrong. The message shows the place and what was expected."""

class RunError(RuntimeError):
    """A run cannot begin, or its results cannot be read."""

class Question:
    """Inputs of a law at one control period. Arrays are views: nothing is copied before a law asks for it."""

    @property
    def time_s(self) -> float:
        """Time of the release since the start of the run, s."""
    @property
    def period_s(self) -> float:
        """Control period, s."""
    @property
    def is_reset(self) -> bool:
        """The law is to forget all history before it answers."""
    @property
    def position_m(self) -> float:
        """Distance travelled since the start of the run, m."""
    @property
    def speed_mps(self) -> float:
        """Speed, m/s, never negative."""
    @property
    def acceleration_mps2(self) -> float:
        """Acceleration, m/s²."""
    @property
    def set_speed_mps(self) -> float:
        """Driver's set speed, m/s."""
    @property
    def speed_limit_mps(self) -> float:
        """Legal limit on this road, m/s; infinite when unknown."""
    @property
    def has_target(self) -> bool:
        """There is a vehicle ahead."""
    @property
    def target_id(self) -> int:
        """Identity of the target; 0 without one. A new number means a new vehicle."""
    @property
    def gap_m(self) -> float:
        """Bumper-to-bumper distance to the target, m; infinite without one."""
    @property
    def relative_speed_mps(self) -> float:
        """Target speed minus ego speed, m/s, negative when closing; 0 without a target."""
    @property
    def target_acceleration_mps2(self) -> float:
        """Absolute acceleration of the target, m/s²; 0 without one."""
    @property
    def target_age_s(self) -> float:
        """Age of the sample behind the target, s."""
    @property
    def signals(self) -> NDArray[Any]:
        """Signals ahead, nearest first: a structured array with `id`, `distance_m`, `interval_count`, `intervals`.

        An interval has `phase` (0 unknown, 1 green, 2 yellow, 3 red) and `ends_in_s`.
        """
    @property
    def has_powertrain(self) -> bool:
        """The vehicle is a truck; the next four fields are 0 otherwise."""
    @property
    def gear(self) -> int:
        """Gear, counted from 1; the one being engaged during a shift."""
    @property
    def since_shift_s(self) -> float:
        """Time since the last shift began, s."""
    @property
    def engine_torque_nm(self) -> float:
        """Torque at the crankshaft, N m."""
    @property
    def grade(self) -> float:
        """The vehicle's own estimate of the grade under it, rise over run."""
    @property
    def first_cell_m(self) -> float:
        """Where the first cell of the road ahead starts, m, as `position_m`."""
    @property
    def cell_m(self) -> float:
        """Length of a cell of the road ahead, m."""
    @property
    def cell_grades(self) -> NDArray[np.float64]:
        """Mean grade of each cell of the road ahead, rise over run."""
    def observation(self, farthest_m: float) -> tuple[float, float, float, float, float, float, float]:
        """Speed, acceleration, set speed, 1 with a target, gap, relative speed, acceleration of the target."""

class Answer:
    """An answer with more than a request."""

    def __new__(
        cls,
        request_mps2: float,
        *,
        plan_mps2: Any = None,
        mode: int = 0,
        figures: Any = None,
        engine_torque_nm: float | None = None,
        service_brake_n: float = 0.0,
        gear: int = 0,
    ) -> Answer:
        """Makes an answer.

        Args:
            request_mps2: requested acceleration, m/s².
            plan_mps2: requests for the control periods that follow, m/s², at most 96: the vehicle follows them if no
                answer comes.
            mode: mode of the law, 0 to 7, for people.
            figures: at most 8 figures of the law's own, for people.
            engine_torque_nm: torque that a truck's engine is asked for, N m.
            service_brake_n: force of a truck's service brakes at the wheels, N.
            gear: gear to engage, counted from 1; 0 leaves it to the gearbox.
        """
    @property
    def request_mps2(self) -> float:
        """The request that acts now, m/s²."""

class Scenario:
    def __new__(
        cls,
        name: str,
        set: list[str] = ...,
        controller: str | None = None,
        seed: str | None = None,
        duration: str | None = None,
        own: str | None = None,
    ) -> Scenario: ...
    @property
    def name(self) -> str: ...
    @property
    def controller(self) -> str: ...
    @property
    def duration_s(self) -> float: ...
    @property
    def request_bounds_mps2(self) -> tuple[float, float]: ...
    @property
    def notices(self) -> list[str]: ...
    def with_seed(self, seed: int) -> Scenario: ...
    def to_toml(self) -> str: ...

class Driven:
    @property
    def modes(self) -> list[str]: ...
    @property
    def exception(self) -> BaseException | None: ...
    def summary(self) -> str: ...
    def trajectory(self) -> list[tuple[str, bytes]]: ...

class Recording:
    def __new__(cls, path: str) -> Recording: ...
    def topics(self) -> list[tuple[str, int]]: ...
    def topic(self, name: str, list: str | None = None) -> list[tuple[str, str, bytes]]: ...

class Stepper:
    def __new__(cls, scenario: Scenario) -> Stepper: ...
    def start(self) -> Question | None: ...
    def step(self, answer: float | Answer) -> Question | None: ...
    def interventions(self) -> int: ...
    def finish(self) -> Driven: ...

class CarString:
    def __new__(cls, laws: list[Scenario], vehicles: int) -> CarString: ...
    def next(self) -> Scenario | None: ...
    def drove(self, scenario: Scenario, driven: Driven) -> None: ...
    def results(self) -> str: ...

def drive(
    scenario: Scenario, law: Callable[[Question], Union[float, Answer]] | None = None, digests: bool = False
) -> Driven: ...
def interrupt_runs() -> None: ...
def interrupts() -> int: ...
def work_since(interrupts: int) -> None: ...
def over_seeds(rows: str) -> str: ...
def figures() -> list[tuple[str, str, int, int, str]]: ...
def figures_of(summary: str) -> list[tuple[str, Union[float, None]]]: ...
def scenarios() -> list[tuple[str, str]]: ...
def laws() -> list[tuple[str, str, str, bool]]: ...

class Mpc:
    """A problem with its solver; timegap.mpc documents it."""

    def __init__(
        self,
        horizon: int,
        a: list[list[float]],
        b: list[float],
        q: list[list[float]],
        s: list[float],
        r: float,
        p: list[list[float]],
        bounds: tuple[float, float],
        rows: list[tuple[list[float], int, int, float, tuple[float, float] | None]],
        terminal: list[float] | None,
        light: tuple[float, float, float | None] | None,
    ) -> None: ...
    def set_target(self, target: list[float]) -> None: ...
    def set_terminal_gradient(self, gradient: list[float]) -> None: ...
    def set_disturbances(self, bytes: bytes) -> None: ...
    def set_state_gradients(self, bytes: bytes) -> None: ...
    def set_input_gradients(self, bytes: bytes) -> None: ...
    def set_row_limits(self, row: int, bytes: bytes) -> None: ...
    def set_light(self, bytes: bytes) -> None: ...
    def solve(self, x0: list[float], shift: int | None) -> tuple[str, bytes, bytes]: ...
    def report(self) -> tuple[int, float, float, float, float] | None: ...
