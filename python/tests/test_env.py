"""The environment of Gymnasium."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

import timegap
from laws import two_seconds


def test_the_environment_keeps_gymnasiums_rules() -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*[Bb]ox action space.*")
        check_env(timegap.Env("following", {"duration_s": 3}), skip_render_check=True)
        check_env(timegap.Env("following", {"duration_s": 3}, normalized=True), skip_render_check=True)


@pytest.mark.parametrize("scenario", ["tight-brake", "tight-cut-in"])
def test_a_collision_is_worse_than_any_safe_episode(scenario: str) -> None:
    def drive(action: float) -> tuple[str, float, int]:
        env, total, steps = timegap.Env(scenario, {"aebs.enabled": False}), 0.0, 0
        env.reset(seed=1)
        while True:
            _, reward, terminated, truncated, info = env.step([action])
            total, steps = total + float(reward), steps + 1
            parts = info["reward_parts"]
            assert abs(sum(parts.values()) - reward) < 1e-9 and parts["request"] >= -0.01 * 6.0**2
            if terminated or truncated:
                return info["outcome"], total, steps

    outcome, crashed, _ = drive(99.0)
    assert outcome == "collision"
    outcome, stood, steps = drive(-99.0)
    assert outcome == "completed" and crashed < stood
    # An error of 1 and the hardest braking in each step.
    assert crashed <= -(1.0 + 0.01 * 6.0**2) * steps


def test_interventions_of_the_emergency_brake_are_in_info() -> None:
    env = timegap.Env("tight-cut-in")
    _, info = env.reset(seed=1)
    assert info["interventions"] == 0
    while True:
        _, _, terminated, truncated, info = env.step([0.0])
        if terminated or truncated:
            break
    assert info["interventions"] == info["run"].summary["aebs"]["interventions"] > 0


def test_a_normalized_action_is_a_share_of_the_bounds() -> None:
    def first(env: timegap.Env, action: float) -> float:
        env.reset(seed=1)
        return float(env.step([action])[4]["reward_parts"]["request"])

    plain, share = timegap.Env("following"), timegap.Env("following", normalized=True)
    bounds, shares = plain.action_space, share.action_space
    assert isinstance(bounds, gymnasium.spaces.Box) and isinstance(shares, gymnasium.spaces.Box)
    assert shares.low[0] == -1.0 and shares.high[0] == 1.0
    low, high = float(bounds.low[0]), float(bounds.high[0])
    for action, request in [(0.0, 0.0), (1.0, high), (-1.0, low), (0.5, high / 2), (-0.5, low / 2)]:
        assert abs(first(share, action) - first(plain, request)) < 1e-6
    assert abs(first(plain, 99.0) - first(plain, high)) < 1e-6, "the cost is that of the clipped request"


def test_pictures_show_ego_and_target() -> None:
    env = timegap.Env("following", render_mode="rgb_array")
    env.reset(seed=1)
    env.step([0.0])
    drawn = env.render()
    assert drawn is not None and drawn.shape == (80, 560, 3) and drawn.dtype == np.uint8
    reds = np.argwhere((drawn[30] == (210, 60, 50)).all(axis=1)).ravel()
    assert env.question.has_target and abs(reds[0] - 2 * (20 + env.question.gap_m)) <= 1
    assert timegap.Env("following").render() is None
    with pytest.raises(ValueError, match="expected None or 'rgb_array'"):
        timegap.Env("following", render_mode="human")


def test_an_environment_is_copied_between_episodes_and_not_within_one() -> None:
    import copy
    import pickle

    env = timegap.Env("following", {"duration_s": 1})
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        ours, theirs = env.reset(seed=3)[0], other.reset(seed=3)[0]
        assert np.array_equal(ours, theirs)
        with pytest.raises(TypeError, match="an episode is in progress"):
            copy.copy(env)
        with pytest.raises(TypeError, match="an episode is in progress"):
            pickle.dumps(env)
        env.close()


def test_an_episode_is_the_run_of_the_same_law() -> None:
    env = timegap.Env("following", {"duration_s": 20})
    env.reset(seed=7)
    total, steps, ended = 0.0, 0, False
    while not ended:
        action = np.array([two_seconds(env.question)], dtype=np.float64)
        _, reward, terminated, truncated, info = env.step(action)
        total, steps, ended = total + float(reward), steps + 1, terminated or truncated
    assert steps == 201 and truncated and not terminated and total < 0.0
    run = timegap.run("following", law=two_seconds, set={"duration_s": 20}, seed=7)
    assert info["run"].summary["control"]["min_gap_m"] == run.summary["control"]["min_gap_m"]
    assert info["run"].trajectory["speed_mps"].equals(run.trajectory["speed_mps"])


def test_a_collision_terminates_and_costs() -> None:
    env = timegap.Env("following", {"aebs.enabled": False})
    env.reset(seed=1)
    for _ in range(2000):
        _, reward, terminated, truncated, info = env.step([4.0])
        if terminated or truncated:
            break
    assert terminated and not truncated and info["outcome"] == "collision" and reward < -600.0
    with pytest.raises(RuntimeError, match="expected reset"):
        env.step([0.0])


def test_a_reset_in_the_middle_begins_anew_and_takes_options() -> None:
    env = timegap.Env("following")
    first, _ = env.reset(seed=3)
    env.step([1.0])
    again, _ = env.reset(seed=3)
    assert np.array_equal(first, again)
    other, _ = env.reset(seed=3, options={"scenario": "cut-in", "set": {"set_speed_mps": 20}})
    assert not np.array_equal(first, other) and other[2] == 20.0
    with pytest.raises(ValueError, match="expected scenario and set"):
        env.reset(options={"scenaro": "cut-in"})
    env.close()


def test_observation_and_reward_are_replaceable() -> None:
    space = gymnasium.spaces.Box(-np.inf, np.inf, shape=(2,), dtype=np.float64)
    env = timegap.Env(
        "following",
        observation=lambda q: np.array([q.speed_mps, q.time_s]),
        observation_space=space,
        reward=lambda q, request_mps2, outcome: -abs(request_mps2),
    )
    observation, _ = env.reset(seed=1)
    assert observation.shape == (2,) and space.contains(observation)
    assert env.step([0.5])[1] == -0.5


def test_environments_are_vectorised_by_name() -> None:
    name = "timegap.env:timegap/Drive-v0"
    for mode in ("sync", "async"):
        envs = gymnasium.make_vec(name, num_envs=2, vectorization_mode=mode, scenario="following", set={"duration_s": 2})
        observations, _ = envs.reset(seed=1)
        assert observations.shape == (2, 7)
        for _ in range(30):
            observations, rewards, _, truncated, _ = envs.step(np.zeros((2, 1), dtype=np.float32))
        assert observations.shape == (2, 7) and rewards.shape == (2,)
        envs.close()
