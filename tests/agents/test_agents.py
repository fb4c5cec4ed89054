"""Agents in a corridor of numbers, and in a simulated room."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.agents.line import (
    Line,
    LineController,
    LinePredictor,
    LineReachability,
    Plans,
    goals_at,
    line_map,
    navigation_along,
    navigation_over,
    sure,
)
from tests.made_up_maps import edges_of, numbered, places_in, sensed, table_map
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.agents.random import RandomAgent
from tutorial_lib.agents.returning import DISCRETE
from tutorial_lib.agents.sptm import SPTMAgent, similarities, window_median
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import HERE, Agent, Experience, Goals, Navigation, Plan
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.world.simulation import STEP, Simulation

# Navigation.


def test_a_plan_is_followed_to_its_goal():
    planned = Plans(sure((5, 6, 7, 8), 1))  # vertex v is at v - 4
    navigation, line = navigation_along(planned, [goals_at(-3, 5.5)]), Line([0.2])
    assert isinstance(navigation, Navigation)
    assert navigation.plans == [None]
    line.go(navigation, 1)
    assert navigation.plans == [planned.plans[0]]
    assert planned.queries[0][0] == 0.2
    assert planned.queries[0][2] == set()
    line.go(navigation, 200)
    assert navigation.arrived.tolist() == [True]
    assert not navigation.given_up[0]
    assert line.x[0] == pytest.approx(5.5, abs=0.25)
    assert len(planned.queries) == len(navigation.history[0]) == 1


def test_each_robot_goes_to_its_own_goal():
    plans = {3.5: sure((5, 6), 0), -2.5: sure((3, 2), 1), 0.6: sure((), 0)}
    goals = [goals_at(3.5), goals_at(7, -2.5), goals_at(0.6)]
    wanted = {id(goal): place for goal, place in zip(goals, plans, strict=True)}

    def find_path(observation, goals, excluded):
        return plans[wanted[id(goals)]]

    navigation, line = navigation_along(find_path, goals), Line([0.0, 0.1, -0.2])
    line.go(navigation, 200)
    assert navigation.arrived.all()
    assert line.x == pytest.approx([3.5, -2.5, 0.6], abs=0.25)
    assert [plans[0] for plans in navigation.history] == list(plans.values())


def test_a_lost_robot_replans_and_excludes_what_it_could_not_reach():
    # No robot gets past 2.4, so vertex 7 at 3 is not reached; the other goal is at -3.
    planned = Plans(sure((5, 6, 7, 8), 0), sure((5, 4, 3, 2), 1))
    navigation = navigation_along(planned, [goals_at(5, -3)], wall=2.4)
    line = Line([0.0], wall=2.4)
    line.go(navigation, 140)
    assert len(planned.queries) == 2
    place, _, excluded = planned.queries[1]
    assert place == pytest.approx(2.4, abs=0.5)
    # There are no edges on this map: of all vertices only the one visited last is where it may be.
    assert excluded == {(HERE, vertex) for vertex in navigation._topomap.alive.tolist()} - {
        (HERE, 6)
    }
    line.go(navigation, 300)
    assert navigation.arrived[0]
    assert line.x[0] == pytest.approx(-3, abs=0.25)
    assert navigation.history[0] == planned.plans
    assert navigation.plans[0] is planned.plans[1]
    assert len(planned.queries) == 2


def test_what_was_excluded_stays_excluded_while_it_replans():
    paths = (7, 8), (8,), (9,), ()
    planned = Plans(*(sure(path, 0) for path in paths))
    navigation = navigation_along(planned, [goals_at(5)], replan_time=14.0, wall=2.4)
    line = Line([2.0], wall=2.4)
    line.go(navigation, 400)
    # The goal itself is no vertex.
    steps = [{vertex for _, vertex in excluded} for _, _, excluded in planned.queries]
    assert steps[:4] == [set(), {7, 8}, {7, 8}, {7, 8, 9}]
    assert all(step == {7, 8, 9} for step in steps[4:])
    assert navigation.given_up[0]


@pytest.mark.parametrize("seconds", [0.0, 8.0, 30.0])
def test_a_robot_that_is_lost_for_too_long_gives_up(seconds):
    planned = Plans(sure((7, 8), 0))
    goals = [goals_at(5), goals_at(1)]
    navigation = navigation_along(planned, goals, replan_time=seconds, wall=2.4)
    navigation._find_path = lambda o, g, s: (
        planned(o, g, s) if len(g) and g.contexts[0, 1] == 5 else sure((5,), 0)
    )
    line = Line([2.0, 0.0], wall=2.4)
    steps = 0
    while not navigation.given_up[0]:
        line.go(navigation, 1)
        steps += 1
        assert steps < 600
    assert navigation.arrived.tolist() == [False, True]
    # It is lost for the first time after four seconds or more, and again as often.
    assert seconds - STEP < steps * STEP - 4.0 < seconds + 8.0
    plans = len(planned.queries)
    assert (plans == 1) == (seconds == 0.0)
    actions = navigation.act(line.observe(), np.array([0, 1]))
    assert (actions == 0).all()
    assert len(planned.queries) == plans


def test_a_robot_whose_path_is_refused_gives_up_at_once():
    planned = Plans(Plan((5, 6), 0, (0.5, 0.1, 0.9), refusal="the best path has probability 0.045"))
    navigation, line = navigation_along(planned, [goals_at(3)]), Line([0.0])
    actions = navigation.act(line.observe(), np.array([0]))
    assert (actions == 0).all()
    assert navigation.given_up.tolist() == [True]
    assert not navigation.arrived[0]
    assert navigation.plans[0].refusal
    assert (navigation.act(line.observe(), np.array([0])) == 0).all()
    assert len(planned.queries) == 1


def test_a_robot_without_a_plan_gives_up_before_long():
    planned = Plans(Plan(refusal="no path leads from what is seen here to the goal"))
    navigation, line = navigation_along(planned, [goals_at(3)]), Line([0.0])
    line.go(navigation, 260)
    assert navigation.given_up.tolist() == [True]
    assert abs(line.x[0]) < 0.6  # it turned in place
    assert len(planned.queries) >= 1
    assert all(plan.refusal for plan in navigation.history[0])


def test_what_failed_is_a_stretch_with_all_edges_beside_it():
    # 6 and 10 are at one place, 7 and 11 at another; 9 is only seen from 7, and 12 looks back.
    planned = Plans(sure((5, 6, 7), 0), sure((5, 4, 3, 2), 1))
    navigation, line = navigation_along(planned, [goals_at(5, -3)], wall=2.4), Line([0.0], wall=2.4)
    edges = [(5, 6), (6, 7), (6, 10), (10, 6), (7, 11), (11, 7), (7, 9)]
    for source, target in [*edges, (10, 11), (6, 11), (10, 9), (12, 7), (5, 7)]:
        navigation._topomap.connect(source, target, 0.9)
    assert navigation._topomap.connect_by_turn(6, 12, 0.8, np.pi)
    assert navigation._topomap.connect_by_turn(12, 6, 0.8, np.pi)
    line.go(navigation, 160)
    assert len(planned.queries) == 2
    excluded = planned.queries[1][2]
    assert {edge for edge in excluded if edge[0] != HERE} == {(6, 7), (6, 11), (10, 11)}
    around = {5, 6, 7, 9, 10, 11, 12}
    assert {vertex for source, vertex in excluded if source == HERE} & around == {7, 11}


def test_a_robot_under_way_takes_any_path_rather_than_none():
    refused = Plan(
        (5, 4, 3, 2), 1, (0.4, 0.5, 1.0, 1.0, 1.0), refusal="the best path has probability 0.2"
    )
    planned = Plans(sure((5, 6, 7, 8), 0), refused)
    navigation = navigation_along(planned, [goals_at(5, -3)], wall=2.4)
    line = Line([0.0], wall=2.4)
    line.go(navigation, 440)
    assert len(planned.queries) == 2
    assert navigation.arrived.tolist() == [True]
    assert not navigation.given_up[0]
    assert line.x[0] == pytest.approx(-3, abs=0.25)


class Steering(LineController):
    """Turns to the side on which the waypoint is."""

    def act(self, observations, waypoints):
        return np.column_stack([0 * waypoints[:, 0], np.sign(waypoints[:, 1])])


def test_a_robot_without_a_plan_searches_for_one():
    unknown = Plan(refusal="no path leads from what is seen here to the goal")
    planned = Plans(unknown, unknown, sure((5,), 0))
    navigation, line = navigation_along(planned, [goals_at(2)]), Line([0.0])
    navigation.follower.controller = Steering()
    robot = np.array([0])
    for _ in range(40):
        actions = navigation.act(line.observe(), robot)
        if len(planned.queries) == 3:
            break
        assert actions[0, 1] != 0
        assert navigation.plans == [None]
    navigation.follower.controller = LineController()
    line.go(navigation, 200)
    assert navigation.arrived[0]
    assert not navigation.given_up[0]


@pytest.mark.full
def test_a_robot_searches_for_twenty_seconds_each_time():
    unknown, wall = Plan(refusal="no path"), sure((7, 8), 0)
    # A plan every second; what is found after 15 s leads to a wall, and after 15 s more to a goal.
    planned = Plans(*[unknown] * 15, wall, *[unknown] * 15, sure((5, 4), 1))
    navigation = navigation_along(planned, [goals_at(5, -1)], wall=2.4)
    line = Line([2.0], wall=2.4)
    line.go(navigation, 600)
    assert len(planned.queries) == 32
    assert navigation.arrived[0]
    planned = Plans(unknown)
    navigation, line = navigation_along(planned, [goals_at(5)]), Line([2.0])
    line.go(navigation, 200)
    assert not navigation.given_up[0]
    line.go(navigation, 1)
    assert navigation.given_up[0]
    assert len(planned.queries) == 21


def test_a_robot_that_has_given_up_stands_still():
    planned = Plans(Plan(refusal="no path leads from what is seen here to the goal"))
    navigation, line = navigation_along(planned, [goals_at(2)]), Line([0.0])
    navigation.follower.controller = Steering()
    line.go(navigation, 400)
    assert navigation.given_up[0]
    queries = len(planned.queries)
    for _ in range(20):
        assert (navigation.act(line.observe(), np.array([0])) == 0).all()
    assert len(planned.queries) == queries


def test_a_robot_alone_does_as_in_a_fleet():
    starts, goals = [0.0, 0.6, -1.2], [goals_at(3), goals_at(5), goals_at(-3)]
    planner = DijkstraPlanner(least=0.0)

    def start(goals):
        navigation = navigation_along(None, goals)
        for a in range(12):
            navigation._topomap.connect(a, a + 1, 0.999)
            navigation._topomap.connect(a + 1, a, 0.999)
        navigation._find_path = lambda o, g, s: planner.plan(o, g, navigation._topomap, s)
        return navigation

    fleet, together = start(goals), Line(starts)
    together.go(fleet, 200)
    assert fleet.arrived.all()
    for robot in range(3):
        one, alone = start([goals[robot]]), Line([starts[robot]])
        alone.go(one, 200)
        assert alone.x[0] == together.x[robot]
        assert one.history[0] == fleet.history[robot]


def test_only_given_robots_plan_and_go_on():
    navigation = navigation_along(Plans(sure((5, 6), 0)), [goals_at(3)] * 3)
    line = Line([0.0, 0.0, 0.0])
    for _ in range(5):
        actions = navigation.act(line.observe(np.array([0, 2])), np.array([0, 2]))
        line.x[[0, 2]] += 0.1 * actions[:, 0]
    assert navigation.plans[1] is None
    assert line.x[1] == 0.0
    assert line.x[0] == line.x[2] > 0.1
    nobody = np.array([], dtype=int)
    assert navigation.act(line.observe(nobody), nobody).shape == (0, 2)


def test_navigation_over_an_empty_map_leads_to_what_is_in_sight():
    reachability = LineReachability()
    topomap, planner = TopoMap(reachability), DijkstraPlanner()
    goals = [goals_at(1.0), goals_at(9.0)]
    navigation = navigation_over(topomap, lambda o, g, s: planner.plan(o, g, topomap, s), goals)
    line = Line([0.0, 0.0])
    line.go(navigation, 260)
    assert navigation.arrived.tolist() == [True, False]
    assert navigation.given_up.tolist() == [False, True]
    assert line.x == pytest.approx([1.0, 0.0], abs=0.25)


# The agent of Meng 2020.


def driven_along(first, last, begin=0.0, step=0.05):
    """An experience of driving along the line."""
    x = np.arange(first, last, step if last > first else -step)
    seen = sensed(np.column_stack([x, 0 * x, 0 * x]))
    return Experience(seen, begin + 0.1 * np.arange(len(x)))


def meng(**changed):
    parts = {
        "predictor": LinePredictor(),
        "controller": LineController(),
        "reachability": LineReachability(),
        "settings": MapSettings(sequence=0, p_edge=0.99),
    }
    return MengAgent(**{**parts, **changed})


def test_an_agent_learns_a_sparse_map_trajectory_by_trajectory():
    agent = meng()
    assert isinstance(agent, Agent)
    agent.learn([driven_along(0, 10)])
    places = agent.topomap.vertices.observations[agent.topomap.alive].odometry[:, 0]
    assert places[0] == 0.0
    assert places[-1] == pytest.approx(9.95)
    assert (np.diff(places)[:-1] > 1.9).all()  # 2 m can be reached
    assert agent.topomap.vertices.contexts[np.array([1])].tolist() == [
        pytest.approx([places[1] - 0.15, places[1], places[1] + 0.15])
    ]
    agent.learn([driven_along(10, 20, 100.0)])
    assert len(agent.topomap.paths) == 2
    assert agent.topomap.vertices.timestamps.max() >= 100.0


def test_an_agent_that_has_learned_nothing_says_so():
    goals = [Goals(sensed(np.zeros((1, 3))), np.zeros((1, 3, 1)))]
    with pytest.raises(InputError, match="map: none; let the agent learn first"):
        meng().start(goals)


def test_a_class_in_place_of_a_part_is_refused():
    with pytest.raises(InputError, match="controller: the class LineController; give an object"):
        meng(controller=LineController)


def test_it_is_the_same_map_however_it_is_learned():
    one, two = meng(), meng()
    experiences = [driven_along(0, 6), driven_along(4, 12, 50.0), driven_along(6.02, 0, 99.0)]
    one.learn(experiences)
    for experience in experiences:
        two.learn([experience])
    assert edges_of(one.topomap) == edges_of(two.topomap)
    assert one.topomap.paths == two.topomap.paths
    assert len(one.topomap.paths) == 3


def test_every_trajectory_is_joined_by_turning_unless_that_is_off(monkeypatch):
    joined = []
    monkeypatch.setattr(
        "tutorial_lib.agents.meng.add_turns",
        lambda topomap, anchors, path, settings: joined.append((len(anchors), path, settings)),
    )
    drives = [driven_along(0, 6), driven_along(4, 12, 50.0)]
    agent = meng()
    agent.learn(drives)
    paths = [list(path) for _, path, _ in joined]
    assert paths == [list(path) for path in agent.topomap.paths]
    assert all(count == len(path) for count, path, _ in joined)
    assert all(used is agent.turns for *_, used in joined)
    joined.clear()
    meng(turns=None).learn(drives)
    assert not joined


def test_it_navigates_over_several_trajectories():
    agent = meng()
    agent.learn([driven_along(0, 6), driven_along(5, 12, 50.0)])
    line = Line([0.1, 2.0, 6.0])
    navigation = agent.start([goals_at(11.5), goals_at(7.3), goals_at(30.0)])
    line.go(navigation, 400)
    assert navigation.arrived.tolist() == [True, True, False]
    assert navigation.given_up.tolist() == [False, False, True]
    assert line.x[:2] == pytest.approx([11.5, 7.3], abs=0.25)
    assert len(navigation.history[0]) == 1
    assert navigation.plans[0].probability > 0.9


def test_what_was_blocked_since_is_tried_no_more_than_it_may_be():
    reachability = LineReachability()
    agent = meng(reachability=reachability, replan_time=30.0, planner=DijkstraPlanner(least=0.0))
    agent.learn([driven_along(0, 12)])
    reachability.wall = 5.0
    navigation, line = agent.start([goals_at(11.0)]), Line([0.1], wall=5.0)
    line.go(navigation, 900)
    assert navigation.given_up[0]
    assert line.x[0] <= 5.0
    first = navigation.history[0][0]
    assert first.vertices
    for plan in navigation.history[0][1:]:
        assert plan.vertices != first.vertices


def test_the_agent_plans_around_what_is_excluded_with_the_planner_it_was_given():
    class Recording:
        def __init__(self):
            self.queries = []

        def plan(self, observation, goals, topomap, excluded):
            self.queries.append((observation, goals, topomap, excluded))
            return Plan(refusal="no", probabilities=(0.1,))

    agent = meng(planner=Recording())
    agent.learn([driven_along(0, 3)])
    goals = goals_at(2.0)
    navigation = agent.start([goals])
    navigation.act(Line([0.5]).observe(), np.array([0]))
    ((observation, given, topomap, excluded),) = agent.planner.queries
    assert observation.odometry[0, 0] == 0.5
    assert given is goals
    assert topomap is agent.topomap
    assert excluded == set()


# SPTM.


@settings(max_examples=60)
@given(st.lists(st.integers(1, 5), min_size=1, max_size=3), st.integers(0, 3), st.integers(0, 999))
def test_the_median_is_over_aligned_neighbours_of_the_same_trajectories(lengths, window, seed):
    trajectory = np.repeat(np.arange(len(lengths)), lengths)
    count = len(trajectory)
    alike = np.random.default_rng(seed).random((count, count))
    found = window_median(alike, trajectory, window)
    for a in range(count):
        for b in range(count):
            some = [
                alike[a + step, b + step]
                for step in range(-window, window + 1)
                if min(a, b) + step >= 0
                and max(a, b) + step < count
                and trajectory[a + step] == trajectory[a]
                and trajectory[b + step] == trajectory[b]
            ]
            assert found[a, b] == pytest.approx(np.median(some), abs=1e-6)


def test_a_window_without_pairs_is_refused():
    with pytest.raises(InputError, match="window: -1; give a whole number, 0 or greater"):
        window_median(np.eye(2), np.zeros(2, int), -1)


def test_similarities_are_those_to_the_vertices_that_are_left():
    table = np.random.default_rng(0).random((9, 9))
    topomap = table_map(table, 6)
    topomap.remove([2])
    found = similarities(numbered([6, 7, 8]), topomap)
    assert found == pytest.approx(table[6:, [0, 1, 3, 4, 5]])


class Similar(LineReachability):
    """How alike two places of the line are; it uses the middle image alone."""

    def prepare(self, contexts):
        assert contexts.shape[1] == 1
        return super().prepare(contexts)

    def probability(self, observations, prepared):
        return np.clip(1 - np.abs(prepared - places_in(observations)[:, 0]) / 50, 0, 1)


def sptm(**changed):
    parts = {
        "similarity": Similar(),
        "predictor": LinePredictor(),
        "controller": LineController(),
        "reachability": LineReachability(),
        "s_shortcut": 0.975,  # 1.25 m apart
    }
    return SPTMAgent(**{**parts, **changed})


def test_sptm_keeps_every_nth_image_and_joins_what_is_alike():
    agent = sptm(every=20, window=0)
    assert isinstance(agent, Agent)
    agent.learn([driven_along(0, 5), driven_along(10, 15, 50.0), driven_along(0.5, 5.5, 99.0)])
    topomap = agent.topomap
    places = topomap.vertices.observations[topomap.alive].odometry[:, 0]
    assert places[:6] == pytest.approx([0, 1, 2, 3, 4, 4.95])
    assert topomap.paths == [list(range(6)), list(range(6, 12)), list(range(12, 18))]
    assert topomap.place[[0, 5, 6, 17]].tolist() == [0, 5, 0, 5]
    driven = {edge for edge, (_, often) in edges_of(topomap).items() if often}
    assert driven == {(a, b) for path in topomap.paths for a, b in zip(path, path[1:])}  # noqa: B905, RUF007
    for a in range(18):
        for b in range(18):
            same = topomap.trajectory[a] == topomap.trajectory[b]
            close = abs(places[a] - places[b]) < 1.25 - 1e-9
            wanted = close and not (same and abs(a - b) <= 1)
            assert topomap.graph.has_edge(a, b) == (wanted or (a, b) in driven)


def test_sptm_s_shortcuts_are_those_of_the_last_threshold():
    experiences = [driven_along(0, 5), driven_along(10, 15, 50.0), driven_along(0.5, 5.5, 99.0)]
    agents = [sptm(every=20, window=0, s_shortcut=least) for least in (0.93, 0.98, 0.93)]
    for agent in agents:
        agent.learn(experiences)
    many, few = len(agents[0].topomap.graph.edges), len(agents[1].topomap.graph.edges)
    assert many > few + 10
    agents[0].join(0.98)
    assert edges_of(agents[0].topomap) == edges_of(agents[1].topomap)
    agents[0].join(0.93)
    assert edges_of(agents[0].topomap) == edges_of(agents[2].topomap)


def test_sptm_takes_the_path_with_the_fewest_edges():
    agent = sptm(every=20, s_shortcut=0.9999)
    agent.learn([driven_along(0, 12)])
    agent.topomap.connect(2, 9, 0.01)  # improbable, but short
    plan = agent.find_path(Line([0.1]).observe(), goals_at(40.0, 11.1), set())
    assert plan == Plan((0, 1, 2, 9, 10, 11), 1)
    assert not plan.refusal
    excluded = agent.find_path(Line([0.1]).observe(), goals_at(11.1), {(2, 9)})
    assert excluded == Plan(tuple(range(12)), 0)
    nowhere = agent.find_path(Line([0.1]).observe(), goals_at(11.1), {(2, 9), (5, 6)})
    assert "no path" in nowhere.refusal


def test_a_plan_over_an_edge_that_turns_is_followed_with_that_turn():
    topomap = line_map(range(9), LineReachability())
    for vertex in range(8):
        topomap.connect(vertex, vertex + 1, 0.99)
    topomap.graph.remove_edge(2, 3)
    topomap.connect_by_turn(2, 3, 0.95, 1.25)
    navigation = navigation_over(topomap, Plans(sure((1, 2, 3, 4), 0)), [goals_at(4.5)])
    given, assign = [], navigation.follower.assign
    navigation.follower.assign = lambda *told: (given.append(told), assign(*told))
    Line([0.9]).go(navigation, 1)
    assert given == [(0, [1, 2, 3, 4, 9], {2: 1.25})]


def test_an_agent_that_replans_waits_less_than_the_follower_alone_and_never_doubts():
    parts = {"controller": LineController(), "reachability": LineReachability()}
    agent = MengAgent(predictor=LinePredictor(), **parts)
    assert agent.follower.timeout == 2.0 < FollowerSettings().timeout
    assert agent.follower.fall == DISCRETE.fall == 1.0


def test_sptm_begins_where_it_is_allowed_to():
    agent = sptm(every=20, s_shortcut=0.9999)
    agent.learn([driven_along(0, 12)])
    given = Line([5.1]).observe(), goals_at(11.1)
    assert agent.find_path(*given, set()).vertices[0] == 5
    assert agent.find_path(*given, {(HERE, 5), (HERE, 6)}).vertices[0] == 4
    every = {(HERE, vertex) for vertex in range(13)}
    assert agent.find_path(*given, every).refusal == "every first step is excluded"


def test_sptm_refuses_where_no_path_leads():
    agent = sptm(every=20, s_shortcut=0.9999)
    here = Line([5.0]).observe()
    assert agent.find_path(here, goals_at(3.0), set()).refusal == "the map is empty"
    agent.learn([driven_along(0, 6)])
    assert "no path leads" in agent.find_path(here, goals_at(0.0), set()).refusal
    assert agent.find_path(here, goals_at(0.0, 5.1), set()) == Plan((5,), 1)


def test_sptm_drives_by_the_same_follower():
    agent = sptm(every=20)
    agent.learn([driven_along(0, 6), driven_along(5.5, 12, 50.0)])
    navigation, line = agent.start([goals_at(11.0), goals_at(3.2)]), Line([0.1, 1.0])
    line.go(navigation, 400)
    assert navigation.arrived.all()
    assert line.x == pytest.approx([11.0, 3.2], abs=0.25)
    agent.learn([driven_along(12, 0, 99.0)])
    assert len(agent.topomap.paths) == 3


# The oracle and the random agent.


def test_an_oracle_drives_each_robot_to_its_goal_and_stops(box):
    paths = GridPaths(box.clearance)
    starts = np.array([[2.0, 2.0, 0.0], [8.0, 2.0, np.pi / 2], [2.0, 8.0, 0.0]])
    goals = np.array([[8.0, 3.0, 0.0], [7.0, 8.0, 1.0], [2.1, 8.0, 0.0]])
    simulation = Simulation(box, starts)
    navigation = OracleNavigation(simulation, paths, goals)
    assert isinstance(navigation, Navigation)
    last = np.zeros(3)
    for step in range(400):
        robots = np.flatnonzero(~navigation.arrived)
        if not robots.size:
            break
        actions = np.zeros((3, 2))
        actions[robots] = navigation.act(simulation.observe(robots), robots)
        gap = np.linalg.norm(simulation.poses[:, :2] - goals[:, :2], axis=1)
        assert (navigation.arrived[robots] == (gap[robots] < REACHED)).all()
        assert (actions[navigation.arrived] == 0).all()
        simulation.step(actions)
        last[robots] = step
    assert navigation.arrived.all()
    assert not navigation.given_up.any()
    assert not simulation.collided.any()
    assert last[2] == 0 < last[0]


class Knowing:
    """A predictor for which targets are poses, and that records its queries."""

    def __init__(self):
        self.queries = []

    def prepare(self, contexts):
        return contexts[:, 0]

    def predict(self, observations, targets):
        self.queries.append((observations.odometry[:, 0].tolist(), targets[:, 0].tolist()))
        gap = targets[:, 0] - observations.odometry[:, 0]
        overlap = np.clip(1 - np.abs(gap) - targets[:, 1], 0, 1)
        return np.column_stack([gap, 0 * gap]), np.column_stack([overlap, overlap])


def random_navigation(goals, seed=0):
    """Navigation to goals: for each robot poses (x, how little is seen from there, 0)."""
    agent = RandomAgent(Knowing(), LineController(), np.random.default_rng(seed))
    agent.learn([])
    assert isinstance(agent, Agent)
    shown = [np.array(some, dtype=float).reshape(-1, 3) for some in goals]
    navigation = agent.start([Goals(sensed(some), some[:, None]) for some in shown])
    assert isinstance(navigation, Navigation)
    return agent, navigation


def test_a_random_agent_knows_its_own_goal_when_it_is_there():
    # The second has two, of which the latter is here; the third sees too little of it.
    goals = [[5, 0, 0], [[9, 0, 0], [0.1, 0, 0]], [0.1, 0.5, 0], [0.3, 0, 0]]
    agent, navigation = random_navigation(goals)
    line = Line([0.0, 0.0, 0.0, 0.0])
    actions = navigation.act(line.observe(), np.arange(4))
    assert navigation.arrived.tolist() == [False, True, False, False]
    assert (actions[1] == 0).all()
    assert actions.shape == (4, 2)
    assert (actions[[0, 2, 3], 0] != 0).any()
    assert agent.predictor.queries == [([0.0] * 5, [5, 9, 0.1, 0.1, 0.3])]
    assert not navigation.given_up.any()


def test_a_random_agent_compares_each_robot_with_its_own_goals_only():
    agent, navigation = random_navigation([[0, 0, 0], [[7, 0, 0], [8, 0, 0]], [9, 0, 0]])
    line = Line([3.0, 7.9, 9.5])
    navigation.act(line.observe(np.array([1, 2])), np.array([1, 2]))
    assert agent.predictor.queries == [([7.9, 7.9, 9.5], [7, 8, 9])]
    assert navigation.arrived.tolist() == [False, True, False]


def test_random_navigation_depends_on_its_seed():
    def track(seed):
        _, navigation = random_navigation([[99, 0, 0]] * 2, seed)
        line = Line([0.0, 0.0])
        line.go(navigation, 50)
        return line.x.tolist()

    again = track(0)
    assert track(0) == again
    assert track(0) != track(1)
    assert track(0)[0] != track(0)[1]


def test_an_experience_says_what_it_lacks():
    one = driven_along(0, 1)
    with pytest.raises(InputError, match="experience: 20 observations, 19 timestamps"):
        replace(one, timestamps=one.timestamps[1:])
