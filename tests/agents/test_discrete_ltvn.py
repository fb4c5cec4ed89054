"""LTVN's agent in the robot that explores: which action follows from what it drives."""

from types import SimpleNamespace

import numpy as np
import pytest

from tutorial_lib.agents.discrete_ltvn import DiscreteLTVN
from tutorial_lib.agents.ltvn_state import Leg
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.visits import remembering_ltvn
from tutorial_lib.exploration.episodes import Episodes, exploration_world
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.local_policy import LocalPolicy
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.se2 import compose
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT, STOP
from tutorial_lib.world.worlds import scene_of

NAME = exploration_world(10_000)
ROBOTS = 6


@pytest.fixture(scope="module")
def task():
    scene = scene_of(NAME)
    clearance = GridPaths(scene.clearance)
    roomy = clearance.points[clearance.clearance.argmax()]
    poses = np.tile([*roomy, 0.3], (ROBOTS, 1))
    episodes = Episodes((NAME,) * ROBOTS, poses, poses, np.ones(ROBOTS), ("",) * ROBOTS)
    return ExplorationTask({NAME: scene}, episodes, np.random.default_rng(0), noise=False)


class Standing:
    """A navigation whose robots have the legs that they are given."""

    def __init__(self, legs):
        self.states = [SimpleNamespace(leg=leg) for leg in legs]
        self.arrived = np.array([False, False, False, False, True, False])
        self.given_up = np.array([False, False, False, False, False, True])
        self.asked = []

    def act(self, observations, robots):
        assert observations.image.shape[1:] == (16, 64, 3)
        assert observations.depth.shape[1:] == (64,)
        self.asked += robots.tolist()


def leg_to(odometry, place, *, turn=False):
    aim = compose(odometry, np.array(place))
    return Leg(0, 1, "local", None, None, aim, 99.0, turn=turn)


def test_legs_become_actions(task):
    agent, seen = DiscreteLTVN(remembering_ltvn()), task.observe()
    here = seen.odometry[0]
    ahead, left = leg_to(here, (0.6, 0.0, 0.0)), leg_to(here, (0.0, 0.0, 1.0), turn=True)
    right = leg_to(here, (0.0, 0.0, -1.0), turn=True)
    legs = [None, left, right, ahead, ahead, ahead]
    agent.navigation, agent._policy = Standing(legs), LocalPolicy(LocalMaps(ROBOTS))
    running = np.ones(ROBOTS, bool)
    actions = agent.act(seen, running)
    assert actions.tolist() == [LEFT, LEFT, RIGHT, FORWARD, STOP, STOP]
    running[:3] = False
    agent.navigation.asked.clear()
    actions = agent.act(seen, running)
    assert (actions[[0, 1, 2, 4, 5]] == STOP).all()
    assert actions[3] != STOP
    assert set(agent.navigation.asked) == {3, 4, 5}


def test_what_it_cannot_use(task):
    with pytest.raises(InputError, match="memory"):
        DiscreteLTVN(None)
    agent = DiscreteLTVN(remembering_ltvn())
    with pytest.raises(InputError, match="learn first"):
        agent.start(task.goals())
