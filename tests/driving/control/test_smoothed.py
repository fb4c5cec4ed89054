"""C with waypoints that are averaged over the last steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.driving.control.smoothed import SmoothedPolicy
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import to_local
from tutorial_lib.interfaces import Observation


def seen_at(odometry):
    """Observations of robots whose odometry says (N, 3)."""
    odometry = np.array(odometry, dtype=float)
    count = len(odometry)
    return Observation(
        image=np.zeros((count, 1, 1, 3), np.uint8),
        depth=None,
        laser=np.zeros((count, 4)),
        odometry=odometry,
        speed=np.zeros(count),
        steering=np.zeros(count),
    )


class Waypoint:
    """A controller that returns the waypoints themselves."""

    def act(self, observations, waypoints):
        del observations
        return waypoints


class Predicts:
    """Predicts what it is told in turn, for the robots that are asked for."""

    def __init__(self, *turns):
        self.turns = list(turns)

    def predict(self, observations, targets):
        del observations
        return np.array(self.turns.pop(0), dtype=float)[targets], np.ones((len(targets), 2))


def smoothed(predictor, share, robots=1):
    return SmoothedPolicy(predictor, Waypoint(), np.arange(robots), share)


class Truth:
    """Predicts where the goal is, as seen from the odometry, which does not drift here."""

    def __init__(self, goal):
        self.goal = np.array(goal)

    def predict(self, observations, targets):
        goals = np.tile(self.goal, (len(targets), 1))
        return to_local(observations.odometry, goals), np.ones((len(targets), 2))


poses = st.lists(
    st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)), min_size=1, max_size=6
)


@given(poses, st.floats(0.05, 1.0))
def test_what_is_predicted_right_stays_right_however_the_robot_moves(track, share):
    policy = smoothed(Truth((1.0, 2.0)), share)
    for pose in track:
        found = policy.act(seen_at([pose]), np.array([0]))
        assert found == pytest.approx(to_local(np.array([pose]), np.array([[1.0, 2.0]])), abs=1e-9)


def test_the_newest_prediction_has_its_share():
    policy, robot = smoothed(Predicts([[2.0, 0.0]], [[4.0, 1.0]]), 0.25), np.array([0])
    assert policy.act(seen_at([[0, 0, 0]]), robot) == pytest.approx(np.array([[2.0, 0.0]]))
    assert policy.act(seen_at([[0, 0, 0]]), robot) == pytest.approx(np.array([[2.5, 0.25]]))


def test_the_average_is_kept_where_it_was_while_the_robot_turns():
    policy, robot = smoothed(Predicts([[2.0, 0.0]], [[0.0, -2.0]], [[0.0, -4.0]]), 0.5), [0]
    policy.act(seen_at([[0, 0, 0]]), np.array(robot))
    turned = seen_at([[0, 0, np.pi / 2]])
    assert policy.act(turned, np.array(robot)) == pytest.approx(np.array([[0.0, -2.0]]))
    assert policy.act(turned, np.array(robot)) == pytest.approx(np.array([[0.0, -3.0]]))


def test_each_robot_has_an_average_of_its_own():
    turns = [[[1.0, 0.0], [9.0, 9.0], [3.0, 0.0]]] * 2
    turns.append([[5.0, 0.0], [7.0, 7.0], [5.0, 0.0]])
    policy = smoothed(Predicts(*turns), 0.5, robots=3)
    policy.act(seen_at([[0, 0, 0]]), np.array([0]))
    policy.act(seen_at(np.zeros((2, 3))), np.array([0, 2]))
    found = policy.act(seen_at(np.zeros((3, 3))), np.arange(3))
    assert found == pytest.approx(np.array([[3.0, 0.0], [7.0, 7.0], [4.0, 0.0]]))


def test_no_robots_take_no_actions():
    policy = smoothed(Predicts([[1.0, 0.0]]), 0.5)
    assert policy.act(seen_at(np.zeros((0, 3))), np.zeros(0, int)).shape == (0, 2)


@pytest.mark.parametrize("share", [0.0, -0.1, 1.1, float("nan")])
def test_a_share_is_above_0_and_at_most_1(share):
    with pytest.raises(InputError, match=r"share: .* give one real number"):
        smoothed(Truth((0.0, 0.0)), share)
