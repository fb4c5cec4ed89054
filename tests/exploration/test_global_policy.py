"""Localising, choosing ghosts, and the next point on the path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import make_box
from tutorial_lib.exploration.bearings import column_bearings
from tutorial_lib.exploration.ghost_graph import Ghost
from tutorial_lib.exploration.global_policy import choose_ghost, ghost_places, subgoal
from tutorial_lib.exploration.graph_update import (
    PAPER,
    GraphUpdate,
    Localisation,
    Memory,
    free_metres,
)
from tutorial_lib.exploration.labels import panorama_ranges
from tutorial_lib.geometry import compose
from tutorial_lib.world.scene import Scene

NONE = [False] * 12


def only(*directions):
    return [direction in directions for direction in range(12)]


def corridor():
    """Three nodes 3 m apart along x; the robot is in the last one."""
    memory = Memory()
    for number, directions in enumerate(((6,), (3,), (0, 9))):
        memory.node = memory.graph.add_node(
            only(*directions), None, number - 1 if number else None, [3.0, 0.0, 0.0]
        )
        memory.features.append(np.zeros(2, np.float32))
    return memory


def chosen(memory, scores):
    return choose_ghost(memory, scores, np.random.default_rng(0))


def test_the_paper_s_rule_is_the_highest_score_wherever_it_is():
    memory, scores = corridor(), np.zeros((3, 12))
    scores[0, 6], scores[2, 0], scores[1, 5] = 0.5, 0.45, 1.0  # no ghost hangs on the last
    assert chosen(memory, scores) == Ghost(0, 6)


def test_ghosts_have_their_places_in_the_frame_of_the_robot_s_node():
    memory = corridor()
    memory.move(np.array([1.0, 0.0, 0.0]))
    places = ghost_places(memory, [Ghost(0, 6), Ghost(1, 3), Ghost(2, 0)])
    assert np.allclose(places, [[-9.0, 0.0], [-3.0, 3.0], [3.0, 0.0]])


def test_a_new_edge_makes_paths_shorter():
    graph = corridor().graph
    assert graph.path(0, 2) == [0, 1, 2]
    assert np.allclose(graph.poses_from(0)[2], [6.0, 0.0, 0.0])
    graph.connect(0, 2, [5.0, 0.5, 0.0])
    assert graph.path(0, 2) == [0, 2]
    assert np.allclose(graph.poses_from(0)[2], [5.0, 0.5, 0.0])


def test_the_reserve_is_used_when_ghosts_run_out_and_then_there_is_none():
    memory = Memory()
    free = np.zeros(12)
    free[[4, 7]] = 1.5, 2.0
    memory.node = memory.graph.add_node(NONE, free)
    scores = np.linspace(0, 1, 12)[None]
    ghost = chosen(memory, scores)
    assert ghost == Ghost(0, 7, 2.0)
    memory.graph.remove(ghost)
    memory.graph.remove(chosen(memory, scores))
    assert chosen(memory, scores) is None


def test_the_reserve_is_not_compared_with_ghosts():
    memory, free = Memory(), np.zeros(12)
    free[4] = 1.5
    memory.node = memory.graph.add_node(only(7), free)
    scores = np.zeros((1, 12))
    scores[0, 4], scores[0, 7] = 0.8, 0.5
    assert chosen(memory, scores) == Ghost(0, 7)
    assert memory.graph.reserve.keys() == {(0, 4)}


def test_equal_ghosts_are_drawn():
    memory = corridor()
    rng = np.random.default_rng(0)
    drawn = {choose_ghost(memory, np.zeros((3, 12)), rng) for _ in range(40)}
    assert len(drawn) == len(memory.graph.ghosts)


def test_the_next_node_is_the_subgoal_until_the_robot_passes_it():
    memory = corridor()
    target, last = subgoal(memory, 0, np.array([-3.0, 0.0]))
    assert np.allclose(target, [-3.0, 0.0])  # the node before, in the frame of the odometry
    assert not last
    memory.move(np.array([-2.5, 0.0, 0.0]))
    target, last = subgoal(memory, 0, np.array([-3.0, 0.0]))
    assert memory.node == 1
    assert np.allclose(target, [-6.0, 0.0])
    memory.move(np.array([-5.5, 0.3, 0.0]))
    target, last = subgoal(memory, 0, np.array([-3.0, 0.0]))
    assert last
    assert np.allclose(target, [-9.0, 0.0])


@given(st.lists(st.tuples(*[st.floats(-2, 2)] * 3), min_size=1, max_size=6))
def test_entering_other_nodes_does_not_move_the_robot(motions):
    memory, odometry = corridor(), np.zeros(3)
    for number, motion in enumerate(motions):
        odometry = compose(odometry, motion)
        memory.move(odometry)
        memory.enter(number % 3) if number % 3 != memory.node else None
        here = compose(memory.graph.poses_from(2)[memory.node], memory.offset)
        assert np.allclose(here[:2], odometry[:2], atol=1e-6)
        assert np.allclose(memory.in_odometry(memory.offset[:2]), odometry[:2], atol=1e-6)


class NearbyFeatures:
    """Says that a robot is in a node of features near its own."""

    def same_node(self, sources, goals):
        return (np.abs(sources - goals)[:, 0] < 1.0).astype(float)

    def explorable(self, features):
        return np.tile(np.arange(12) == 0, (len(features), 1)).astype(float)

    def relative(self, sources, goals):
        return np.column_stack([np.full(len(sources), np.pi / 2), np.full(len(sources), 0.4)])


def test_a_robot_stays_in_its_node_enters_another_or_makes_one():
    update, memory = GraphUpdate(NearbyFeatures(), 0.5, 0.5), Memory()
    ranges = np.full((1, 192), 5.0)

    def see(feature):
        return bool(update.update([memory], np.array([[feature]], np.float32), ranges)[0])

    assert see(0.0)
    assert not see(0.5)
    memory.move(np.array([2.0, 0.0, 0.0]))
    assert see(5.0)
    assert (memory.node, len(memory.graph)) == (1, 2)
    assert np.allclose(memory.graph.edges[0][1], [2.0, 0.0, 0.0])
    assert memory.graph.ghosts.keys() == {(1, 0)}  # that of node 0 led to node 1
    memory.move(np.array([2.0, 1.5, 0.0]))
    assert see(10.0)
    memory.move(np.array([0.5, 0.5, 0.0]))
    assert not see(0.2)
    assert memory.node == 0
    assert np.allclose(memory.offset[:2], [0.0, 0.4])  # by F_R: there was no edge
    assert 0 in memory.graph.edges[2]
    memory.move(np.array([1.8, 0.2, 0.0]))
    before = memory.offset
    assert not see(5.2)
    assert memory.node == 1
    edge = memory.graph.edges[0][1]
    assert np.allclose(compose(edge, memory.offset), before)  # along the edge, by odometry


def test_a_robot_is_looked_for_in_the_four_nearest_nodes_around_it():
    memory = Memory()
    memory.node = memory.graph.add_node(NONE)
    for x in (2.0, -0.5, 1.0, 4.4, -1.5, 3.0, 4.6):
        memory.graph.add_node(NONE, None, 0, [x, 0.0, 0.0])
    assert memory.others(everywhere=False) == [2, 3, 5, 1]
    assert memory.others(everywhere=True) == [2, 3, 5, 1, 6, 4, 7]
    memory.move(np.array([4.0, 0.0, 0.0]))
    assert memory.others(everywhere=False) == [4, 7, 6, 1]
    memory.move(np.array([8.5, 0.0, 0.0]))
    assert memory.others(everywhere=False) == [7, 4]  # the others are 4.5 m away and more
    assert memory.others(everywhere=True) == [7, 4, 6, 1, 3, 2, 5]


@pytest.mark.parametrize(("rules", "found"), [(None, False), (Localisation(all_nodes=True), True)])
def test_f_l_compares_with_nodes_that_are_far_by_odometry_only_in_the_paper(rules, found):
    update = GraphUpdate(NearbyFeatures(), 0.5, 0.5, localisation=rules)
    memory, ranges = Memory(), np.full((1, 192), 5.0)
    for x, feature in ((0.0, 0.0), (3.0, 10.0), (6.0, 20.0)):
        memory.move(np.array([x, 0.0, 0.0]))
        update.update([memory], np.array([[feature]], np.float32), ranges)
    made = update.update([memory], np.array([[0.2]], np.float32), ranges)[0]
    assert made != found
    assert memory.node == (0 if found else 3)
    assert (0 in memory.graph.edges[2]) is found


def test_the_edge_to_a_known_node_has_its_pose_by_odometry_in_the_paper():
    """Along the graph: where F_R has the robot (0.4 m to the left of node 0) does not matter."""
    update = GraphUpdate(NearbyFeatures(), 0.5, 0.5, localisation=PAPER)
    memory, ranges = Memory(), np.full((1, 192), 5.0)
    for pose, feature in (([0, 0, 0], 0.0), ([2, 0, 0.5], 10.0), ([2, 1.5, 1.0], 20.0)):
        memory.move(np.array(pose, float))
        update.update([memory], np.array([[feature]], np.float32), ranges)
    memory.move(np.array([0.5, 0.5, 2.0]))
    assert not update.update([memory], np.array([[0.2]], np.float32), ranges)[0]
    assert memory.node == 0
    assert np.allclose(memory.offset, [0.5, 0.5, 2.0])
    assert np.allclose(memory.graph.edges[0][2], [2.0, 1.5, 1.0])
    assert np.allclose(compose(memory.graph.edges[2][0], [2.0, 1.5, 1.0]), 0.0)


def test_the_most_likely_node_is_not_entered_unless_it_is_likely():
    """Between two nodes, and in none of them: F_L is below the threshold for both."""
    update, memory = GraphUpdate(NearbyFeatures(), 0.5, 0.5), Memory()
    ranges = np.full((1, 192), 5.0)
    for number, feature in enumerate((0.0, 5.0, 2.5)):
        memory.move(np.array([0.5 * number, 0.0, 0.0]))
        assert update.update([memory], np.array([[feature]], np.float32), ranges)[0]
        assert memory.node == number


def test_only_directions_that_are_free_for_a_metre_are_kept_in_reserve():
    memory, ranges = Memory(), np.full((1, 192), 5.0)
    ranges[:, np.abs(column_bearings(192) - np.pi / 2) < 1.0] = 1.0  # to the left: 0.76 m free
    GraphUpdate(NearbyFeatures(), 0.5, 0.5).add_nodes([memory], np.zeros((1, 1)), ranges)
    assert free_metres(ranges)[0, 3] == pytest.approx(0.76, abs=0.01)
    assert (0, 3) not in memory.graph.reserve
    assert memory.graph.reserve[0, 6].metres == 3.0


def test_a_direction_is_free_as_far_as_the_robot_fits():
    scene = Scene(make_box(8.0, 4.0, [(5.0, 2.3, 0.2)]))
    found = free_metres(panorama_ranges(scene, np.array([[3.0, 2.0, 0.0]])))[0]
    assert found[0] == pytest.approx(1.8 - 0.22, abs=0.05)  # the pillar is partly ahead
    assert found[[3, 9]] == pytest.approx(2.0 - 0.22, abs=0.01)
    assert found[6] == pytest.approx(3.0 - 0.22, abs=0.01)
    assert (found <= 3.0).all()
