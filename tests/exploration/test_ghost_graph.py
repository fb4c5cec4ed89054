"""Invariants of the graph with ghosts, in random episodes of building one."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import bearing_of, bin_of
from tutorial_lib.exploration.ghost_graph import BESIDE, EXPLORED, Ghost, GhostGraph
from tutorial_lib.geometry import compose, inverse, relative, wrap

AT = 0.05  # metres below which neither of two nodes is in a direction of the other


def check(graph):
    """What holds at any time."""
    edges = nx.Graph()
    edges.add_nodes_from(range(len(graph)))
    for node, around in enumerate(graph.edges):
        for other, pose in around.items():
            edges.add_edge(node, other, weight=float(np.hypot(*pose[:2])))
            assert np.allclose(compose(pose, graph.edges[other][node]), 0.0, atol=1e-9)
            direction = int(bin_of(np.arctan2(pose[1], pose[0])))
            if np.hypot(*pose[:2]) > AT:
                assert (node, direction) not in graph.ghosts, "a ghost where a node stands"
                assert (node, direction) not in graph.reserve
    assert nx.is_connected(edges)
    for (node, direction), ghost in {**graph.ghosts, **graph.reserve}.items():
        assert (ghost.node, ghost.direction) == (node, direction)
        assert 0 <= node < len(graph)
        assert 0 <= direction < 12
    assert not graph.ghosts.keys() & graph.reserve.keys()
    return edges


def is_explored(graph, ghost, other, pose, seen):
    """Whether node `other` at `pose` in the frame of a ghost's node explores the ghost."""
    metres = np.hypot(*pose[:2])
    stands = int(bin_of(np.arctan2(pose[1], pose[0]))) == ghost.direction and metres > AT
    near = np.linalg.norm(graph.place_of(ghost) - pose[:2]) < EXPLORED
    return (stands or near) and (
        other in graph.edges[ghost.node] or (metres < BESIDE and seen(ghost.node, other))
    )


def check_ghosts(graph, before, new, ranges):
    """After `new` was added there are the ghosts that it does not explore, and no others."""

    def sees(viewer, place):
        if ranges[viewer] is None:
            return False
        count = len(ranges[viewer])
        bearings = np.pi - (np.arange(count) + 0.5) * 2 * np.pi / count
        nearest = int(np.abs(wrap(bearings - np.arctan2(place[1], place[0]))).argmin())
        around = [ranges[viewer][(nearest + k) % count] for k in (-1, 0, 1)]
        return np.hypot(*place) < min(around)

    def seen(first, second):
        there, back = graph.poses_from(first)[second], graph.poses_from(second)[first]
        return sees(first, there[:2]) or sees(second, back[:2])

    for key, ghost in before.items():
        others = [new] if ghost.node != new else [n for n in range(new) if n != new]
        gone = any(
            is_explored(graph, ghost, other, graph.poses_from(ghost.node)[other], seen)
            for other in others
        )
        assert (key not in graph.ghosts) == gone, (key, gone)


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1))
def test_invariants_in_random_episodes(seed):
    rng = np.random.default_rng(seed)
    graph, node, offset, ranges = GhostGraph(), 0, np.zeros(3), [None]
    graph.add_node(rng.random(12) < 0.5, rng.uniform(0, 3, 12))
    for _ in range(rng.integers(1, 12)):
        far = rng.uniform(0, 4) * (rng.random() < 0.9)
        offset = compose(offset, [far, rng.normal(0, 1) * (far > 0), rng.uniform(-3, 3)])
        kind = rng.random()
        if kind < 0.5:
            ranges.append(rng.uniform(0.3, 9, 24) if rng.random() < 0.8 else None)
            explorable = rng.random(12) < 0.4
            new = {
                (len(graph), int(d)): Ghost(len(graph), int(d)) for d in np.flatnonzero(explorable)
            }
            before = {**graph.ghosts, **new}
            node = graph.add_node(explorable, rng.uniform(-1, 3, 12), node, offset, ranges[-1])
            check_ghosts(graph, before, node, ranges)
            offset = np.zeros(3)
        elif kind < 0.7 and len(graph) > 1:
            other = int(rng.choice([n for n in range(len(graph)) if n != node]))
            pose = rng.uniform(-2, 2, 3)
            graph.connect(node, other, compose(offset, inverse(pose)))
            node, offset = other, pose
        elif kind < 0.8 and graph.ghosts:
            ghost = list(graph.ghosts.values())[rng.integers(len(graph.ghosts))]
            graph.remove(ghost)
            assert (ghost.node, ghost.direction) not in graph.ghosts
        elif kind < 0.85:
            graph.use_reserve()
        edges = check(graph)
        check_paths(graph, edges, node)


def check_paths(graph, edges, node):
    """Shortest paths against networkx, and poses along them."""
    expected = nx.single_source_dijkstra_path_length(edges, node)
    poses = graph.poses_from(node)
    assert np.allclose(poses[node], 0.0)
    for other in range(len(graph)):
        if other != node:
            last = graph.path(other, node)[1]  # the one before it from `node`
            gap = relative(relative(poses[last], poses[other]), graph.edges[last][other])
            assert np.allclose([*gap[:2], wrap(gap[2])], 0.0, atol=1e-9)
        path = graph.path(node, other)
        assert (path[0], path[-1]) == (node, other)
        assert nx.path_weight(edges, path, "weight") == pytest.approx(expected[other])


def test_nodes_at_one_place_have_poses_and_no_direction():
    graph = GhostGraph()
    graph.add_node([True] * 12)
    graph.add_node([True] * 12, previous=0, pose=[0.0, 0.0, np.pi / 2])  # the robot has turned
    graph.add_node([False] * 12, previous=1, pose=[2.0, 0.0, 0.0])
    graph.add_node([False] * 12, previous=2, pose=[0.0, 0.0, 0.5])
    assert (1, 6) in graph.ghosts
    assert (0, 6) in graph.ghosts
    expected = [[0, 0, 0], [0, 0, np.pi / 2], [0, 2, np.pi / 2], [0, 2, np.pi / 2 + 0.5]]
    assert np.allclose(graph.poses_from(0), expected)
    from_last = relative(np.array(expected[3]), np.array(expected, dtype=float))
    assert np.allclose(graph.poses_from(3), from_last)
    assert graph.path(3, 0) == [3, 2, 1, 0]


def test_a_node_replaces_the_ghosts_that_it_explores():
    graph = GhostGraph()
    graph.add_node([True] * 12)
    assert len(graph.ghosts) == 12
    at = bearing_of(2)
    pose = np.array([3.0 * np.cos(at), 3.0 * np.sin(at), np.pi / 2])
    graph.add_node([True] * 12, previous=0, pose=pose)
    gone = {(node, d) for node in (0, 1) for d in range(12)} - graph.ghosts.keys()
    # In the new node's frame the old one is 180 + 60 - 90 = 150 degrees from its heading.
    assert gone == {(0, 2), (1, 5)}


def ranges_with(metres, bearing, otherwise):
    """Ranges of 192 columns: `metres` within 10 degrees of a bearing."""
    bearings = np.pi - (np.arange(192) + 0.5) * 2 * np.pi / 192
    return np.where(np.abs(wrap(bearings - bearing)) < np.deg2rad(10), metres, otherwise)


@pytest.mark.parametrize("viewer", [1, 2])
def test_a_node_in_sight_counts_without_an_edge(viewer):
    """Nodes 1 and 2 are 4 m apart, to the left of the one and to the right of the other."""
    found = []
    for metres in (5.0, 3.0):  # a view of the other one, and a wall before it
        seen = [None, None, None]
        seen[viewer] = ranges_with(metres, np.pi / 2 if viewer == 1 else -np.pi / 2, 8.0 - metres)
        graph = GhostGraph()
        graph.add_node([False] * 12)
        graph.add_node([True] * 12, None, 0, [4.0, 0.0, 0.0], seen[1])
        graph.add_node([True] * 12, None, 0, [4.0, 4.0, 0.0], seen[2])
        assert 1 not in graph.edges[2]
        found.append({(1, 3), (2, 9)} & graph.ghosts.keys())
    assert found == [set(), {(1, 3), (2, 9)}]
    assert BESIDE > 4.0


def test_a_ghost_next_to_a_node_is_explored_whatever_its_direction():
    graph = GhostGraph()
    graph.add_node([True] * 12)
    place = np.array([np.cos(np.deg2rad(17)), np.sin(np.deg2rad(17))]) * 3.0  # in bin 1
    graph.add_node([False] * 12, previous=0, pose=[*place, 0.0])
    assert np.linalg.norm(place - graph.place_of(Ghost(0, 0))) < EXPLORED
    assert {(0, d) for d in range(12)} - graph.ghosts.keys() == {(0, 0), (0, 1)}


def test_a_ghost_stays_where_another_node_only_sees_it():
    """As in the paper. It is 3 m to the left of node 0: from node 1 it is up and to the left."""
    graph = GhostGraph()
    graph.add_node([direction == 3 for direction in range(12)])
    graph.add_node([False] * 12, None, 0, [1.5, 1.5, 0.0], np.full(192, 5.0))
    assert graph.ghosts == {(0, 3): Ghost(0, 3)}


def test_what_was_removed_does_not_come_back_from_the_reserve():
    graph, free = GhostGraph(), np.zeros(12)
    free[[4, 7]] = 1.5, 2.0
    graph.add_node([False] * 12, free)
    graph.remove(graph.reserve[0, 4])
    graph.use_reserve()
    assert graph.ghosts == {(0, 7): Ghost(0, 7, 2.0)}


def test_nodes_hang_together_or_are_refused():
    graph = GhostGraph()
    graph.add_node([True] * 12)
    with pytest.raises(InputError, match="give previous and pose"):
        graph.add_node([True] * 12)
    with pytest.raises(InputError, match="first 0 to second 0"):
        graph.connect(0, 0, np.zeros(3))
    with pytest.raises(InputError, match="first 0 to second 5"):
        graph.connect(0, 5, np.zeros(3))
    assert len(graph) == 1
