"""Beliefs about edges, and the events by which a map changes."""

import json
from itertools import product

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.topology.maintenance import (
    CERTAIN,
    Maintenance,
    MaintenanceRules,
    Traversal,
    bayes,
    gaussian,
    shared_bayes,
    undone,
)

inside = st.floats(0.01, 0.99)
certain = st.floats(0.0, 1.0)


@given(certain, inside, inside, st.booleans())
def test_bayes_is_the_ratio_of_counted_cases(prior, succeeds, deceives, success):
    def weight(exists):
        likely = succeeds if exists else deceives
        return (prior if exists else 1 - prior) * (likely if success else 1 - likely)

    posterior = bayes(prior, succeeds, deceives, success)
    assert posterior == pytest.approx(weight(True) / (weight(True) + weight(False)))
    assert 0.0 <= posterior <= 1.0
    if 0.01 < prior < 0.99:
        assert 0.0 < posterior < 1.0
        if abs(succeeds - deceives) > 1e-6:
            assert (posterior > prior) == (success == (succeeds > deceives))


@given(inside, inside, inside, inside, st.booleans())
def test_shared_blame_is_bayes_over_both_edges(at, prior, succeeds, deceives, success):
    weights = {}
    for there, exists in product((True, False), repeat=2):
        likely = succeeds if there and exists else deceives
        weights[there, exists] = (
            (at if there else 1 - at)
            * (prior if exists else 1 - prior)
            * (likely if success else 1 - likely)
        )
    total = sum(weights.values())
    expected = (
        (weights[True, True] + weights[True, False]) / total,
        (weights[True, True] + weights[False, True]) / total,
    )
    assert shared_bayes(at, prior, succeeds, deceives, success) == pytest.approx(expected)


@given(inside, inside, inside)
def test_a_robot_that_surely_is_there_blames_the_edge_alone(prior, succeeds, deceives):
    at, exists = shared_bayes(1.0, prior, succeeds, deceives, False)
    assert at == pytest.approx(1.0)
    assert exists == pytest.approx(bayes(prior, succeeds, deceives, False))


@given(st.floats(-5, 5), st.floats(1e-3, 10), st.lists(st.floats(-5, 5), max_size=8), inside)
def test_lengths_are_filtered_as_the_mean_of_all_measurements(mean, variance, measured, noise):
    first, now, spread = mean, mean, variance
    for value in measured:
        now, narrower = gaussian(now, spread, value, noise)
        assert narrower < spread
        spread = narrower
    weights = np.array([1 / variance] + [1 / noise] * len(measured))
    assert now == pytest.approx(np.average([first, *measured], weights=weights))
    assert spread == pytest.approx(1 / weights.sum())


@pytest.mark.parametrize("name", ["prior", "succeeds", "deceives"])
@pytest.mark.parametrize("value", [-0.1, 1.5, np.nan, "much"])
def test_probabilities_are_checked(name, value):
    given_ = {"prior": 0.5, "succeeds": 0.9, "deceives": 0.1, "success": True, name: value}
    with pytest.raises(InputError, match=f"^{name}"):
        bayes(**given_)


def chain(count=6):
    """Vertices in a row, joined in both directions."""
    graph = nx.DiGraph()
    for a in range(count - 1):
        for edge in ((a, a + 1), (a + 1, a)):
            reverse = edge[0] > edge[1]
            graph.add_edge(
                *edge,
                waypoint=(1.0, 0.0, 0.0),
                probability=0.9,
                length=1.0,
                variance=0.04,
                reverse=reverse,
                cost=4.0 if reverse else 1.0,
            )
    return graph


def mending(graph, **changed):
    return Maintenance(graph, MaintenanceRules(**changed), price=4.0, noise=0.04)


def as_text(graph):
    edges = sorted(
        (a, b, sorted(attributes.items())) for a, b, attributes in graph.edges(data=True)
    )
    return json.dumps([sorted(graph.nodes), edges])


def test_one_direction_s_update_leaves_the_other_alone():
    graph = chain()
    before = dict(graph.edges[2, 1])
    mending(graph).experienced(Traversal((1, 2), "local", True, 1.4))
    assert graph.edges[1, 2]["probability"] == pytest.approx(CERTAIN)
    assert graph.edges[1, 2]["length"] == pytest.approx(1.2)
    assert graph.edges[1, 2]["cost"] == pytest.approx(1.2)
    assert dict(graph.edges[2, 1]) == before


def test_an_edge_in_reverse_keeps_its_price():
    graph = chain()
    mending(graph).experienced(Traversal((2, 1), "local", True, 1.4))
    assert graph.edges[2, 1]["cost"] == pytest.approx(4 * 1.2)


def test_failures_prune_an_edge_and_only_that():
    graph = chain()
    upkeep = mending(graph)
    failed = Traversal((1, 2), "local", False, arrived_by=None)
    count = 0
    while graph.has_edge(1, 2):
        upkeep.experienced(failed)
        count += 1
    assert count == 2  # 0.9, then 0.49, then 0.09
    assert graph.number_of_edges() == 9
    upkeep.experienced(failed)  # another robot is late
    assert [event.kind for event in upkeep.events] == ["failure", "failure", "pruned"]


def test_an_innocent_edge_after_a_doubtful_one_is_spared():
    """The wormhole that led to the wrong place takes the blame."""
    alone, shared = chain(), chain()
    for graph in (alone, shared):
        graph.edges[0, 1]["probability"] = 0.3
    for _ in range(2):
        mending(alone, share_blame=False).experienced(
            Traversal((1, 2), "trusted", False, arrived_by=(0, 1))
        )
        if shared.has_edge(0, 1):
            mending(shared).experienced(Traversal((1, 2), "trusted", False, arrived_by=(0, 1)))
    assert not alone.has_edge(1, 2)
    assert shared.edges[1, 2]["probability"] > 0.6
    assert not shared.has_edge(0, 1)


def fail_until_pruned(upkeep, edge):
    while upkeep.graph.has_edge(*edge):
        upkeep.experienced(Traversal(edge, "local", False))


def test_pruned_edges_return_later_each_time():
    upkeep = mending(chain(), returns=10)
    upkeep.experienced(Traversal((1, 2), "local", True))
    gone = []
    for query in range(60):
        upkeep.begin(query)
        if upkeep.graph.has_edge(1, 2):
            fail_until_pruned(upkeep, (1, 2))
            gone.append(query)
    assert gone == [0, 10, 30]
    never = mending(chain(), returns=0)
    never.experienced(Traversal((1, 2), "local", True))
    never.prune_edge((1, 2))
    never.begin(10**6)
    assert not never.graph.has_edge(1, 2)


def test_an_edge_that_never_worked_does_not_come_back_by_itself():
    upkeep = mending(chain(), returns=10)
    fail_until_pruned(upkeep, (1, 2))
    upkeep.begin(10**6)
    assert not upkeep.graph.has_edge(1, 2)
    upkeep.bring_back((1, 2))
    assert upkeep.graph.edges[1, 2]["probability"] == pytest.approx(0.3)


def test_what_is_blocked_comes_back_as_it_was_always_after_as_many_queries():
    upkeep = mending(chain(), returns=50, returns_blocked=3)
    for query in (0, 3, 6):
        upkeep.begin(query)
        assert upkeep.graph.edges[1, 2]["probability"] == pytest.approx(0.9)
        upkeep.prune_edge((1, 2), blocked=True)
    upkeep.begin(8)
    assert not upkeep.graph.has_edge(1, 2)
    upkeep.begin(9)
    assert upkeep.graph.has_edge(1, 2)


def test_a_look_is_no_traversal():
    """A target that is not seen speaks against an edge; nothing was driven, so no length."""
    looked, driven = chain(), chain()
    mending(looked).experienced(Traversal((1, 2), "global", False, looked=True))
    mending(driven).experienced(Traversal((1, 2), "global", False))
    rules = MaintenanceRules()
    for graph, likelihoods in (
        (looked, (rules.sees["global"], rules.imagines)),
        (driven, (rules.succeeds["global"], rules.deceives)),
    ):
        after = graph.edges[1, 2]
        assert after["probability"] == pytest.approx(bayes(0.9, *likelihoods, False))
        assert after["length"] == chain().edges[1, 2]["length"]


def test_no_edge_is_beyond_doubt_and_a_success_makes_none_less_sure():
    graph = chain()
    graph.edges[1, 2]["probability"] = 0.9999
    mending(graph).experienced(Traversal((1, 2), "local", True))
    assert graph.edges[1, 2]["probability"] == pytest.approx(0.9999)
    mending(graph).experienced(Traversal((1, 2), "local", False))
    assert graph.edges[1, 2]["probability"] == pytest.approx(bayes(CERTAIN, 0.9, 0.05, False))


def test_a_blocked_way_is_closed_at_once_in_both_directions_and_opens_soon():
    graph = chain()
    upkeep = mending(graph, returns=50, returns_blocked=5)
    upkeep.begin(0)
    upkeep.experienced(Traversal((1, 2), "trusted", False, blocked=((1, 2), (2, 1))))
    assert not graph.has_edge(1, 2)
    assert not graph.has_edge(2, 1)
    assert [event.kind for event in upkeep.events] == ["blocked", "blocked"]
    upkeep.begin(5)
    assert graph.has_edge(1, 2)
    assert graph.has_edge(2, 1)


traversals = st.lists(
    st.tuples(
        st.integers(0, 5),
        st.integers(0, 5),
        st.sampled_from(("trusted", "local", "global", "presumed")),
        st.booleans(),
        st.one_of(st.none(), st.floats(0.1, 3.0)),
        st.one_of(st.none(), st.integers(0, 5)),
        st.booleans(),
    ),
    max_size=40,
)


@given(traversals)
def test_undoing_all_events_gives_the_first_map(attempts):
    graph = chain()
    first = as_text(graph)
    upkeep = mending(graph, returns=4, returns_blocked=2)
    for query, (a, b, kind, success, measured, before, blocked) in enumerate(attempts):
        upkeep.begin(query)
        arrived_by, both = None if before is None else (before, a), ((a, b), (b, a))
        upkeep.experienced(Traversal((a, b), kind, success, measured, arrived_by, both * blocked))
        for _, _, edge in graph.edges(data=True):
            assert 1 - CERTAIN - 1e-9 <= edge["probability"] <= CERTAIN + 1e-9
            assert 0 < edge["variance"] <= 0.04
    upkeep.add_vertex(9)
    upkeep.add_edge((9, 3), dict(next(iter(chain().edges(data=True)))[2]))
    assert as_text(undone(graph, upkeep.events)) == first
    half = len(upkeep.events) // 2
    twice = undone(undone(graph, upkeep.events[half:]), upkeep.events[:half])
    assert as_text(twice) == first
