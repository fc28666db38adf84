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

__all__ = ["Env", "observe", "reward"]

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


def reward(q: Question, request_mps2: float, outcome: str | None) -> float:
    """The reward of a step.

    -e² - 0.01 u², where u is the request in m/s² and e the smaller of two errors: (v_set - v) / v_set, and the gap's
    (d - d_0) / d_0 with d_0 = 5 m + 1.5 s v, each at most 1 in size. -100 where the run ends other than completed.
    """
    wanted_mps = max(min(q.set_speed_mps, q.speed_limit_mps), 1.0)
    desired_m = 5.0 + 1.5 * q.speed_mps
    error = min((wanted_mps - q.speed_mps) / wanted_mps, (q.gap_m - desired_m) / desired_m)
    error = min(max(error, -1.0), 1.0)
    penalty = 0.0 if outcome in (None, "completed") else 100.0
    return -error * error - 0.01 * request_mps2 * request_mps2 - penalty


class Env(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A drive of which each step is a control period. The action is the requested acceleration in m/s².

    An episode ends truncated when the scenario is over, and terminated by a collision or another failure. The last
    step's observation is that of the question before: a run that is over asks nothing. `info["run"]` then has the
    whole run with its trajectory.

    Args:
        scenario: name of a built-in scenario, or the path of a file.
        set: keys of the scenario by their dotted paths.
        observation: makes the observation of a question; `observe` by default.
        observation_space: the space of these observations; `OBSERVATION` by default.
        reward: makes the reward of the question after a step, the request, and the outcome of a run that is over;
            `reward` by default.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        scenario: ScenarioLike = "following",
        set: Mapping[str, Any] | None = None,
        *,
        observation: Callable[[Question], Any] = observe,
        observation_space: gymnasium.Space[Any] = OBSERVATION,
        reward: Callable[[Question, float, str | None], float] = reward,
        render_mode: str | None = None,
    ) -> None:
        self.render_mode = render_mode
        self._observe = observation
        self._reward = reward
        self._name, self._set = scenario, dict(set or {})
        self._open()
        self.observation_space = observation_space
        self._run: _timegap.Stepper | None = None
        self._question: Question | None = None

    def _open(self) -> None:
        self._scenario = open_scenario(self._name, _agent, self._set, law_name="agent")
        low, high = self._scenario.request_bounds_mps2
        self.action_space = gymnasium.spaces.Box(low, high, shape=(1,), dtype=np.float32)

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
        return self._observe(question), {"time_s": question.time_s}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Requests an acceleration, m/s², for one control period."""
        if self._run is None:
            raise RuntimeError("no episode is in progress, expected reset() first")
        try:
            request_mps2 = float(action[0])
        except (TypeError, IndexError):
            request_mps2 = float(action)
        following = self._run.step(request_mps2)
        if following is not None:
            self._question = following
            value = self._reward(following, request_mps2, None)
            return self._observe(following), value, False, False, {"time_s": following.time_s}
        last = self.question
        ended = Run(self._run.finish())
        self._run = None
        info = {"time_s": last.time_s, "run": ended, "outcome": ended.outcome}
        value = self._reward(last, request_mps2, ended.outcome)
        return self._observe(last), value, not ended.ok, ended.ok, info

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
