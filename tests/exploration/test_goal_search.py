"""Noticing a goal, going there, stopping, and giving up what was a mistake."""

from dataclasses import replace

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


def one_robot(goal):
    """A task in a hall, with the robot in its middle."""
    start = np.array([[5.0, 5.0, 0.0]])
    far = np.linalg.norm(np.array(goal) - 5.0)
    episodes = Episodes(("box",), start, np.array([[*goal, 0.0]]), np.array([far]), ("",))
    return ExplorationTask(
        {"box": Scene(make_box())}, episodes, np.random.default_rng(1), noise=False
    )


def drive(model, goal, target=(3.0, 0.0), steps=80):
    task = one_robot(goal)
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


def test_an_estimate_from_far_away_hardly_moves_a_better_one():
    estimates = iter([[0.0, 1.0], [0.0, 1.7], [0.0, 2.9]])
    model = Model((9.0, 9.0))
    model.same_node = lambda sources, goals: np.ones(len(sources))
    model.relative = lambda sources, goals: np.array([next(estimates)])
    episodes = Episodes(("box",), np.full((1, 3), 5.0), np.full((1, 3), 9.0), np.ones(1), ("",))
    task = ExplorationTask({"box": Scene(make_box())}, episodes, np.random.default_rng(1))
    search, places = GoalSearch(model, task.goals(), SearchSettings()), []
    # Twice from one place, then from 2 m behind it: the goal seems to be 1 m, 1.7 m, 0.9 m ahead.
    for x in (0.0, 0.0, -2.0):
        seen = replace(task.observe(), odometry=np.array([[x, 0.0, 0.0]]))
        search.look_again(np.zeros(1, int))
        search.sense(seen, np.ones(1, bool))
        places.append(search.places[0, 0])
    assert places[0] == 1.0
    assert 1.2 < places[1] < 1.35
    assert places[1] - 0.06 < places[2] < places[1]


def test_a_goal_that_is_not_there_is_given_up_without_stopping():
    goal = (5.0, 7.4)
    model = Model(goal, exists=False)
    task, found = drive(model, goal, steps=45)
    assert any(found)
    assert not found[-1]
    assert not task.done.any()


def test_a_goal_that_was_missed_leaves_no_trace_in_what_is_left_of_the_path():
    goal, model = (5.0, 7.4), Model((5.0, 7.4), exists=False)
    task = one_robot(goal)
    search = GoalSearch(model, task.goals(), SearchSettings())
    before, missed = False, 0
    for _ in range(45):
        sensed = search.sense(task.observe(), ~task.done)
        pursued = bool(search.found[0])
        task.step(search.drive(sensed, np.array([[3.0, 0.0]])))
        if pursued and not search.found[0]:
            assert search.left[0] == np.inf
            missed += 1
        elif not pursued:
            assert 0 < search.left[0] < 6
        before |= pursued
    assert before
    assert missed == 1


def test_every_place_of_a_missed_goal_is_remembered():
    task = one_robot((5.0, 7.4))
    search = GoalSearch(Model((5.0, 7.4)), task.goals(), SearchSettings())
    refused, row = [(2.5, 0.0), (0.0, -2.5), (-2.5, 0.0)], np.array([0])
    for place in refused:
        search.found[0], search.places[0], search.left[0] = True, place, 0.0
        search._arrived(row, np.zeros((1, 3)))
        assert not search.found[0]

    def looks(goal):
        search._model.goal = np.array([5.0, 5.0]) + goal
        search.found[:] = False
        search._look(row, np.zeros((1, 3)), np.zeros((1, 3), np.float32))
        return bool(search.found[0])

    assert not any(looks(place) for place in refused)
    assert looks((0.0, 2.5))
    assert looks((0.7, 0.0))  # what is near may be a goal after all


def test_where_a_goal_was_missed_another_is_believed_only_from_near_by():
    search = GoalSearch(Model((5.0, 7.4)), one_robot((5.0, 7.4)).goals(), SearchSettings())
    search.found[0], search.places[0], search.left[0] = True, (1.2, 0.0), 0.0
    search._arrived(np.array([0]), np.zeros((1, 3)))
    believed = []
    for metres in (1.1, 0.9):
        search._model.goal = np.array([5.0 + metres, 5.0])
        search._look(np.array([0]), np.zeros((1, 3)), np.zeros((1, 3), np.float32))
        believed.append(bool(search.found[0]))
    assert believed == [False, True]


def looks_at(search, task, x):
    """Whether a robot looks when its odometry says (x, 0)."""
    seen = replace(task.observe(), odometry=np.array([[x, 0.0, 0.0]]))
    return bool(len(search.sense(seen, np.ones(1, bool)).looking))


@pytest.mark.parametrize(("goal", "looks"), [(1.0, True), (2.0, False)])
def test_near_its_goal_a_robot_looks_at_every_step(goal, looks):
    task = one_robot((5.0 + goal, 5.0))
    search = GoalSearch(Model((5.0 + goal, 5.0)), task.goals(), SearchSettings())
    assert looks_at(search, task, 0.0)
    assert search.found[0]
    assert looks_at(search, task, 0.05) is False
    assert looks_at(search, task, 0.25) is looks


def test_another_goal_is_looked_for_at_once():
    task = one_robot((9.0, 9.0))
    search = GoalSearch(Model((9.0, 9.0), visible=0.5), task.goals(), SearchSettings())
    assert looks_at(search, task, 0.0)
    assert not looks_at(search, task, 0.1)
    search.look_for(task.goals())
    assert looks_at(search, task, 0.1)


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
