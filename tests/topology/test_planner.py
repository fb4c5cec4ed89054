"""Plans over maps whose reachability is read from tables."""

from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.made_up_maps import Streets, Table, numbered, places_in, sensed, table_map
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import HERE, Goals, Localizer, Plan, Planner
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner, checked_plan

NO = 0.01


def goals_of(numbers):
    """Goal images of those numbers, for a `Table`."""
    numbers = np.asarray(numbers)
    return Goals(numbered(numbers), numbers[:, None])


@st.composite
def questions(draw):
    """A map of few vertices with edges at random, a place to be, and goals; and its RE."""
    count, goals = draw(st.integers(0, 5)), draw(st.integers(1, 2))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    # Vertices first, then here, then goals.
    size = count + 1 + goals
    table = rng.choice([0.0, 0.2, 0.6, 0.95, 1.0], (size, size)) * rng.uniform(
        0.98, 1, (size, size)
    )
    topomap = table_map(table, count) if count else TopoMap(Table(table))
    for a in range(count):
        for b in range(count):
            if a != b and rng.random() < 0.5:
                topomap.connect(a, b, rng.choice([0.01, 0.5, 0.9, 1.0]) * rng.uniform(0.9, 1.0))
    planner = DijkstraPlanner(
        least=draw(st.sampled_from([0.0, 0.3, 0.7])),
        p_query=draw(st.sampled_from([0.1, 0.5])),
        p_goal=draw(st.sampled_from([0.5, 0.9, 0.985])),
    )
    steps = [(a, b) for a in (HERE, *range(count)) for b in range(count)]
    excluded = {step for step in steps if rng.random() < 0.2} if draw(st.booleans()) else ()
    return topomap, count, list(range(count + 1, size)), planner, excluded


def simple_paths(topomap, here, goals, p_query, p_goal, excluded):
    """All simple paths: vertices, index of the goal, probability."""
    re, graph = topomap.vertices.reachability.table, topomap.graph
    found = []

    def go_on(path, probability):
        for number, goal in enumerate(goals):
            last = re[path[-1] if path else here, goal]
            if last > p_goal:
                found.append((tuple(path), number, probability * last))
        for v in graph:
            if v in path or (path[-1] if path else HERE, v) in excluded:
                continue
            if path and graph.has_edge(path[-1], v):
                go_on([*path, v], probability * graph.edges[path[-1], v]["probability"])
            elif not path and re[here, v] > p_query:
                go_on([v], re[here, v])

    go_on([], 1.0)
    return found


@settings(max_examples=250)
@given(questions())
def test_a_plan_is_the_most_probable_path_there_is(drawn):
    topomap, here, goals, planner, excluded = drawn
    before = nx.to_dict_of_dicts(topomap.graph.copy())
    plan = planner.plan(numbered([here]), goals_of(goals), topomap, excluded)
    assert nx.to_dict_of_dicts(topomap.graph) == before
    sure = simple_paths(topomap, here, goals, planner.p_query, planner.p_goal, excluded)
    some = simple_paths(topomap, here, goals, planner.p_query, planner.p_query, excluded)
    if sure or some:
        most = max(path[2] for path in sure or some)
        assert plan.probability == pytest.approx(most, rel=1e-9)
        fits = [path for path in sure or some if path[:2] == (plan.vertices, plan.goal)]
        assert fits[0][2] == pytest.approx(most, rel=1e-9)
        assert len(plan.probabilities) == len(plan.vertices) + 1
        assert bool(plan.refusal) == (not sure or most < planner.least)
    else:
        assert plan == Plan(refusal=plan.refusal)
        assert "no path leads" in plan.refusal
        assert plan.probability == 0.0
    assert not set(pairwise((HERE, *plan.vertices))) & set(excluded)


def line(count=4, here=1.0, goal=1.0, edge=0.9):
    """A map of vertices in a row; a robot "here", at `count`, reaches the first of them."""
    table = np.full((count + 3, count + 3), NO)
    table[count, 0], table[count - 1, count + 1] = here, goal
    topomap = table_map(table, count)
    for a, b in pairwise(range(count)):
        topomap.connect(a, b, edge)
    return topomap, numbered([count]), goals_of([count + 1])


def test_an_edge_at_either_end_needs_more_than_its_threshold():
    planner = DijkstraPlanner(least=0.0, p_query=0.5, p_goal=0.75)
    for here, goal, refused in ((0.5, 1.0, True), (1.0, 0.75, True), (0.51, 0.76, False)):
        topomap, start, goals = line(here=here, goal=goal)
        assert bool(planner.plan(start, goals, topomap).refusal) == refused


def test_probabilities_of_steps_are_listed_and_multiply():
    topomap, here, goals = line(4, here=0.8, goal=0.99, edge=0.95)
    plan = DijkstraPlanner().plan(here, goals, topomap)
    assert plan.vertices == (0, 1, 2, 3)
    assert plan.probabilities == pytest.approx((0.8, 0.95, 0.95, 0.95, 0.99))
    assert plan.probability == pytest.approx(0.8 * 0.95**3 * 0.99)
    assert plan.refusal == ""
    assert plan.goal == 0


def test_a_path_that_is_too_improbable_is_refused_and_reported():
    topomap, here, goals = line(5, edge=0.8)
    for least, words in ((0.5, r"probability 0.410, below 0.5"), (0.4, "")):
        plan = DijkstraPlanner(least=least).plan(here, goals, topomap)
        assert plan.probability == pytest.approx(0.8**4)
        assert plan.vertices == (0, 1, 2, 3, 4)
        assert words in plan.refusal
        assert bool(plan.refusal) == bool(words)


def test_a_goal_that_only_looks_a_little_like_the_map_is_refused():
    topomap, here, goals = line(4, goal=0.7)
    plan = DijkstraPlanner().plan(here, goals, topomap)
    assert "reached with 0.700 at best, not above 0.95; it may not be on the map" in plan.refusal
    assert plan.vertices == (0, 1, 2, 3)
    assert plan.probability == pytest.approx(0.9**3 * 0.7)
    assert not DijkstraPlanner(p_goal=0.6).plan(here, goals, topomap).refusal
    assert "no path" in DijkstraPlanner(p_query=0.8).plan(here, goals, topomap).refusal


def test_of_two_goals_the_one_that_is_sure_counts():
    topomap, here, _ = line(4)
    topomap.vertices.reachability.table[0, 6] = 0.9  # near, but not sure
    plan = DijkstraPlanner().plan(here, goals_of([6, 5]), topomap)
    assert plan.goal == 1
    assert plan.vertices == (0, 1, 2, 3)
    topomap.vertices.reachability.table[0, 6] = 0.99
    plan = DijkstraPlanner().plan(here, goals_of([6, 5]), topomap)
    assert (plan.goal, plan.vertices) == (0, (0,))


def test_a_robot_at_the_goal_needs_no_vertices():
    topomap, here, goals = line(4)
    topomap.vertices.reachability.table[4, 5] = 0.999
    plan = DijkstraPlanner().plan(here, goals, topomap)
    assert plan.vertices == ()
    assert plan.probabilities == (0.999,)
    assert plan.refusal == ""


def test_an_empty_map_leads_to_what_is_in_sight_only():
    reachability = Streets()
    topomap = TopoMap(reachability)
    here = sensed([[0.0, 0.0, 0.0]])
    near, far = np.array([[0.5, 0.0, 0.0]]), np.array([[5.0, 0.0, 0.0]])
    plan = DijkstraPlanner().plan(here, Goals(sensed(near), near[:, None]), topomap)
    assert (plan.vertices, plan.refusal) == ((), "")
    plan = DijkstraPlanner().plan(here, Goals(sensed(far), far[:, None]), topomap)
    assert plan.refusal == "no path leads from what is seen here to the goal"
    assert (plan.vertices, plan.probability) == ((), 0.0)


def test_an_excluded_edge_is_gone_round_or_leaves_no_path():
    topomap, here, goals = line(4)
    topomap.connect(0, 2, 0.7)
    planner = DijkstraPlanner()
    assert planner.plan(here, goals, topomap).vertices == (0, 1, 2, 3)
    plan = planner.plan(here, goals, topomap, {(0, 1)})
    assert plan.vertices == (0, 2, 3)
    assert plan.probability == pytest.approx(0.63)
    for excluded in ({(HERE, 0)}, {(2, 3)}, {(0, 1), (0, 2)}):
        assert "no path" in planner.plan(here, goals, topomap, excluded).refusal
    assert planner.plan(here, goals, topomap, {(99, 1), (1, 0)}).vertices == (0, 1, 2, 3)
    assert len(topomap) == 4


def test_a_vertex_that_was_removed_is_not_planned_over():
    topomap, here, goals = line(4)
    topomap.connect(0, 2, 0.7)
    topomap.remove([1])
    plan = DijkstraPlanner().plan(here, goals, topomap)
    assert plan.vertices == (0, 2, 3)


class Here:
    """A `Localizer` that returns what it was given."""

    def __init__(self, belief):
        self.belief = np.asarray(belief, dtype=float)

    def localize(self, observations, topomap):
        return self.belief


def test_a_localizer_decides_where_the_path_begins():
    topomap, here, goals = line(4, here=NO)
    topomap.remove([0])
    assert "no path" in DijkstraPlanner().plan(here, goals, topomap).refusal
    planner = DijkstraPlanner(localizer=Here([[0.0, 0.6, 0.0]]))
    plan = planner.plan(here, goals, topomap)
    assert plan.vertices == (2, 3)  # the second of those that are left
    assert plan.probabilities[0] == 0.6
    assert isinstance(planner.localizer, Localizer)


@pytest.mark.parametrize(
    ("belief", "words"),
    [
        ([1.0] * 4, r"shape \(4,\); give real numbers of shape \(1, 4\)"),
        ([[1.0] * 3], r"shape \(1, 3\)"),
        ([[2.0, 0, 0, 0]], r"2\.0; give finite numbers from 0 to 1"),
        ([[np.nan] * 4], "nan"),
        ([[-1.0] * 4], r"-1\.0"),
    ],
)
def test_a_localizer_that_returns_no_probabilities_is_named(belief, words):
    topomap, here, goals = line(4)
    with pytest.raises(InputError, match=f"localizer's probabilities: {words}"):
        DijkstraPlanner(localizer=Here(belief)).plan(here, goals, topomap)


def test_only_candidates_are_queried():
    class Alike(Streets):
        def embed(self, observations):
            x = places_in(observations)[:, 0] / 40
            return np.column_stack([np.cos(x), np.sin(x)]).astype(np.float32)[:, None]

    topomap = TopoMap(Alike())
    poses = np.column_stack([np.arange(50), np.zeros((50, 2))])
    topomap.make_vertices(
        sensed(poses), poses[:, None], np.arange(50), np.zeros(50, int), np.arange(50)
    )
    topomap.paths = [list(range(50))]
    for a, b in pairwise(range(50)):
        topomap.connect(a, b, 0.99)
    here, goal = sensed([[9.6, 0, 0]]), np.array([[30.5, 0, 0]])
    planner = DijkstraPlanner(candidates=6)
    plan = planner.plan(here, Goals(sensed(goal), goal[:, None]), topomap)
    assert plan.vertices == tuple(range(11, 30))  # 1.4 m ahead, and 1.5 m before the goal
    assert topomap.vertices.reachability.queries == topomap.vertices.queries == 6 + 6 + 1


@pytest.mark.parametrize("count", [0, 2])
def test_one_robot_plans(count):
    topomap, _, goals = line(4)
    with pytest.raises(InputError, match=f"plan: {count} observations; give one"):
        DijkstraPlanner().plan(numbered([4] * count), goals, topomap)


def test_goals_come_with_all_that_is_needed():
    assert len(goals_of([3, 4])) == 2
    for observations, contexts in ((0, 0), (2, 1)):
        with pytest.raises(InputError, match=f"goals: {observations} observations, {contexts} con"):
            Goals(numbered(range(observations)), np.zeros((contexts, 1)))


def test_a_plan_without_steps_promises_nothing():
    assert Plan().probability == 0.0
    assert Plan((1,), 0, (0.5, 0.5)).probability == 0.25
    assert Plan(np.array([1]), 0, np.full(2, 0.5)) == Plan((1,), 0, (0.5, 0.5))


@pytest.mark.parametrize(("vertices", "count", "steps"), [((), 2, 1), ((3,), 1, 2), ((3, 4), 4, 3)])
def test_a_plan_has_a_probability_of_every_step_or_none(vertices, count, steps):
    with pytest.raises(InputError, match=f"probabilities: {count} for .*; give {steps}, of every"):
        Plan(vertices, 0, (0.9,) * count)


def test_a_plan_leads_over_the_map_to_a_goal_or_is_refused():
    topomap, _, goals = line(4)
    for plan in (Plan((0, 1)), Plan((), 0, (0.9,)), Plan(refusal="no path")):
        assert checked_plan(plan, topomap, goals, {(1, 0), (HERE, 1)}) is plan
    wrong = {
        r"plan: leads to goal image 7, but there are \d+$": Plan((0, 1), 7),
        "plan: leads over 99, which is no vertex of the map": Plan((0, 99)),
        r"planner: .*\(0, 1\)": (0, 1),
        r"plan: takes edge \(1, 2\), which is excluded .*; plan around": Plan((0, 1, 2)),
        rf"plan: takes edge \({HERE}, 3\), which is excluded": Plan((3,)),
    }
    for words, plan in wrong.items():
        with pytest.raises(InputError, match=words):
            checked_plan(plan, topomap, goals, {(1, 2), (HERE, 3)})


def test_it_fits_the_seam():
    assert isinstance(DijkstraPlanner(), Planner)
