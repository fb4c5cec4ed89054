"""The Gymnasium environment of the car."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.conftest import make_box
from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.environments import CAR as NAME
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.car_task import CAR
from tutorial_lib.world.placing import is_free

PLAN = make_box(9.0, 5.0, [(3.0, 2.5, 0.4)])
AHEAD = np.array([1.0, 0.0], np.float32)


@pytest.mark.parametrize(
    "choice",
    [
        {"worlds": (10_100,), "render_mode": "rgb_array"},
        {"plan": PLAN, "sensor": "rgb", "render_mode": "top_view", "reward": "shaped"},
    ],
)
def test_gymnasium_s_checker_is_content(choice):
    environment = gymnasium.make(NAME, **choice)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environment.unwrapped)


@pytest.mark.full
def test_the_same_seed_and_actions_give_the_same_episode():
    rolled = []
    for seed in (4, 4, 5):
        environment = gymnasium.make(NAME, worlds=(10_100, 10_101))
        environment.action_space.seed(3)
        states = list(environment.reset(seed=seed)[0].values())
        for _ in range(5):
            states += environment.step(environment.action_space.sample())[0].values()
        rolled.append(b"".join(state.tobytes() for state in states))
    assert rolled[0] == rolled[1] != rolled[2]


def test_an_action_is_a_share_of_speed_and_steering():
    environment = gymnasium.make(NAME, plan=make_box(40.0, 40.0), noise=False).unwrapped
    seen, _ = environment.reset(seed=1)
    assert environment.observation_space.contains(seen)
    for action, speed, steering in (
        ([1.0, 1.0], CAR.max_speed, CAR.max_steering),
        ([-1.0, 0.5], -CAR.max_reverse, CAR.max_steering / 2),
        ([0.5, 0.0], CAR.max_speed / 2, 0.0),
    ):
        for _ in range(10):
            seen, *_ = environment.step(np.array(action, np.float32))
        assert environment.observation_space.contains(seen)
        assert seen["speed"] == pytest.approx([speed], abs=0.01)
        assert seen["steering"] == pytest.approx([steering])
    task = environment._task
    before = task.poses[0].copy()
    for _ in range(10):  # a second straight ahead
        environment.step(AHEAD * 0.5)
    assert np.hypot(*(task.poses[0] - before)[:2]) == pytest.approx(0.25, abs=0.005)


def test_an_oracle_reaches_goals_and_its_episodes_end_by_themselves():
    environment = gymnasium.make(NAME, worlds=(10_100,), noise=False).unwrapped
    for seed in range(3):
        environment.reset(seed=seed)
        task = environment._task
        simulation = task._fleets[0].simulation
        assert is_free(simulation.scene, CAR, task.poses).all()
        paths = GridPaths(simulation.scene.clearance)
        oracle = OraclePolicy(simulation, paths, task.goal_poses[:, :2])
        over = False
        while not over:
            action = oracle.act(simulation.observe(), np.array([0]))[0]
            action /= [CAR.max_speed, CAR.max_steering]
            _, reward, ended, truncated, info = environment.step(np.clip(action, -1.0, 1.0))
            over = ended or truncated
        assert ended
        assert info["success"]
        assert reward == info["spl"] > 0.5
        assert np.hypot(*(task.poses - task.goal_poses)[0, :2]) < 1.0
        with pytest.raises(InputError, match="the episode is over; call reset"):
            environment.step(AHEAD)


def test_an_episode_is_truncated_after_500_steps():
    environment = gymnasium.make(NAME, plan=PLAN, sensor="rgb").unwrapped
    environment.reset(seed=0)
    environment._task.steps[0] = 498
    assert environment.step(AHEAD * 0)[2:4] == (False, False)
    assert environment.step(AHEAD * 0)[1:4] == (0.0, False, True)


@pytest.mark.full
def test_cars_fit_where_episodes_start():
    environment = gymnasium.make(NAME, worlds=range(10_100, 10_104), sensor="rgb").unwrapped
    for seed in range(30):
        environment.reset(seed=seed)


@pytest.mark.parametrize("action", [[0.0], [2.0, 0.0], [np.nan, 0.0], "left", None])
def test_a_wrong_action_is_refused(action):
    environment = gymnasium.make(NAME, plan=PLAN).unwrapped
    environment.reset(seed=0)
    with pytest.raises(InputError, match=r"^action: "):
        environment.step(action)
