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
    return build(pool_of(corridor()), RULES, np.random.default_rng(0))


def crossing(pairs):
    """Those of pairs of images that look along the corridor and have the obstacle between them."""
    poses = corridor()
    at = [(pair, sorted(poses[list(pair), 0])) for pair in pairs if max(pair) < 40]
    return {pair for pair, (low, high) in at if low < 6.0 + BESIDE and high > 6.0 - BESIDE}


def test_what_leads_through_an_obstacle_is_all_that_crosses_it_and_nothing_else(made):
    edge = next(iter(sorted(crossing(made.graph.edges))))
    target = compose(FRAME, corridor()[edge[1]])
    obstacles = compose(FRAME, np.column_stack([ACROSS, np.zeros(len(ACROSS))]))[:, :2]
    found = obstructed(made, edge, target, obstacles, 1.6 * RULES.connect)
    assert len(found) == len(set(found))
    sources, targets, _ = made.links(1.6 * RULES.connect)
    links = set(zip(sources.tolist(), targets.tolist(), strict=True))
    assert crossing(found) == crossing(links | set(made.graph.edges))
    back = [pair for pair in found if min(pair) >= 40]
    assert not back  # nothing joins the two directions here: where those images are is not known


def test_an_obstacle_elsewhere_closes_nothing(made):
    edge = next(iter(made.graph.edges))
    far = np.add(corridor()[edge[1], :2], (0.0, 3.0))
    assert obstructed(made, edge, corridor()[edge[1]], far[None], 2.5) == ()


def test_a_map_is_not_expanded_through_what_is_closed_until_that_is_over(made):
    poses = corridor()
    cut(made.graph, (5.0, 7.0))
    made.unused |= set(range(len(poses))) - set(made.graph)
    ahead = [v for v in made.graph if v < 40]
    here, there = min(ahead, key=lambda v: poses[v, 0]), max(ahead, key=lambda v: poses[v, 0])
    upkeep = Maintenance(made.graph, MaintenanceRules(returns_blocked=10), 4.0, 0.04)
    sources, targets, _ = made.links(1.6 * RULES.connect)
    closed = crossing(zip(sources.tolist(), targets.tolist(), strict=True))
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


def test_where_what_is_blocked_never_returns_it_stays_closed(made):
    upkeep = Maintenance(made.graph, MaintenanceRules(returns_blocked=0), 4.0, 0.04)
    upkeep.experienced(Traversal((0, 1), "trusted", False, blocked=((0, 79),)))
    upkeep.begin(1_000_000)
    assert set(upkeep.closed) == {(0, 79)}
    assert np.isinf(upkeep.closed[0, 79])
