"""Meng's map, whose beliefs change with what robots experience, on a line."""

from functools import partial

import numpy as np
import pytest

from tests.agents.line import Line, LineReachability, Plans, goals_at, line_map, navigation_over
from tutorial_lib.agents.mending import MendingNavigation
from tutorial_lib.interfaces import Plan
from tutorial_lib.topology.maintenance import Maintenance, MaintenanceRules

PLACES = range(8)


def sent(wall=np.inf, seen=np.inf, start=0.0):
    """A robot on the line, its navigation and the upkeep of its map."""
    reachability = LineReachability()
    reachability.wall = wall if np.isinf(seen) else np.inf  # what stands there looks like nothing
    topomap = line_map(PLACES, reachability)
    for source in PLACES[:-1]:
        topomap.connect(source, source + 1, 0.9, driven=1)
        topomap.connect(source + 1, source, 0.9, driven=1)
    upkeep = Maintenance(topomap.graph, MaintenanceRules(), 1.0, 1.0)
    plan = Plan(tuple(PLACES), 0, (0.9,) * (len(PLACES) + 1))
    mending = partial(MendingNavigation, upkeep=upkeep)
    navigation = navigation_over(topomap, Plans(plan), [goals_at(7.0)], kind=mending)
    return Line([start], wall, seen), navigation, upkeep


def test_edges_that_a_robot_passes_are_believed_more():
    line, navigation, upkeep = sent()
    line.go(navigation, 400)
    assert navigation.arrived.all()
    passed = {event.edge for event in upkeep.events}
    assert len(passed) >= 5
    assert all(target == source + 1 for source, target in passed)
    for source, target in passed:
        edge = upkeep.graph.edges[source, target]
        assert edge["probability"] > 0.9
        assert edge["weight"] == pytest.approx(-np.log(edge["probability"]))
        assert upkeep.graph.edges[target, source]["probability"] == 0.9


def test_what_stands_in_the_way_is_left_out_for_all_for_some_queries():
    line, navigation, upkeep = sent(wall=3.3, seen=3.6)
    line.go(navigation, 150)
    closed = {event.edge for event in upkeep.events if event.kind == "blocked"}
    assert (3, 4) in closed
    assert not upkeep.graph.has_edge(3, 4)
    assert upkeep.graph.has_edge(0, 1)
    upkeep.begin(MaintenanceRules().returns_blocked)
    assert upkeep.graph.edges[3, 4]["probability"] == pytest.approx(0.9)


def test_a_robot_that_never_got_going_blames_no_edge():
    line, navigation, upkeep = sent(wall=0.0)
    line.go(navigation, 150)
    assert navigation.setbacks
    assert not upkeep.events


def test_a_robot_that_lost_its_path_blames_the_edge_before_it():
    line, navigation, upkeep = sent(wall=4.4)
    line.go(navigation, 200)
    failed = [event.edge for event in upkeep.events if event.kind == "failure"]
    assert failed
    assert all(target in (5, 6) for _, target in failed)
