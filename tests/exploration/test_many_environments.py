"""Many episodes in lock-step, as a vector environment of Gymnasium."""

from copy import deepcopy

import gymnasium
import numpy as np
import pytest

from tutorial_lib.environments import IMAGE_GOAL as NAME
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.many_environments import ManyImageGoalNavigations
from tutorial_lib.exploration.rewards import Rewards
from tutorial_lib.world.noise import FORWARD, LEFT, STOP

WORLDS = (10_100, 10_101)


def make(count=3, **more):
    return gymnasium.make_vec(NAME, num_envs=count, worlds=WORLDS, **more)


def test_gymnasium_makes_it_and_its_observations_fit_the_space():
    many = make(difficulty="easy")
    assert isinstance(many.unwrapped, ManyImageGoalNavigations)
    seen, _ = many.reset(seed=0)
    assert many.observation_space.contains(seen)
    one = gymnasium.make(NAME, worlds=WORLDS)
    assert one.observation_space == many.unwrapped.single_observation_space
    seen, rewards, ended, truncated, info = many.step(np.array([FORWARD, LEFT, FORWARD]))
    assert many.observation_space.contains(seen)
    assert not np.any([rewards, ended, truncated])
    assert info["steps"].tolist() == [1, 1, 1]


@pytest.mark.full
def test_the_same_seed_and_actions_give_the_same_episodes_through_resets():
    rolled = []
    for _ in range(2):
        many, states = make(), []
        many.reset(seed=5)
        for step in range(12):
            actions = np.array([STOP if step in (3, 8) else FORWARD, LEFT, FORWARD])
            seen, rewards, *_ = many.step(actions)
            states += [seen["image"], seen["goal_depth"], seen["odometry"], rewards]
        rolled.append(states)
    assert all(np.array_equal(a, b) for a, b in zip(*rolled, strict=True))


@pytest.mark.parametrize("sensor", ["rgbd", "rgb"])
@pytest.mark.few(1)
def test_each_is_an_environment_of_its_own_to_the_last_bit(sensor):
    many = make(5, reward="shaped", sensor=sensor)
    first, _ = many.reset(seed=4)
    task, sources = many.unwrapped._task, many.unwrapped._drawn.sources
    assert len(set(task.episodes.worlds)) == 2

    def begin(robot, noise):
        """An environment with the present episode of a robot, and its noise."""
        one = gymnasium.make(NAME, worlds=WORLDS, sensor=sensor).unwrapped
        world, episode = task.episodes.worlds[robot], task.episodes[robot : robot + 1]
        one._drawn.draw = lambda options, rng: (world, task.scenes[world], episode)
        one._rewards = Rewards("shaped", sources)
        seen, _ = one.reset()
        one._task._noise = noise
        return one, seen

    singles = []
    for robot, stream in enumerate(task._noise._streams):
        one, seen = begin(robot, None)
        one._task._noise = type(task._noise)(1, np.random.default_rng(0))
        one._task._noise._streams = [deepcopy(stream)]
        singles.append(one)
        assert all(first[name][robot].tobytes() == seen[name].tobytes() for name in first)
    rng, episodes, over = np.random.default_rng(1), 0, np.zeros(5, bool)
    for _ in range(40):
        actions = rng.choice(4, size=5, p=[0.05, 0.55, 0.2, 0.2])
        seen, rewards, ended, truncated, info = many.step(actions)
        for robot, one in enumerate(singles):
            if over[robot]:
                noise = one._task._noise
                noise.draw(np.array([STOP]))  # the step in which another episode begins
                singles[robot], alone = begin(robot, noise)
                expected = alone, 0.0, False, False, {"success": False, "spl": 0.0, "steps": 0}
            else:
                expected = one.step(actions[robot])
            for name, part in expected[0].items():
                assert part.dtype == seen[name].dtype
                assert part.tobytes() == seen[name][robot].tobytes(), name
            assert (rewards[robot], ended[robot], truncated[robot]) == expected[1:4]
            assert {name: column[robot] for name, column in info.items()} == expected[4]
        over = ended | truncated
        episodes += over.sum()
    assert episodes > 5


def test_an_episode_that_is_over_makes_room_for_another_in_the_next_step():
    many = make(noise=False)
    before, _ = many.reset(seed=1)
    task = many.unwrapped._task
    task.poses[1] = task.goal_poses[1]  # a robot at its goal
    _, rewards, ended, _, info = many.step(np.array([FORWARD, STOP, STOP]))
    assert rewards.tolist() == [0.0, 1.0, 0.0]
    assert ended.tolist() == [False, True, True]
    assert info["success"].tolist() == [False, True, False]
    after, rewards, ended, _, info = many.step(np.array([FORWARD, FORWARD, FORWARD]))
    assert info["steps"].tolist() == [2, 0, 0]
    assert not np.any([rewards, ended])
    assert np.array_equal(after["goal_image"][0], before["goal_image"][0])
    assert not np.array_equal(after["goal_image"][1], before["goal_image"][1])
    assert not after["odometry"][1:].any()
    assert after["odometry"][0].any()
    seen, *_, info = many.step(np.array([FORWARD, LEFT, FORWARD]))
    assert info["steps"].tolist() == [3, 1, 1]
    assert seen["odometry"][1, 2] > 0.1


def test_an_episode_is_truncated_after_its_last_step():
    many = make(2)
    many.reset(seed=2)
    many.unwrapped._task.steps[0] = 499
    _, _, ended, truncated, _ = many.step(np.array([LEFT, LEFT]))
    assert truncated.tolist() == [True, False]
    assert not ended.any()


def test_options_hold_for_all_episodes_until_the_next_reset():
    many = make(2)
    many.reset(seed=0, options={"difficulty": "easy", "world": 10_100})
    many.step(np.array([STOP, STOP]))
    many.step(np.array([STOP, STOP]))
    episodes = many.unwrapped._task.episodes
    assert episodes.difficulty == ("easy", "easy")
    assert len(set(episodes.worlds)) == 1


@pytest.mark.parametrize("actions", [[0, 1, 4], [0, 1], "left"])
@pytest.mark.few(1)
def test_wrong_actions_are_refused(actions):
    many = make()
    with pytest.raises(InputError, match="call reset first"):
        many.step(np.array([0, 0, 0]))
    many.reset(seed=0)
    with pytest.raises(InputError, match="actions"):
        many.step(actions)
