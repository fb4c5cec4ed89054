"""Meng's map, whose beliefs change with what robots experience, on a line."""

from functools import partial

import numpy as np
import pytest

from tests.agents.line import (
    Line,
    LinePredictor,
    LineReachability,
    Plans,
    at_places,
    goals_at,
    line_map,
    navigation_over,
)
from tutorial_lib.agents.mending import MendingMengAgent, MendingNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Plan
from tutorial_lib.topology.maintenance import Maintenance, MaintenanceRules
from tutorial_lib.topology.mapping.anchors import Anchors

PLACES = range(8)


DOUBT = 0.5
ALONG = Plan(tuple(PLACES), 0, (0.9,) * (len(PLACES) + 1))


def sent(wall=np.inf, seen=np.inf, start=0.0, find_path=None):
    """A robot on the line, its navigation, the graph of its map and the upkeep."""
    reachability = LineReachability()
    reachability.wall = wall if np.isinf(seen) else np.inf  # what stands there looks like nothing
    topomap = line_map(PLACES, reachability)
    for source in PLACES[:-1]:
        topomap.connect(source, source + 1, 0.9, driven=1)
        topomap.connect(source + 1, source, 0.9, driven=1)
    upkeep = Maintenance(topomap.graph.copy(), MaintenanceRules(), 1.0, 1.0)
    mending = partial(MendingNavigation, upkeep, DOUBT)
    find_path = find_path or Plans(ALONG)
    navigation = navigation_over(topomap, find_path, [goals_at(7.0)], kind=mending)
    return Line([start], wall, seen), navigation, topomap.graph, upkeep


def costs(belief):
    """Of an edge on which RE is 0.9."""
    return -np.log(0.9) + DOUBT * max(np.log(0.9 / belief), 0.0)


def test_edges_that_a_robot_passes_are_believed_more():
    line, navigation, graph, upkeep = sent()
    line.go(navigation, 400)
    assert navigation.arrived.all()
    passed = {event.edge for event in upkeep.events}
    assert len(passed) >= 5
    assert all(target == source + 1 for source, target in passed)
    for source, target in passed:
        assert upkeep.graph.edges[source, target]["probability"] > 0.9
        assert upkeep.graph.edges[target, source]["probability"] == 0.9
        assert graph.edges[source, target]["probability"] == 0.9
        assert graph.edges[source, target]["weight"] == pytest.approx(costs(0.9))


def test_what_stands_in_the_way_is_left_out_for_all_for_some_queries():
    line, navigation, _, upkeep = sent(wall=3.3, seen=3.6)
    line.go(navigation, 150)
    closed = {event.edge for event in upkeep.events if event.kind == "blocked"}
    assert (3, 4) in closed
    assert not upkeep.graph.has_edge(3, 4)
    assert upkeep.graph.has_edge(0, 1)
    upkeep.begin(MaintenanceRules().returns_blocked)
    assert upkeep.graph.edges[3, 4]["probability"] == pytest.approx(0.9)


def test_a_robot_that_never_got_going_blames_no_edge():
    line, navigation, _, upkeep = sent(wall=0.0)
    line.go(navigation, 150)
    assert navigation.setbacks
    assert not upkeep.events


def test_a_robot_that_lost_its_path_blames_the_edge_before_it_which_then_costs_more():
    line, navigation, graph, upkeep = sent(wall=4.4)
    line.go(navigation, 200)
    failed = [event.edge for event in upkeep.events if event.kind == "failure"]
    assert failed
    assert all(target in (5, 6) for _, target in failed)
    for edge in set(failed).intersection(upkeep.graph.edges):
        belief = upkeep.graph.edges[edge]["probability"]
        assert belief < 0.9
        assert graph.edges[edge]["weight"] == pytest.approx(costs(belief))
        assert graph.edges[edge]["probability"] == 0.9


@pytest.mark.parametrize("there_is_another", [True, False])
def test_a_pruned_edge_returns_only_where_no_other_path_is_left(there_is_another):
    asked = []

    def find_path(observation, goals, excluded):
        asked.append(set(excluded))
        left = there_is_another or (2, 3) not in excluded
        return ALONG if left else Plan(refusal="no path")

    line, navigation, graph, upkeep = sent(find_path=find_path)
    for edge in ((2, 3), (5, 4)):
        upkeep.prune_edge(edge)
    upkeep.prune_edge((1, 0), blocked=True)
    line.go(navigation, 2)
    assert {(2, 3), (5, 4), (1, 0)} <= asked[0]
    assert all((1, 0) in excluded for excluded in asked)
    assert upkeep.graph.has_edge(2, 3) != there_is_another
    assert not upkeep.graph.has_edge(5, 4)
    if not there_is_another:
        assert graph.edges[2, 3]["weight"] == pytest.approx(costs(0.3))
    assert navigation.plans == [ALONG]


def test_where_nothing_leads_on_no_edge_returns():
    line, navigation, _, upkeep = sent(find_path=Plans(Plan(refusal="no path")))
    upkeep.prune_edge((2, 3))
    line.go(navigation, 2)
    assert not upkeep.graph.has_edge(2, 3)


def test_with_every_trajectory_upkeep_begins_anew_from_what_re_said():
    agent = MendingMengAgent(predictor=LinePredictor(), reachability=LineReachability())
    places = np.array(PLACES, dtype=float)
    anchors = Anchors(at_places(*places), np.tile(places[:, None], (1, 3)), places)
    agent.insert(anchors)
    agent.upkeep.prune_edge((0, 1))
    assert agent.topomap.graph.has_edge(0, 1)
    agent.topomap.graph.edges[0, 1]["weight"] = 5.0
    agent.insert(anchors)
    known = agent.topomap.graph.edges[0, 1]
    assert known["weight"] == pytest.approx(-np.log(known["probability"]))
    assert set(agent.upkeep.graph.edges) == set(agent.topomap.graph.edges)
    agent.upkeep.prune_edge((0, 1))
    assert agent.topomap.graph.has_edge(0, 1)


def test_an_agent_that_has_learned_nothing_says_so():
    agent = MendingMengAgent(predictor=LinePredictor(), reachability=LineReachability())
    with pytest.raises(InputError, match="map: none; let the agent learn first"):
        agent.start([goals_at(1.0)])
