"""Checks of notebook 09: forms of answers, what must stay as it is, and the small buildings."""

import networkx as nx
import numpy as np
import pytest

from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.nb09 import (
    CELL,
    check_add_ghosts,
    check_explorable,
    check_explore,
    check_global_policy,
    path_lengths,
)
from tutorial_lib.checks.nb09.explore import explore
from tutorial_lib.checks.nb09.small_maps import small_map
from tutorial_lib.checks.nb09.small_places import BUILDINGS, PlacesRobot
from tutorial_lib.exploration.labels import explorable as labelled

OUT_OF_REACH = (
    "a ghost far inside that cannot be reached",
    "steps that end where the goal is first seen",
    "too few steps",
    "a goal that is nowhere",
)


def test_lengths_of_paths_are_those_of_straight_lines_and_of_detours():
    free = small_map()
    half = len(free) // 2
    lengths = path_lengths(free)
    assert lengths[half, half] == 0
    assert lengths[half, half + 30] == pytest.approx(3.0)
    rows, columns = np.indices(free.shape) - half
    straight = np.hypot(rows, columns) * CELL
    assert (lengths >= straight * 0.99).all()
    assert (lengths <= straight * 1.03 + 1e-9).all()
    walled = path_lengths(small_map((1.0, -2.0, 1.2, 2.0)))
    assert walled[half, half + 20] > 4.0
    closed = small_map((-1, -1, 1, -0.8), (-1, 0.8, 1, 1), (-1, -1, -0.8, 1), (0.8, -1, 1, 1))
    assert np.isinf(path_lengths(closed)[half, half + 30])


def test_the_exercise_finds_what_the_labels_of_the_library_say():
    angles = np.pi - (np.arange(192) + 0.5) * 2 * np.pi / 192
    wall = np.where(np.cos(angles) > 0.01, 1.5 / np.maximum(np.cos(angles), 0.01), 50.0)[None]
    by_label = labelled(wall)[0]
    found = check_explorable.reference(small_map((1.3, -3.5, 3.5, 3.5)), 3.0)
    assert np.array_equal(found, by_label)
    assert by_label.sum() == 7  # all but those within 60 degrees of the wall


@pytest.mark.parametrize("name", BUILDINGS)
def test_the_reference_ends_in_every_building(name):
    building = BUILDINGS[name]
    robot = PlacesRobot(building)
    reached, graph, ghosts = explore(robot)
    assert reached == (name not in OUT_OF_REACH)
    assert not len(graph) or nx.is_connected(graph)
    assert robot.steps >= 0
    if name == "a goal that is nowhere":
        assert ghosts == set()
        assert len(graph) == len(building.places)


@pytest.mark.parametrize(
    ("calls", "words"),
    [
        (lambda robot: robot.to_goal(), "the goal is not seen from here"),
        (lambda robot: robot.to_node(0), "there is no such node"),
        (lambda robot: robot.to_ghost((0, 1)), "`remember` makes one"),
        (lambda robot: robot.to_ghost(3), "a ghost is a pair"),
        (lambda robot: robot.remember(1), "the next number is 0"),
        (lambda robot: robot.remember(True), "give it the number"),
        (lambda robot: [robot.remember(0), robot.remember(0)], "there is a node 0 already"),
        (lambda robot: [robot.remember(0), robot.remember(1)], "the robot is in node 0"),
        (lambda robot: [robot.remember(0), robot.to_node(0)], "no edge leads there"),
        (lambda robot: [robot.remember(0), robot.to_ghost((0, 5))], "was never a ghost"),
        (lambda robot: [robot.node() for _ in range(3000)], "times without a drive"),
    ],
)
def test_the_robot_says_what_is_wrong_with_a_call(calls, words):
    with pytest.raises(WrongAnswer, match=words):
        calls(PlacesRobot(BUILDINGS["along a corridor"]))


def test_what_is_given_must_stay_as_it_is():
    def grows(ghosts, node, explorable, beside):
        beside[99] = np.zeros(3)
        return check_add_ghosts.reference(ghosts, node, explorable, {})

    assert "changes its argument beside;" in check_add_ghosts(grows).message

    def forgets(graph, here, ghosts, scores, goal=None, weight=0.0):
        answer = check_global_policy.reference(graph, here, ghosts, scores, goal, weight)
        scores.clear()
        return answer

    assert "changes its argument scores;" in check_global_policy(forgets).message


@pytest.mark.parametrize(
    ("judge", "answer", "words"),
    [
        (check_add_ghosts, lambda *_: {3}, "3 is no ghost; a ghost is a pair"),
        (check_global_policy, lambda *_: (99, None), "99 is no node of the graph"),
        (check_global_policy, lambda *_: (0, 3), "3 is no ghost; return"),
        (check_explore, lambda _: (1, nx.Graph(), set()), "return True if the goal"),
        (check_explore, lambda _: (True, {}, set()), "return the graph, nx.Graph"),
    ],
)
def test_answers_of_another_form_are_refused(judge, answer, words):
    result = judge(answer)
    assert result.status == "failed"
    assert words in result.message


def test_numbers_of_numpy_and_graphs_with_more_on_them_pass():
    def with_numpy(*case):
        found = check_add_ghosts.reference(*case)
        return {(np.int64(node), np.int32(direction)) for node, direction in found}

    assert check_add_ghosts(with_numpy).status == "passed"

    def with_more(robot):
        reached, graph, ghosts = explore(robot)
        nx.set_node_attributes(graph, "seen", "colour")
        return np.bool_(reached), graph, frozenset(ghosts)

    assert check_explore(with_more).status == "passed"
