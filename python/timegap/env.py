"""timegap as an environment of Gymnasium: the agent is the control law.

    import timegap

    env = timegap.Env("following")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step([0.5])

`gymnasium.make("timegap.env:timegap/Drive-v0", scenario="cut-in")` and `gymnasium.make_vec` make the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from . import _timegap
from ._options import ScenarioLike, scenario as open_scenario
from ._run import Run
from ._timegap import Question

__all__ = ["Env", "observe", "picture", "reward_parts"]

FARTHEST_M = 250.0
"""Gap in an observation without a target, m."""

OBSERVATION = gymnasium.spaces.Box(
    low=np.array([0, -15, 0, 0, 0, -150, -15], dtype=np.float32),
    high=np.array([150, 15, 150, 1, FARTHEST_M, 150, 15], dtype=np.float32),
)
"""Speed, m/s; acceleration, m/s²; set speed, m/s; 1 with a target ahead; gap, m; relative speed, m/s; acceleration of
the target, m/s²."""


def observe(q: Question) -> NDArray[np.float32]:
    """The observation of `OBSERVATION`, within its bounds."""
    values = np.array(q.observation(FARTHEST_M), dtype=np.float32)
    return np.clip(values, OBSERVATION.low, OBSERVATION.high, out=values)


def reward_parts(q: Question, request_mps2: float, outcome: str | None, failure_cost: float) -> dict[str, float]:
    """The parts of a step's reward, which is their sum.

    - `error`: -e², e the smaller of two errors: (v_set - v) / v_set, and the gap's (d - d_0) / d_0 with
      d_0 = 5 m + 1.5 s v, each at most 1 in size.
    - `request`: -0.01 u², u the request in m/s², within its bounds.
    - `failure`: -`failure_cost` where the run ends other than completed.
    """
    wanted_mps = max(min(q.set_speed_mps, q.speed_limit_mps), 1.0)
    desired_m = 5.0 + 1.5 * q.speed_mps
    error = min((wanted_mps - q.speed_mps) / wanted_mps, (q.gap_m - desired_m) / desired_m)
    error = min(max(error, -1.0), 1.0)
    failure = 0.0 if outcome in (None, "completed") else -failure_cost
    return {"error": -error * error, "request": -0.01 * request_mps2 * request_mps2, "failure": failure}


def picture(q: Question) -> NDArray[np.uint8]:
    """The road ahead from above, two pixels a metre: ego, target and stop lines. Below it bars for speed and set speed."""
    drawn = np.full((80, 560, 3), 245, dtype=np.uint8)
    drawn[10:50] = (90, 90, 90)

    def box(x_m: float, length_m: float, rows: slice, colour: tuple[int, int, int]) -> None:
        from_px, to_px = (min(max(round(2 * (20 + at_m)), 0), 560) for at_m in (x_m, x_m + length_m))
        drawn[rows, from_px:to_px] = colour

    for distance_m in q.signals["distance_m"]:
        box(float(distance_m), 1.0, slice(10, 50), (255, 255, 255))
    box(-5.0, 5.0, slice(26, 34), (40, 110, 220))
    if q.has_target:
        box(q.gap_m, 5.0, slice(26, 34), (210, 60, 50))
    box(0.0, 5.0 * q.speed_mps, slice(56, 64), (40, 110, 220))
    box(0.0, 5.0 * q.set_speed_mps, slice(68, 72), (120, 120, 120))
    return drawn


class Env(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A drive of which each step is a control period. The action is the requested acceleration in m/s².

    An episode ends truncated when the scenario is over, and terminated by a collision or another failure. The last
    step's observation is that of the question before: a run that is over asks nothing. `info` has `time_s`, the
    emergency brake's `interventions` so far, and `reward_parts`. At the end `info["run"]` has the whole run with its
    trajectory. A failure costs more than any episode that is completed, however badly it is driven.

    An environment can be copied and pickled between episodes.

    Args:
        scenario: name of a built-in scenario, or the path of a file.
        set: keys of the scenario by their dotted paths.
        normalized: the action is from -1 (hardest braking) through 0 to 1 (hardest acceleration).
        observation: makes the observation of a question; `observe` by default.
        observation_space: the space of these observations; `OBSERVATION` by default.
        reward: makes the reward of the question after a step, the request within its bounds, and the outcome of a run
            that is over; the sum of `reward_parts` by default.
        render_mode: `rgb_array` for pictures of the road by `render()`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        scenario: ScenarioLike = "following",
        set: Mapping[str, Any] | None = None,
        *,
        normalized: bool = False,
        observation: Callable[[Question], Any] = observe,
        observation_space: gymnasium.Space[Any] = OBSERVATION,
        reward: Callable[[Question, float, str | None], float] | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode is {render_mode!r}, expected None or 'rgb_array'")
        self.render_mode = render_mode
        self._normalized = normalized
        self._observe = observation
        self._reward = reward
        self._name, self._set = scenario, dict(set or {})
        self._open()
        self.observation_space = observation_space
        self._run: _timegap.Stepper | None = None
        self._question: Question | None = None

    def _open(self) -> None:
        self._scenario = open_scenario(self._name, _agent, self._set, law_name="agent")
        self._low_mps2, self._high_mps2 = self._scenario.request_bounds_mps2
        low, high = (-1.0, 1.0) if self._normalized else (self._low_mps2, self._high_mps2)
        self.action_space = gymnasium.spaces.Box(low, high, shape=(1,), dtype=np.float32)

    def __getstate__(self) -> dict[str, Any]:
        if self._run is not None:
            raise TypeError("an episode is in progress and cannot be copied, expected close() or the episode's end first")
        return {key: value for key, value in self.__dict__.items() if key not in ("_scenario", "_question")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._question = None
        self._open()

    @property
    def question(self) -> Question:
        """The question that waits for an action."""
        if self._question is None:
            raise RuntimeError("no episode is in progress, expected reset() first")
        return self._question

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode.

        Args:
            seed: seed of the sensors' noise; without one each episode has another.
            options: `scenario` and `set` replace those of the environment from now on.
        """
        super().reset(seed=seed)
        unknown = [key for key in options or {} if key not in ("scenario", "set")]
        if unknown:
            raise ValueError(f"options has {unknown[0]!r}, expected scenario and set")
        if options:
            self._name = options.get("scenario", self._name)
            self._set = dict(options.get("set", self._set))
            self._open()
        drawn = int(self.np_random.integers(1, 2**31)) if seed is None else seed
        self._run = _timegap.Stepper(self._scenario.with_seed(drawn))
        question = self._run.start()
        if question is None:
            raise _timegap.RunError("the run ended before its first control period")
        self._question = question
        worst_mps2 = max(-self._low_mps2, self._high_mps2)
        steps = self._scenario.duration_s / question.period_s + 1.0
        # No completed episode costs as much: an error of 1 and the largest request in each step.
        self._failure_cost = (1.0 + 0.01 * worst_mps2 * worst_mps2) * steps
        return self._observe(question), {"time_s": question.time_s, "interventions": 0}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Requests an acceleration, m/s², for one control period."""
        if self._run is None:
            raise RuntimeError("no episode is in progress, expected reset() first")
        request_mps2 = self._request_mps2(action)
        following = self._run.step(request_mps2)
        if following is not None:
            self._question = following
            value, info = self._rewarded(following, request_mps2, None)
            return self._observe(following), value, False, False, info
        last = self.question
        ended = Run(self._run.finish())
        value, info = self._rewarded(last, request_mps2, ended.outcome)
        self._run = None
        info.update(run=ended, outcome=ended.outcome)
        return self._observe(last), value, not ended.ok, ended.ok, info

    def _request_mps2(self, action: Any) -> float:
        """The request of an action, within its bounds."""
        try:
            value = float(action[0])
        except (TypeError, IndexError):
            value = float(action)
        if self._normalized:
            value *= self._high_mps2 if value > 0.0 else -self._low_mps2
        return float(np.clip(value, self._low_mps2, self._high_mps2))

    def _rewarded(self, q: Question, request_mps2: float, outcome: str | None) -> tuple[float, dict[str, Any]]:
        """The reward of a step, and what `info` says of it."""
        assert self._run is not None
        info: dict[str, Any] = {"time_s": q.time_s, "interventions": self._run.interventions()}
        if self._reward is not None:
            return self._reward(q, request_mps2, outcome), info
        info["reward_parts"] = parts = reward_parts(q, request_mps2, outcome, self._failure_cost)
        return sum(parts.values()), info

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the road ahead, with `render_mode="rgb_array"`."""
        return None if self.render_mode is None else picture(self.question)

    def close(self) -> None:
        """Ends the episode in progress."""
        self._run = None


def _agent(q: Question) -> float:
    raise RuntimeError("an environment's agent is asked step by step")


def _register() -> None:
    name = "timegap/Drive-v0"
    if name not in gymnasium.registry:
        gymnasium.register(id=name, entry_point="timegap.env:Env")


_register()
