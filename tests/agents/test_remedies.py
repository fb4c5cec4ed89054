"""Remedies for look-alike places, of robots on a line."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.agents.line import (
    Line,
    LineController,
    LinePredictor,
    LineReachability,
    goals_at,
    line_map,
)
from tests.made_up_maps import sensed
from tutorial_lib.agents.place_guess import Weighted
from tutorial_lib.agents.remedies import REMEDIES, Remedies
from tutorial_lib.agents.remedy_agent import SEQUENCE, RemedyAgent
from tutorial_lib.agents.remedy_navigation import CYCLE, ENDLESS
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Navigation, Plan
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.localization import OFF_MAP
from tutorial_lib.topology.mapping.edge_rules import MapSettings

PLACES = range(-4, 9)


def agent_on_line(name="all", wall=np.inf, joined=True, **changed):
    """An agent whose map has a vertex at each whole place, joined to its neighbours."""
    reachability = LineReachability()
    reachability.wall = wall
    agent = RemedyAgent(
        predictor=LinePredictor(),
        controller=LineController(),
        reachability=reachability,
        remedies=Remedies.named(name),
        **changed,
    )
    agent.topomap = line_map(PLACES, reachability)
    for vertex in range(len(PLACES) - 1 if joined else 0):
        agent.topomap.connect(vertex, vertex + 1, 0.99)
        agent.topomap.connect(vertex + 1, vertex, 0.99)
    return agent


# Names.


def test_each_row_of_the_experiment_has_its_remedies():
    on = {name: Remedies.named(name) for name in REMEDIES}
    assert (
        *("none", "sequence", "replan", "cycles", "filter"),
        *("no_sequence", "no_replan", "no_cycles", "no_filter", "all"),
    ) == REMEDIES
    assert on["none"] == Remedies(False, False, False, False)
    assert on["all"] == Remedies(True, True, True, True)
    assert on["replan"] == Remedies(False, True, False, False)
    assert on["no_cycles"] == Remedies(True, True, False, True)
    assert len(set(on.values())) == len(REMEDIES)


def test_an_unknown_remedy_is_refused():
    with pytest.raises(InputError, match="name: 'prayer'; give none, sequence"):
        Remedies.named("prayer")


def test_a_planner_whose_localizer_cannot_be_replaced_is_refused():
    with pytest.raises(InputError, match="give a DijkstraPlanner"):
        agent_on_line(planner=SimpleNamespace(plan=len))


def test_sequences_count_in_the_map_only_where_they_are_on():
    for name, reach in (("none", 0), ("no_sequence", 0), ("sequence", SEQUENCE), ("all", SEQUENCE)):
        agent = agent_on_line(name, settings=MapSettings(p_edge=0.9))
        settings = agent.empty_map().settings
        assert (settings.sequence, settings.reuse_sequence) == (reach, reach)
        assert settings.p_edge == 0.9


def test_a_map_goes_with_the_remedies_that_made_it():
    agent = agent_on_line("all")
    other = agent.with_remedies(Remedies.named("no_filter"))
    assert other.topomap is agent.topomap
    assert not other.remedies.filter
    with pytest.raises(InputError, match="a map is built with sequences or without"):
        agent.with_remedies(Remedies.named("no_sequence"))


@pytest.mark.parametrize(
    "begin", [lambda agent: agent.start([goals_at(1)]), lambda agent: agent.guess(1)]
)
def test_an_agent_that_has_learned_nothing_says_so(begin):
    agent = agent_on_line()
    agent.topomap = agent.empty_map()
    with pytest.raises(InputError, match="map: none; let the agent learn first"):
        begin(agent)


# Navigation.


@pytest.mark.parametrize("name", REMEDIES)
@pytest.mark.few(2)
def test_a_goal_in_sight_is_reached_with_any_remedies(name):
    navigation, line = agent_on_line(name).start([goals_at(5.5)]), Line([0.2])
    assert isinstance(navigation, Navigation)
    line.go(navigation, 250)
    assert navigation.arrived[0], (navigation.plans, navigation.history)
    assert line.x[0] == pytest.approx(5.5, abs=0.3)
    assert not navigation.lost[0]


def test_without_replanning_a_lost_robot_gives_up():
    plans = {}
    for name in ("none", "replan"):
        navigation = agent_on_line(name, wall=2.4).start([goals_at(5)])
        Line([0.0], wall=2.4).go(navigation, 80)
        plans[name] = len(navigation.history[0]), bool(navigation.given_up[0])
    assert plans["none"] == (1, True)
    assert plans["replan"][0] > 1


def test_argmax_starts_at_one_vertex_and_the_filter_at_any_likely_one():
    argmax = agent_on_line("none").start([goals_at(5)])
    weights = argmax.guess.weights(Line([0.1]).observe(), 0)
    assert weights.tolist() == np.eye(13)[4].tolist()
    belief = agent_on_line("filter").start([goals_at(5)])
    line = Line([0.1])
    belief.act(line.observe(), np.array([0]))
    weights = belief.guess.weights(line.observe(), 0)
    assert weights.max() == 1.0
    assert weights[4] > 0.8
    assert weights[12] == weights.min() > 0


def test_a_path_from_an_unlikely_vertex_is_worth_less():
    topomap = agent_on_line().topomap
    likely = np.zeros(13)
    likely[[4, 5]] = 1.0, 0.3
    found = Weighted(likely, 0.5, 64).localize(Line([0.0]).observe(), topomap)
    assert found.shape == (1, 13)
    assert found[0, 4] == pytest.approx(0.9999)
    assert found[0, 5] == pytest.approx(0.3 * 0.9989)
    assert np.count_nonzero(found) == 2


def test_starts_around_the_believed_vertex_are_as_good_and_all_are_off_the_map():
    guess, seen = agent_on_line("filter").start([goals_at(5)]).guess, Line([0.0]).observe()
    guess.filter.belief[0] = np.eye(14)[4]
    assert guess.weights(seen, 0).tolist() == [0.3] * 2 + [1.0] * 5 + [0.3] * 6
    guess.filter.belief[0] = np.append(np.eye(13)[4] * 0.4, 0.6)
    assert guess.weights(seen, 0).tolist() == [1.0] * 13


def test_a_sequence_has_the_last_four_views_and_they_are_apart():
    guess = agent_on_line("sequence").start([goals_at(5)]).guess
    counts = []
    for x in (0.0, 0.5, 0.8, 1.6, 2.4, 3.2, 4.0):
        guess.observe(Line([x]).observe(), np.array([0]))
        counts.append(len(guess._views[0]))
    assert counts == [1, 1, 2, 3, 4, 4, 4]
    assert [int(view.argmax()) - 4 for view in guess._views[0]] == [2, 2, 3, 4]


@pytest.mark.parametrize(("other", "steps"), [(0.85, 10), (0.8, 20), (0.95, 10)])
def test_the_longer_a_robot_reckons_the_less_its_plan_is_worth(other, steps):
    navigation = agent_on_line("replan").start([goals_at(5)])
    plan, better = Plan((4, 5), 0, (0.9, 1.0, 1.0)), Plan((4,), 0, (other, 1.0))
    navigation.plans[0] = plan
    navigation.follower.assign(0, [4, 5, 13])
    navigation._path = lambda observation, robot: better
    navigation.follower.memory.state[0] = State.DEAD_RECKONING
    for _ in range(steps):
        assert navigation.plans[0] is plan
        navigation._doubt(Line([0.0]).observe(), 0)
    assert navigation.plans[0] is None
    assert navigation._ready[0] is better


# Cycles.


def test_visits_are_counted_and_edges_to_what_was_visited_lose_probability():
    navigation = agent_on_line("cycles").start([goals_at(5)])
    navigation.plans[0] = Plan((4, 5, 6), 0, (0.9,) * 4)
    navigation.follower.assign(0, [4, 5, 6, 13])
    for place in (0, 0, 1, 0, 1):
        navigation.follower.memory.visited[0] = place
        navigation._count_visit(0)
    assert navigation.visits[0, [4, 5, 6]].tolist() == [2, 2, 0]
    biased = navigation._biased(0)
    assert biased.graph.edges[3, 4]["probability"] == pytest.approx(0.495)
    assert biased.graph.edges[3, 4]["weight"] == pytest.approx(-np.log(0.495))
    assert biased.graph.edges[5, 6]["probability"] == 0.99
    assert navigation._topomap.graph.edges[3, 4]["probability"] == 0.99


def test_in_a_cycle_the_robot_plans_again_and_in_the_end_gives_up():
    for name, plans_again in (("cycles", True), ("replan", False)):
        navigation = agent_on_line(name).start([goals_at(5)])
        plan = Plan((4, 5), 0, (0.9,) * 3)
        for visit in range(1, ENDLESS + 1):
            for place in (0, 1):
                navigation.plans[0] = plan
                navigation.follower.memory.visited[0] = place
                navigation._count_visit(0)
            assert (navigation.plans[0] is None) == (plans_again and visit >= CYCLE)
        assert navigation.given_up[0] == plans_again


# The filter, and recovery.


class Strange(LinePredictor):
    """Overlaps that fall to nothing where x is above 20: a room that is not on the map."""

    def predict(self, observations, targets):
        waypoints, overlaps = super().predict(observations, targets)
        return waypoints, np.where(observations.odometry[:, :1] > 20, 0.0, overlaps)


def test_a_robot_off_the_map_turns_backs_up_and_says_that_it_is_lost():
    agent = agent_on_line("filter")
    agent.predictor = Strange()
    navigation = agent.start([goals_at(5)])
    gone = []
    for _ in range(320):
        seen = sensed([[40.0, 0.0, 0.0]])
        if navigation.given_up[0]:
            break
        gone.append(navigation.act(seen, np.array([0]))[0, 0])
    assert navigation.guess.filter.vertex[0] == OFF_MAP
    assert navigation.lost[0]
    assert min(gone) < 0
    assert gone[0] >= 0
    assert 150 < len(gone) < 260


def test_without_the_filter_a_robot_does_not_back_up():
    navigation = agent_on_line("replan", joined=False).start([goals_at(5)])
    gone = []
    for _ in range(220):
        if navigation.given_up[0]:
            break
        gone.append(navigation.act(sensed([[40.0, 0.0, 0.0]]), np.array([0]))[0, 0])
    assert navigation.given_up[0]
    assert min(gone) >= 0


def at_plan(navigation, vertices, column=None):
    """Give robot 0 a plan, and all its belief to a column."""
    navigation.plans[0] = Plan(vertices, 0, (0.9,) * (len(vertices) + 1))
    navigation.follower.assign(0, [*vertices, 13])
    if column is not None:
        navigation.guess.filter.belief[0] = np.eye(14)[column]


def compare(navigation, looks=3):
    for _ in range(looks):
        navigation._compare(0)
    return navigation.plans[0] is not None


def test_a_plan_that_the_belief_has_left_is_dropped_and_nobody_is_to_blame():
    navigation, line = agent_on_line("all").start([goals_at(8)]), Line([-4.0])
    line.go(navigation, 20)
    assert navigation.plans[0] is not None
    at_plan(navigation, (0, 1, 2), 1)
    assert compare(navigation)
    navigation.guess.filter.belief[0] = np.eye(14)[12]  # far from where the plan has it
    assert compare(navigation, 2)
    assert not compare(navigation, 1)
    odometry = line.observe().odometry[0]
    for where, blamed in ((12, False), (1, True)):
        at_plan(navigation, (0, 1, 2), where)
        navigation._lose(0, odometry)
        assert navigation.plans[0] is None
        assert bool(navigation._blockades.excluded(0, odometry, navigation._now[0])) == blamed


def test_a_plan_that_was_a_guess_is_kept_until_the_belief_has_been_with_it():
    navigation, line = agent_on_line("all").start([goals_at(8)]), Line([-4.0])
    at_plan(navigation, (0, 1, 2), 12)
    assert compare(navigation, 10)
    navigation.guess.filter.belief[0] = np.eye(14)[1]
    assert compare(navigation, 1)
    navigation.guess.filter.belief[0] = np.eye(14)[12]
    assert not compare(navigation)
    navigation._plan(line.observe()[[0]], 0)  # the next plan is compared anew
    at_plan(navigation, (0, 1, 2), 12)
    assert compare(navigation, 10)


def test_while_it_follows_a_robot_between_vertices_keeps_its_plan():
    navigation = agent_on_line("all").start([goals_at(8)])
    at_plan(navigation, (0, 1, 2), 1)
    assert compare(navigation, 1)
    navigation.guess.filter.belief[0] = np.append(np.eye(13)[12] * 0.4, 0.6)
    navigation.follower.memory.state[0] = State.FOLLOW
    assert compare(navigation, 10)
    navigation.follower.memory.state[0] = State.DEAD_RECKONING
    assert compare(navigation, 2)
    assert not compare(navigation, 1)


def test_one_of_many_twins_is_as_good_as_the_others():
    guess = agent_on_line("all").start([goals_at(8)]).guess
    guess.filter.belief[0] = np.append(np.full(13, 1 / 13), 0.0)
    assert guess.far_from(0, [6]) == pytest.approx(0.0)
    guess.filter.belief[0] = np.append(np.eye(13)[2] * 0.2, 0.8)
    assert guess.far_from(0, [2]) == pytest.approx(0.75)  # more likely it is off the map
    guess.filter.belief[0] = np.eye(14)[2]
    assert guess.far_from(0, [2, 12]) == 0.0
    assert guess.far_from(0, [12]) == 1.0


def test_where_sequences_count_turns_are_for_goals_that_no_other_path_leads_to():
    for name, first in (("none", (4, 9)), ("sequence", (4, 5, 6, 7, 8))):
        agent = agent_on_line(name)
        assert agent.topomap.connect_by_turn(4, 9, 0.999, np.pi)
        navigation = agent.start([goals_at(5.5)])
        Line([0.0]).go(navigation, 1)
        assert navigation.history[0][0].vertices == first
    agent.topomap.graph.remove_edge(6, 7)
    navigation = agent.start([goals_at(5.5)])
    Line([0.0]).go(navigation, 1)
    assert navigation.history[0][0].vertices == (4, 9)
