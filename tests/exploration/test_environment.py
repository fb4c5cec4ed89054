"""The Gymnasium environment."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.environment import NAME, ImageGoalNavigation
from tutorial_lib.world.noise import FORWARD, LEFT, STOP


@pytest.mark.parametrize("sensor", ["rgbd", "rgb"])
def test_gymnasium_s_checker_is_content(sensor):
    environment = gymnasium.make(NAME, worlds=(10_100,), sensor=sensor, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environment.unwrapped)


def test_the_same_seed_and_actions_give_the_same_episode():
    rolled = []
    for _ in range(2):
        environment = gymnasium.make(NAME, worlds=(10_100, 10_101), difficulty="hard")
        seen, _ = environment.reset(seed=11)
        states = [seen["goal_image"]]
        for action in (FORWARD, LEFT, FORWARD, FORWARD):
            seen, *_ = environment.step(action)
            states += [seen["image"], seen["odometry"], seen["depth"]]
        rolled.append(states)
    assert all(np.array_equal(a, b) for a, b in zip(*rolled, strict=True))
    other, _ = environment.reset(seed=12)
    assert not np.array_equal(other["goal_image"], states[0])


def test_stop_terminates_with_the_spl_as_reward():
    environment = gymnasium.make(NAME, worlds=(10_100,), difficulty="easy")
    environment.reset(seed=0)
    _, reward, terminated, truncated, info = environment.step(STOP)
    assert (reward, terminated, truncated) == (0.0, True, False)  # 1 m away at least
    assert info == {"success": False, "spl": 0.0, "steps": 1}


def test_an_episode_is_truncated_after_500_steps():
    environment = gymnasium.make(NAME, worlds=(10_100,)).unwrapped
    environment.reset(seed=0)
    for step in range(500):
        _, _, terminated, truncated, info = environment.step(LEFT)
        assert not terminated
        assert truncated == (step == 499)
    assert info["steps"] == 500


def test_nothing_that_is_returned_says_where_the_robot_or_the_goal_is():
    environment = gymnasium.make(NAME, worlds=(10_100,))
    seen, info = environment.reset(seed=0)
    assert set(seen) == {"image", "goal_image", "depth", "goal_depth", "odometry"}
    assert set(info) == {"success", "spl", "steps"}
    assert not seen["odometry"].any()


def test_the_reward_is_the_spl_once_and_nothing_else_pays():
    environment = gymnasium.make(NAME, worlds=(10_100,), noise=False).unwrapped
    environment.reset(seed=3)
    task = environment._task
    task.poses = task.goal_poses.copy()  # a robot at its goal
    rewards = [environment.step(action)[1] for action in (LEFT, LEFT, STOP)]
    assert rewards == [0.0, 0.0, 1.0]
    with pytest.raises(InputError, match="the episode is over; call reset"):
        environment.step(STOP)
    environment.reset(seed=3)
    assert environment.step(LEFT)[1:4] == (0.0, False, False)


def test_nothing_is_done_before_reset():
    environment = gymnasium.make(NAME, worlds=(10_100,), render_mode="rgb_array").unwrapped
    for call in (environment.render, lambda: environment.step(LEFT)):
        with pytest.raises(InputError, match="call reset first"):
            call()
    seen, _ = environment.reset(seed=0)
    assert np.array_equal(environment.render(), seen["image"])


def test_wrong_input_is_refused():
    with pytest.raises(InputError, match="sensor: 'sonar' is unknown"):
        gymnasium.make(NAME, sensor="sonar")
    with pytest.raises(InputError, match="signs: 'neon' is unknown"):
        gymnasium.make(NAME, signs="neon")
    with pytest.raises(InputError, match="difficulty: 'huge' is unknown"):
        gymnasium.make(NAME, worlds=(10_100,), difficulty="huge")
    with pytest.raises(InputError, match="render_mode: 'human' is unknown"):
        ImageGoalNavigation(render_mode="human")
    for worlds in ((), 5, ("a",), (1.7,), (-1,)):
        with pytest.raises(InputError, match=r"worlds: .* give seeds"):
            gymnasium.make(NAME, worlds=worlds)
