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
    assert terminated and not truncated and info["outcome"] == "collision" and reward < -100.0
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
