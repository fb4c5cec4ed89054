"""Which links lead through an obstacle, and that none is made through it."""

import numpy as np
import pytest

from tests.topology.mapping.test_sampling_map import RULES, corridor, cut, pool_of
from tutorial_lib.se2 import compose
from tutorial_lib.topology.maintenance import Maintenance, MaintenanceRules, Traversal
from tutorial_lib.topology.mapping.expansion import expanded
from tutorial_lib.topology.mapping.obstructed import BESIDE, obstructed
from tutorial_lib.topology.mapping.sampling_map import build

ACROSS = np.column_stack([np.full(13, 6.0), np.linspace(-0.6, 0.6, 13)])
FRAME = np.array([2.0, -1.0, 0.7])
"""The corridor's origin by the robot's odometry."""


@pytest.fixture
def made():
    """A map that does not know where images are that it did not accept."""
    made = build(pool_of(corridor()), RULES, np.random.default_rng(0))
    made.pool.waypoints[~made.accepted] = 0.0
    return made


def crossing(pairs):
    """Those of pairs of images that look along the corridor and have the obstacle between them."""
    poses = corridor()
    at = [(pair, sorted(poses[list(pair), 0])) for pair in pairs if max(pair) < 40]
    return {pair for pair, (low, high) in at if low < 6.0 + BESIDE and high > 6.0 - BESIDE}


def all_links(made):
    sources, targets, _ = made.links(1.6 * RULES.connect)
    return set(zip(sources.tolist(), targets.tolist(), strict=True)) | set(made.graph.edges)


@pytest.mark.parametrize("reverse", [False, True])
def test_what_leads_through_an_obstacle_is_all_that_crosses_it_and_nothing_else(made, reverse):
    edges = sorted(crossing(made.graph.edges))
    edge = next(edge for edge in edges if made.graph.edges[edge]["reverse"] == reverse)
    source = compose(FRAME, corridor()[edge[0]])
    obstacles = compose(FRAME, np.column_stack([ACROSS, np.zeros(len(ACROSS))]))[:, :2]
    found = obstructed(made, edge, source, obstacles, 1.6 * RULES.connect)
    assert len(found) == len(set(found))
    assert crossing(found) == crossing(all_links(made))
    # Nothing joins the two directions here: where images that look back are is not known.
    assert not [pair for pair in found if min(pair) >= 40]


def test_an_obstacle_elsewhere_closes_only_the_edge_itself(made):
    edge = next(iter(made.graph.edges))
    far = np.add(corridor()[edge[1], :2], (0.0, 3.0))
    assert obstructed(made, edge, corridor()[edge[0]], far[None], 2.5) == (edge,)


def test_where_a_mistaken_edge_is_blocked_nothing_around_its_true_target_is_closed(made):
    """An edge from 2 m to 12 m says that it is a metre long; the robot stands before a wall."""
    edge, poses = (5, 30), corridor()
    made.graph.add_edge(*edge, **made.attributes(5, 7) | {"waypoint": (1.0, 0.0, 0.0)})
    wall = np.column_stack([np.full(7, poses[5, 0] + 0.6), np.linspace(-0.3, 0.3, 7)])
    found = obstructed(made, edge, poses[5], wall, 2.5)
    assert edge in found
    assert all(poses[list(pair), 0].max() < 7.5 for pair in found if pair != edge)


def test_a_map_is_not_expanded_through_what_is_closed_until_that_is_over(made):
    poses = corridor()
    cut(made.graph, (5.0, 7.0))
    made.unused |= set(range(len(poses))) - set(made.graph)
    ahead = [v for v in made.graph if v < 40]
    here, there = min(ahead, key=lambda v: poses[v, 0]), max(ahead, key=lambda v: poses[v, 0])
    upkeep = Maintenance(made.graph, MaintenanceRules(returns_blocked=10), 4.0, 0.04)
    closed = crossing(all_links(made))
    upkeep.begin(3)
    edge = next(iter(made.graph.edges))
    upkeep.experienced(Traversal(edge, "trusted", False, blocked=tuple(closed)))
    assert set(upkeep.closed) == closed - set(made.graph.edges)
    assert not expanded(made, upkeep, here, {there})
    upkeep.begin(12)
    assert not expanded(made, upkeep, here, {there})
    upkeep.begin(13)
    assert not upkeep.closed
    assert expanded(made, upkeep, here, {there})


def test_what_is_blocked_returns_only_where_nothing_else_helps(made):
    upkeep = Maintenance(made.graph, MaintenanceRules(returns=0, expand=False), 4.0, 0.04)
    edges = [edge for edge in made.graph.edges if crossing([edge])]
    last = max(edges, key=lambda edge: made.graph.edges[edge]["cost"])
    for edge in edges:
        upkeep.prune_edge(edge, blocked=edge != last)
    assert upkeep.blocked == set(edges) - {last}
    assert expanded(made, upkeep, last[0], {last[1]})
    assert [event.edge for event in upkeep.events if event.kind == "returned"] == [last]
    upkeep.prune_edge(last)
    assert expanded(made, upkeep, last[0], {last[1]}, {last})


def test_what_is_blocked_returns_after_as_many_queries_also_where_it_is_seen_again():
    made = build(pool_of(corridor()), RULES, np.random.default_rng(0))
    upkeep = Maintenance(made.graph, MaintenanceRules(returns_blocked=10), 4.0, 0.04)
    edge, other = list(made.graph.edges)[:2]
    upkeep.begin(0)
    upkeep.experienced(Traversal(edge, "trusted", False, blocked=(edge, (0, 79))))
    upkeep.begin(6)
    upkeep.experienced(Traversal(other, "trusted", False, blocked=(other, edge, (0, 79))))
    upkeep.begin(10)
    assert made.graph.has_edge(*edge)
    assert not made.graph.has_edge(*other)
    assert not upkeep.closed
    upkeep.begin(16)
    assert made.graph.has_edge(*other)


def test_where_what_is_blocked_never_returns_it_stays_closed(made):
    upkeep = Maintenance(made.graph, MaintenanceRules(returns_blocked=0), 4.0, 0.04)
    upkeep.experienced(Traversal((0, 1), "trusted", False, blocked=((0, 79),)))
    upkeep.begin(1_000_000)
    assert set(upkeep.closed) == {(0, 79)}
    assert np.isinf(upkeep.closed[0, 79])
