"""Invariants of the graph with ghosts, in random episodes of building one."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import bearing_of, bin_of
from tutorial_lib.exploration.ghost_graph import BESIDE, EXPLORED, Ghost, GhostGraph
from tutorial_lib.geometry import compose, inverse, relative


def check(graph):
    """What holds at any time."""
    edges = nx.Graph()
    edges.add_nodes_from(range(len(graph)))
    for node, around in enumerate(graph.edges):
        for other, pose in around.items():
            edges.add_edge(node, other, weight=float(np.hypot(*pose[:2])))
            assert np.allclose(compose(pose, graph.edges[other][node]), 0.0, atol=1e-9)
            direction = int(bin_of(np.arctan2(pose[1], pose[0])))
            assert (node, direction) not in graph.ghosts, "a ghost where a node stands"
            assert (node, direction) not in graph.reserve
    assert nx.is_connected(edges)
    for (node, direction), ghost in {**graph.ghosts, **graph.reserve}.items():
        assert (ghost.node, ghost.direction) == (node, direction)
        assert 0 <= node < len(graph)
        assert 0 <= direction < 12
    assert not graph.ghosts.keys() & graph.reserve.keys()
    return edges


@settings(max_examples=1000)
@given(st.integers(0, 2**32 - 1))
def test_invariants_in_random_episodes(seed):
    rng = np.random.default_rng(seed)
    graph, node, offset = GhostGraph(), 0, np.zeros(3)
    graph.add_node(rng.random(12) < 0.5, rng.uniform(0, 3, 12))
    for _ in range(rng.integers(1, 12)):
        offset = compose(offset, [rng.uniform(0, 4), rng.normal(0, 1), rng.uniform(-3, 3)])
        kind = rng.random()
        if kind < 0.5:
            ranges = rng.uniform(0.3, 6, 24) if rng.random() < 0.5 else None
            free = rng.uniform(-1, 3, 12)
            node = graph.add_node(rng.random(12) < 0.4, free, node, offset, ranges)
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
    metres, before = graph.shortest(node)
    expected = nx.single_source_dijkstra_path_length(edges, node)
    assert np.allclose(metres, [expected[n] for n in range(len(graph))])
    poses = graph.poses_from(node)
    for other in range(len(graph)):
        if other != node:
            last = int(before[other])
            assert np.allclose(relative(poses[last], poses[other]), graph.edges[last][other])
        path = graph.path(node, other)
        assert (path[0], path[-1]) == (node, other)
        assert nx.path_weight(edges, path, "weight") == pytest.approx(expected[other])


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


def test_a_node_beside_another_counts_without_an_edge():
    graph = GhostGraph()
    graph.add_node([False] * 12)
    graph.add_node([True] * 12, previous=0, pose=[4.0, 0.0, 0.0])
    graph.add_node([True] * 12, previous=0, pose=[4.0, 4.0, 0.0])
    assert 1 not in graph.edges[2]
    assert BESIDE > 4.0
    assert (1, 3) not in graph.ghosts
    assert (2, 9) not in graph.ghosts


def test_a_ghost_next_to_a_node_is_explored_whatever_its_direction():
    graph = GhostGraph()
    graph.add_node([True] * 12)
    place = np.array([np.cos(np.deg2rad(17)), np.sin(np.deg2rad(17))]) * 3.0  # in bin 1
    graph.add_node([False] * 12, previous=0, pose=[*place, 0.0])
    assert np.linalg.norm(place - graph.place_of(Ghost(0, 0))) < EXPLORED
    assert {(0, d) for d in range(12)} - graph.ghosts.keys() == {(0, 0), (0, 1)}


def test_what_a_node_sees_well_goes_to_the_reserve_and_comes_back():
    graph = GhostGraph()
    graph.add_node([False] * 3 + [True] + [False] * 8, ranges=np.full(192, 5.0))
    graph.add_node([False] * 12, previous=0, pose=[1.5, 1.5, 0.0], ranges=np.full(192, 5.0))
    assert not graph.ghosts
    assert graph.reserve == {(0, 3): Ghost(0, 3)}
    graph.use_reserve()
    assert graph.ghosts == {(0, 3): Ghost(0, 3)}
    hidden = GhostGraph()
    hidden.add_node([False] * 3 + [True] + [False] * 8, ranges=np.full(192, 5.0))
    hidden.add_node([False] * 12, previous=0, pose=[1.5, 1.5, 0.0], ranges=np.full(192, 1.0))
    assert hidden.ghosts


def test_nodes_hang_together_or_are_refused():
    graph = GhostGraph()
    graph.add_node([True] * 12)
    with pytest.raises(InputError, match="give previous and pose"):
        graph.add_node([True] * 12)
    with pytest.raises(InputError, match="0 to 0"):
        graph.connect(0, 0, np.zeros(3))
    with pytest.raises(InputError, match="0 to 5"):
        graph.connect(0, 5, np.zeros(3))
    assert len(graph) == 1
