"""What steps pay: the SPL at the end, or progress as well."""

import gymnasium
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.environments import CAR, IMAGE_GOAL
from tutorial_lib.exploration.episodes import Episodes, EpisodeSource
from tutorial_lib.exploration.rewards import Rewards
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.world.noise import FORWARD, LEFT, STOP
from tutorial_lib.world.scene import Scene


def scripted(kind, actions):
    """What is paid in an episode of 3 m straight ahead, along the grid of the geodesics."""
    scene = Scene(make_box(12.0, 8.0))
    source = EpisodeSource("hall", scene)
    nodes = source.paths.points
    start = np.array([[*nodes[np.argmin(np.hypot(*(nodes - [3.0, 4.0]).T))], 0.0]])
    goal = start + np.array([3.0, 0.0, 0.0])
    episode = Episodes(("hall",), start, goal, np.array([3.0]), ("medium",))
    rng = np.random.default_rng(0)
    task = ExplorationTask({"hall": scene}, episode, rng, noise=False)
    rewards = Rewards(kind, {"hall": source})
    rewards.begin(task)
    paid = []
    for action in actions:
        task.step([action])
        paid.append(rewards.paid(task, np.ones(1, bool))[0])
    return np.array(paid)


# To the goal, half a metre back, and stop there: the SPL is 3 / 3.5.
ACTIONS = [*12 * [FORWARD], *18 * [LEFT], *2 * [FORWARD], STOP]


def test_a_scripted_episode_pays_exactly_this():
    paid = scripted("shaped", ACTIONS)
    # Two actions lead from a node to a node.
    assert paid[:12:2] + paid[1:12:2] == pytest.approx(6 * [0.5 - 0.002])
    assert paid[12:30] == pytest.approx(18 * [-0.001])
    assert paid[30:32].sum() == pytest.approx(-0.5 - 0.002)
    assert paid[32] == pytest.approx(10 * 3 / 3.5 - 0.001)
    assert paid.sum() == pytest.approx(10 * 3 / 3.5 + 2.5 - 33 * 0.001)


def test_the_usual_reward_pays_the_spl_at_the_end_alone():
    assert scripted("spl", ACTIONS) == pytest.approx([*32 * [0.0], 3 / 3.5])


def to_go(task):
    """Geodesic metres (N,) from the robots to their goals."""
    found = np.empty(len(task))
    for row, name in enumerate(task.episodes.worlds):
        paths = GridPaths(task.scenes[name].clearance)
        here, goal = task.poses[row : row + 1, :2], task.goal_poses[row : row + 1, :2]
        found[row] = paths.between(here, goal)[0]
    return found


@pytest.mark.parametrize("name", [IMAGE_GOAL, CAR])
def test_progress_sums_up_to_the_metres_between_the_first_and_the_last_step(name):
    environment = gymnasium.make(name, worlds=(10_100,), reward="shaped").unwrapped
    rng = np.random.default_rng(1)
    environment.action_space.seed(1)
    for seed in range(4):
        environment.reset(seed=seed)
        task, paid = environment._task, 0.0
        first, steps = to_go(task)[0], int(rng.integers(20, 60))
        assert first == pytest.approx(task.episodes.shortest[0])
        for _ in range(steps):
            action = environment.action_space.sample()
            paid += environment.step(max(action, FORWARD) if name == IMAGE_GOAL else action)[1]
        # Where the goal is beside, the straight line and the way by a node differ.
        assert paid == pytest.approx(first - to_go(task)[0] - 0.001 * steps, abs=0.15)


@pytest.mark.full
def test_many_in_lock_step_are_paid_what_each_would_be():
    worlds = (10_100, 10_101)
    many = gymnasium.make_vec(IMAGE_GOAL, num_envs=6, worlds=worlds, reward="shaped")
    many.reset(seed=3)
    task, rng = many.unwrapped._task, np.random.default_rng(2)
    first, paid, steps = task.episodes.shortest.copy(), np.zeros(6), np.zeros(6)
    episodes = 0
    for _ in range(40):
        resets = task.done.copy()
        _, rewards, ended, _, info = many.step(rng.choice(4, size=6, p=[0.05, 0.55, 0.2, 0.2]))
        assert not rewards[resets].any()
        first[resets], paid[resets], steps[resets] = task.episodes.shortest[resets], 0.0, 0
        paid, steps = paid + rewards, steps + ~resets
        law = 10 * np.where(ended, info["spl"], 0.0) + first - to_go(task) - 0.001 * steps
        assert paid == pytest.approx(law, abs=0.15)
        assert (info["steps"] == steps).all()
        episodes += ended.sum()
    assert episodes > 5


def test_a_robot_in_a_pocket_is_as_far_as_it_was():
    environment = gymnasium.make(IMAGE_GOAL, worlds=(10_100,), reward="shaped").unwrapped
    environment.reset(seed=0)
    task = environment._task
    here = task.poses.copy()
    task.poses = here + np.array([500.0, 0.0, 0.0])  # the geodesics know nothing of this place
    assert environment.step(LEFT)[1] == pytest.approx(-0.001)
    task.poses = here
    assert environment.step(LEFT)[1] == pytest.approx(-0.001, abs=0.1)
