"""Where a robot is going, and when it is there or gives up."""

import numpy as np
import pytest

from tutorial_lib.exploration.exploring_robot import ARRIVED, Destination, ExploringRobot
from tutorial_lib.exploration.ghost_graph import Ghost

AT, THERE = np.zeros(2), np.array([5.0, 0.0])


@pytest.fixture
def robot():
    """It is in a node with one ghost, ahead of it."""
    robot = ExploringRobot(np.random.default_rng(0))
    robot.memory.node = robot.memory.graph.add_node([k == 0 for k in range(12)])
    return robot


def test_a_ghost_that_was_explored_meanwhile_is_no_destination(robot):
    assert not robot.is_valid()
    robot.go_to(Destination(0, THERE))
    assert robot.is_valid()
    robot.go_to(Destination(0, THERE, Ghost(0, 0)))
    assert robot.is_valid()
    robot.memory.graph.remove(Ghost(0, 0))
    assert not robot.is_valid()


def steps_until_it_gives_up(robot, here, target=THERE, limit=200):
    """After how many steps; `here` (x) depends on the step."""
    for step in range(limit):
        robot.watch(target, np.array([here(step), 0.0]), 9.0, False)
        if robot.reached:
            return step + 1
    return None


def test_a_robot_that_comes_no_nearer_gives_up_after_fifty_steps(robot):
    assert steps_until_it_gives_up(robot, lambda step: 0.0) == 51
    robot.go_to(None)
    # Slips do not count as nearer, and a robot that gets on has all its time again.
    assert steps_until_it_gives_up(robot, lambda step: 0.001 * step) == 51
    robot.go_to(None)
    assert steps_until_it_gives_up(robot, lambda step: 0.02 * step) is None


def test_another_target_has_time_of_its_own_and_nearly_the_same_one_has_not(robot):
    for _ in range(40):
        robot.watch(THERE, AT, 9.0, False)
    beside = np.add(THERE, [0.0, 1.5 * ARRIVED])
    assert steps_until_it_gives_up(robot, lambda step: 0.0, beside) == 11
    robot.go_to(None)
    for _ in range(40):
        robot.watch(THERE, AT, 9.0, False)
    behind = np.add(THERE, [2.5 * ARRIVED, 0.0])
    assert steps_until_it_gives_up(robot, lambda step: 0.0, behind) == 51


@pytest.mark.parametrize(
    ("here", "left", "last", "reached"),
    [(4.7, 9.0, True, True), (4.7, 9.0, False, False), (0.0, 0.3, True, True), (4.5, 9.0, True, 0)],
)
def test_a_robot_is_there_at_the_place_or_at_the_end_of_its_path(robot, here, left, last, reached):
    robot.watch(THERE, np.array([here, 0.0]), left, last)
    assert robot.reached == bool(reached)
