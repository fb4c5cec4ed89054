"""Noticing a goal, going there, stopping, and giving up what was a mistake."""

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.exploration.episodes import Episodes
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings
from tutorial_lib.exploration.labels import relative_polar
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.world.noise import STOP
from tutorial_lib.world.scene import Scene


class Model:
    """Sees a goal at a fixed place of a hall, with errors; needs the task for its poses."""

    def __init__(self, goal, error=0.0, visible=3.0, exists=True):
        self.goal, self.error, self.visible, self.exists = np.array(goal), error, visible, exists
        self.rng, self.asked = np.random.default_rng(0), 0

    def embed(self, observations):
        self.asked += len(observations)
        return np.column_stack([observations.odometry]).astype(np.float32)

    def _pose(self, features):
        return features + np.array([5.0, 5.0, 0.0])

    def relative(self, sources, goals):
        found = relative_polar(self._pose(sources), np.tile(self.goal, (len(sources), 1)))
        return found + self.rng.normal(0, self.error, found.shape) * [0.5, 1.0]

    def same_node(self, sources, goals):
        metres = relative_polar(self._pose(sources), np.tile(self.goal, (len(sources), 1)))[:, 1]
        far = metres < self.visible
        return np.where(far if self.exists else far & (metres > 1.5), 0.9, 0.1)

    def ranges(self, observations):
        return observations.depth


def drive(model, goal, target=(3.0, 0.0), steps=80):
    start = np.array([[5.0, 5.0, 0.0]])
    far = np.linalg.norm(np.array(goal) - 5.0)
    episodes = Episodes(("box",), start, np.array([[*goal, 0.0]]), np.array([far]), ("",))
    task = ExplorationTask(
        {"box": Scene(make_box())}, episodes, np.random.default_rng(1), noise=False
    )
    search = GoalSearch(model, task.goals(), SearchSettings())
    found = []
    for _ in range(steps):
        if task.done.all():
            break
        sensed = search.sense(task.observe(), ~task.done)
        task.step(search.drive(sensed, np.array([target])))
        found.append(bool(search.found[0]))
    return task, found


@pytest.mark.parametrize("goal", [(6.5, 6.8), (2.9, 4.0), (5.0, 2.5)])
@pytest.mark.parametrize("error", [0.0, 0.25])
def test_a_goal_in_sight_is_driven_to_and_stopped_at(goal, error):
    task, found = drive(Model(goal, error), goal)
    assert task.success.all()
    assert found[0]
    gap = np.linalg.norm(task.poses[0, :2] - goal)
    assert gap < 0.6 + 2 * error


def test_a_goal_out_of_sight_leaves_the_robot_to_its_target():
    task, found = drive(Model((2.0, 5.0), visible=1.0), (2.0, 5.0), steps=14)
    assert not any(found)
    assert task.poses[0, 0] > 7.5


def test_a_goal_that_is_not_there_is_given_up_without_stopping():
    goal = (5.0, 7.4)
    model = Model(goal, exists=False)
    task, found = drive(model, goal, steps=45)
    assert any(found)
    assert not found[-1]
    assert not task.done.any()


def test_robots_look_only_where_they_have_moved():
    model = Model((9.0, 9.0), visible=0.5)
    drive(model, (9.0, 9.0), target=(-0.5, 0.0), steps=19)  # it turns around first
    assert model.asked == 2  # the goal, and the first look


def test_those_that_are_done_stop_and_are_not_sensed():
    model = Model((9.0, 9.0))
    episodes = Episodes(
        ("box",) * 2, np.full((2, 3), 5.0), np.full((2, 3), 9.0), np.ones(2), ("",) * 2
    )
    task = ExplorationTask({"box": Scene(make_box())}, episodes, np.random.default_rng(1))
    search = GoalSearch(model, task.goals(), SearchSettings())
    sensed = search.sense(task.observe(), np.array([False, True]))
    assert sensed.robots.tolist() == [1]
    actions = search.drive(sensed, np.full((2, 2), 3.0))
    assert actions[0] == STOP
    assert actions[1] != STOP
