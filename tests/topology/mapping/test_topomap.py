"""Maps and how trajectories join them; what is reachable is made up."""

from collections import Counter
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.made_up_maps import (
    Streets,
    StreetsAlike,
    Table,
    anchors,
    anchors_at,
    edges_of,
    numbered,
    sensed,
    street,
    table_map,
)
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Goals, Reachability
from tutorial_lib.topology.mapping.anchors import Anchors, anchors_of
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.vertices import Vertices
from tutorial_lib.topology.planner import DijkstraPlanner

YES, NO = 0.999, 0.01
WEST, SOUTH = street((6, 0), (0, 0), step=0.4), street((3, 3), (3, -3), step=0.4)


class ByTheBook:
    """A map of numbered anchors, made pair by pair from a table of RE."""

    def __init__(self, table, settings):
        self.re, self.settings = table, settings
        self.made_for, self.paths, self.edges = {}, [], {}

    def aligned(self, path, place):
        """What is around a place of a path, by the distance to it."""
        reach = self.settings.sequence
        steps = range(-reach, reach + 1)
        return {s: path[place + s] for s in steps if 0 <= place + s < len(path)}

    def connect(self, source, target, probability, driven=0):
        old, often = self.edges.get((source, target), (0.0, 0))
        self.edges[source, target] = (max(probability, old), often + driven)

    def ahead(self, v, passed):
        """Whether a vertex lies ahead of all that were passed."""
        owner, place = self.made_for[v]
        return not any((owner, place) <= self.made_for[u] for u in passed if self.is_on(u, owner))

    def is_on(self, vertex, owner):
        return self.made_for[vertex][0] == owner

    def best(self, new, a, taken):
        """The vertex that takes the place of an anchor, or the two of an edge, or none."""
        before, after = new[max(a - 1, 0)], new[min(a + 1, len(new) - 1)]
        # From a vertex that was reused, RE of the anchor there says nothing.
        now = taken.get(a - 1, [before])[-1]
        passed = [u for others in taken.values() for u in others]
        free = [v for v in sorted(self.made_for) if self.ahead(v, passed)]
        least, beside = self.settings.p_reuse, self.settings.p_between
        found = {}
        for v in free:
            steps = self.re[now, v], self.re[v, after]
            if min(steps) > least:
                found[v,] = np.prod(steps)
        if found:
            return list(max(found, key=found.get))
        for (v, w), (probability, _) in self.edges.items():
            steps = self.re[now, v], probability, self.re[w, after]
            lies = min(self.re[v, new[a]], self.re[new[a], w]) > beside
            if {v, w} <= set(free) and self.ahead(w, [v]) and lies and min(steps) > least:
                found[v, w] = np.prod(steps)
        return list(max(found, key=found.get)) if found else []

    def add(self, new):
        taken = {}
        for a in range(len(new)):
            if reused := self.best(new, a, taken):
                taken[a] = reused
        pieces = [taken.get(a, [number]) for a, number in enumerate(new)]
        path = [vertex for piece in pieces for vertex in piece]
        fresh = [a for a in range(len(new)) if a not in taken]
        others = [
            (v, self.aligned(self.paths[owner], place))
            for v, (owner, place) in self.made_for.items()
        ]
        others += [(new[b], self.aligned(new, b)) for b in fresh]
        for a in fresh:
            mine = self.aligned(new, a)
            for v, theirs in others:
                if v in new and new.index(v) - a in (0, 1):  # itself, and driven
                    continue
                steps = set(mine) & set(theirs)
                out = min(self.re[mine[s], theirs[s]] for s in steps)
                back = min(self.re[theirs[s], mine[s]] for s in steps)
                if out > self.settings.p_edge:
                    self.connect(new[a], v, out)
                if back > self.settings.p_edge:
                    self.connect(v, new[a], back)
        for a in fresh:
            self.made_for[new[a]] = (len(self.paths), path.index(new[a]))
        self.paths.append(path)
        for source, target in pairwise(path):
            self.connect(source, target, self.re[source, target], driven=1)
        return [piece[-1] for piece in pieces]


@st.composite
def cities(draw):
    """RE among anchors of a few trajectories; some pairs of them run side by side for a while."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    lengths = draw(st.lists(st.integers(2, 6), min_size=1, max_size=4))
    trajectories = np.split(np.arange(sum(lengths)), np.cumsum(lengths)[:-1])
    share = draw(st.sampled_from([0.1, 0.4, 0.8]))
    good = rng.random((sum(lengths),) * 2) < share
    for one in trajectories:
        for other in trajectories:
            for step in rng.integers(-4, 5, size=2):
                for a, b in ((a, a + step) for a in range(len(one))):
                    if 0 <= b < len(other):
                        good[one[a], other[b]] = True
    table = np.where(good, rng.uniform(0.9, 1.0, good.shape), rng.uniform(0.0, 0.8, good.shape))
    return table, [trajectory.tolist() for trajectory in trajectories]


def check_by_the_book(drawn, settings):
    """Both make the same map; returns whether anything was reused."""
    table, trajectories = drawn
    topomap, book = TopoMap(Table(table), settings), ByTheBook(table, settings)
    number = {}  # of the vertex that an anchor became
    for trajectory in trajectories:
        added = add_trajectory(topomap, anchors(trajectory))
        wanted = book.add(trajectory)
        fresh = [
            anchor for anchor, vertex in zip(trajectory, wanted, strict=True) if anchor == vertex
        ]
        number |= zip(fresh, added.path[~added.reused].tolist(), strict=True)
        assert added.path.tolist() == [number[anchor] for anchor in wanted]
        assert added.reused.tolist() == [anchor not in fresh for anchor in trajectory]
        assert not len(added.outdated)
    found = edges_of(topomap)
    wanted = {(number[a], number[b]): p for (a, b), p in book.edges.items()}
    assert found == wanted
    assert all(a != b for a, b in found)
    assert topomap.paths == [[number[anchor] for anchor in path] for path in book.paths]
    assert topomap.vertices.observations[topomap.alive].odometry[:, 0].tolist() == list(number)


@settings(max_examples=60)
@given(
    cities(), st.sampled_from([0.85, 0.9, 0.95]), st.sampled_from([0.9, 0.95, 1.0]),
    st.integers(0, 3), st.sampled_from([0.5, 0.9, 1.0]),
)  # fmt: skip
@pytest.mark.full
def test_a_map_grows_by_the_book(drawn, p_edge, p_reuse, sequence, p_between):
    check_by_the_book(
        drawn, MapSettings(p_edge, p_reuse, sequence, p_outdated=0.0, p_between=p_between)
    )


class TableAlike(Table):
    """A table whose anchors look like anything."""

    def embed(self, observations):
        angles = 2.4 * observations.odometry[:, 0]
        return np.column_stack([np.cos(angles), np.sin(angles)]).astype(np.float32)[:, None]


@settings(max_examples=40)
@given(cities(), st.sampled_from([0.85, 0.93]), st.integers(0, 3), st.integers(1, 4))
def test_of_some_pairs_alone_some_edges_are_found_and_no_others(drawn, p_edge, sequence, count):
    table, trajectories = drawn
    found = []
    for reachability in (Table(table), TableAlike(table)):
        topomap = TopoMap(reachability, MapSettings(p_edge, 1.0, sequence, count, p_outdated=0.0))
        for trajectory in trajectories:
            add_trajectory(topomap, anchors(trajectory))
        # No pair twice, but once more along the path.
        driven = Counter(pair for trajectory in trajectories for pair in pairwise(trajectory))
        assert max((Counter(reachability.queried) - driven).values(), default=1) == 1
        assert all(a != b for a, b in reachability.queried)
        found.append(edges_of(topomap))
    every, some = found
    assert some.items() <= every.items()


def crossing():
    """RE of two trajectories of five, the second through the first's middle, and of a third.

    The third repeats the second beside it, and cannot reach the first but in its middle.
    """
    table = np.full((15, 15), NO)
    for a, b in pairwise(range(5)):
        for trajectory in (0, 5, 10):
            table[trajectory + a, trajectory + b] = YES
    table[6, 2] = table[2, 8] = YES  # vertex 2 will do for anchor 7
    for a in range(5):
        table[10 + a, 5 + a] = YES - 0.0001 * a
    table[12, 2] = YES
    return table


def test_an_aligned_sequence_stays_on_its_trajectory_past_a_reused_vertex():
    topomap = TopoMap(Table(crossing()), MapSettings(sequence=2, p_outdated=0.0))
    add_trajectory(topomap, anchors(range(5)))
    second = add_trajectory(topomap, anchors(range(5, 10))).path
    assert second[2] == 2
    third = add_trajectory(topomap, anchors(range(10, 15))).path
    assert topomap.graph.has_edge(third[1], second[1])
    assert topomap.graph.has_edge(third[3], second[3])


def test_an_aligned_sequence_passes_a_reused_vertex_by_one_step():
    topomap = TopoMap(Table(crossing()), MapSettings(sequence=1, p_outdated=0.0))
    add_trajectory(topomap, anchors(range(5)))
    second = add_trajectory(topomap, anchors(range(5, 10))).path
    third = add_trajectory(topomap, anchors(range(10, 15))).path
    assert topomap.graph.has_edge(third[1], second[1])
    assert topomap.graph.has_edge(third[3], second[3])


# Rules one by one.


def test_the_first_trajectory_is_a_chain_of_vertices_and_what_it_closes():
    table = np.full((5, 5), NO)
    for a, b in pairwise(range(5)):
        table[a, b] = 0.7  # driven, whatever RE says
    table[4, 0] = table[0, 4] = YES
    topomap = TopoMap(Table(table), MapSettings(sequence=0))
    added = add_trajectory(topomap, anchors(range(5)))
    assert added.path.tolist() == [0, 1, 2, 3, 4]
    assert not added.reused.any()
    wanted = {(a, a + 1): (0.7, 1) for a in range(4)}
    assert edges_of(topomap) == wanted | {(4, 0): (YES, 0), (0, 4): (YES, 0)}
    for _, _, edge in topomap.graph.edges(data=True):
        assert edge["weight"] == pytest.approx(-np.log(edge["probability"]))


def test_no_vertex_is_joined_to_itself():
    topomap = TopoMap(Table(np.full((6, 6), YES)))
    add_trajectory(topomap, anchors(range(6)))
    assert all(a != b for a, b in topomap.graph.edges)


def test_an_anchor_that_is_reached_backwards_from_the_next_is_joined_to_it():
    table = np.full((4, 4), NO)
    for a, b in pairwise(range(4)):
        table[a, b] = table[b, a] = YES
    topomap = TopoMap(Table(table), MapSettings(sequence=2))
    add_trajectory(topomap, anchors(range(4)))
    assert all(topomap.graph.has_edge(b, a) for a, b in pairwise(range(4)))


def test_all_anchors_but_the_next_are_queried_once_each():
    topomap = TopoMap(Table(np.full((5, 5), NO)))
    add_trajectory(topomap, anchors(range(5)))
    queried = topomap.vertices.reachability.queried
    wanted = [(a, b) for a in range(5) for b in range(5) if a != b]  # a, a + 1 along the path
    assert sorted(queried) == wanted


def beside(known, *good):
    """RE of anchors of which `known` are a map's and driven, and some other pairs are `good`."""
    table = np.full((12, 12), NO)
    for a, b in [*pairwise(range(known)), *good]:
        table[a, b] = YES
    topomap = TopoMap(Table(table), MapSettings(p_edge=1.0, sequence=0))
    add_trajectory(topomap, anchors(range(known)))
    return topomap


def test_the_first_and_the_last_anchor_are_reused_too():
    # From 6 to 1 and on to 7; from 7 to 3 and on to 8; from 3 to 4 and on to 8.
    topomap = beside(5, (6, 1), (1, 7), (1, 3), (3, 8), (4, 8))
    added = add_trajectory(topomap, anchors([6, 7, 8]))
    assert added.path.tolist() == [1, 3, 4]
    assert added.reused.all()
    assert topomap.paths == [[0, 1, 2, 3, 4], [1, 3, 4]]


@pytest.mark.parametrize(
    ("good", "path"),
    [
        # The first anchor comes before itself, and the last after itself.
        (((6, 1), (1, 7)), [1, -1, -1]),
        (((6, 1),), [-1, -1, -1]),
        (((1, 7),), [-1, -1, -1]),
        (((7, 1), (1, 8)), [-1, -1, 1]),
        (((7, 1),), [-1, -1, -1]),
        (((1, 8),), [-1, -1, -1]),
    ],
)
def test_one_end_alone_is_reused_if_it_is_met_in_both_directions(good, path):
    added = add_trajectory(beside(5, *good), anchors([6, 7, 8]))
    assert np.where(added.reused, added.path, -1).tolist() == path


def test_what_was_reused_before_counts_and_not_what_the_anchor_could_reach():
    # Anchor 6 is vertex 1 by now, from which 2 is reached; anchor 6 itself reached 3 only.
    topomap = beside(5, (6, 1), (1, 7), (2, 8), (6, 3), (3, 8))
    added = add_trajectory(topomap, anchors([6, 7, 8, 9]))
    assert added.path[:2].tolist() == [1, 2]


def test_one_good_pair_in_a_wrong_place_makes_no_edge():
    table = np.full((10, 10), NO)
    table[1, 6] = YES
    for sequence, joined in ((0, True), (2, False)):
        topomap = TopoMap(Table(table), MapSettings(sequence=sequence))
        add_trajectory(topomap, anchors(range(5)))
        topomap.settings = MapSettings(sequence=sequence)
        add_trajectory(topomap, anchors(range(5, 10)))
        assert topomap.graph.has_edge(1, 6) == joined
        assert not topomap.graph.has_edge(6, 1)


def test_an_edge_that_is_driven_again_is_counted_and_never_gets_less_probable():
    topomap = table_map(np.eye(3), 3)
    topomap.connect(0, 1, 0.5)
    topomap.connect(0, 1, 0.9, driven=1)
    topomap.connect(0, 1, 0.2, driven=1)
    assert edges_of(topomap) == {(0, 1): (0.9, 2)}
    assert topomap.graph.edges[0, 1]["weight"] == pytest.approx(-np.log(0.9))


def test_a_trajectory_along_the_same_path_makes_no_new_vertices():
    poses = street((0, 0), (9, 0))
    topomap = TopoMap(Streets())
    add_trajectory(topomap, anchors_at(poses))
    before = len(topomap)
    added = add_trajectory(topomap, anchors_at(street((0, 0), (9, 0), aside=0.1), 100.0))
    assert added.reused.all()
    assert len(topomap) == before
    kept = added.path[added.reused]
    assert (np.diff(kept) > 0).all()
    driven = [edge["driven"] for _, _, edge in topomap.graph.edges(data=True)]
    assert max(driven) == 2
    assert topomap.paths[1] == added.path.tolist()


def test_a_trajectory_in_the_other_direction_reuses_nothing():
    topomap = TopoMap(Streets())
    add_trajectory(topomap, anchors_at(street((0, 0), (9, 0))))
    added = add_trajectory(topomap, anchors_at(street((9, 0), (0, 0)), 100.0))
    assert not added.reused.any()
    assert len(topomap) == 20


def test_without_reuse_vertices_are_made_beside_those_that_are_there():
    topomap = TopoMap(Streets(), MapSettings(p_reuse=1.0))
    for begin in (0.0, 100.0):
        added = add_trajectory(topomap, anchors_at(street((0, 0), (9, 0)), begin))
        assert not added.reused.any()
    assert len(topomap) == 20
    # Joined in both directions between the trajectories.
    assert topomap.graph.has_edge(4, 15)
    assert topomap.graph.has_edge(14, 5)
    assert topomap.vertices.timestamps.tolist() == [*range(10), *range(100, 110)]


def test_a_path_back_to_the_beginning_is_joined_to_it():
    poses = street((0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (3, 0))
    topomap = TopoMap(Streets(), MapSettings(sequence=1))
    path = add_trajectory(topomap, anchors_at(poses)).path
    # The second time round it comes by the same places as in the beginning.
    again = len(poses) - 3
    assert topomap.graph.has_edge(path[again], path[2])


def test_queries_are_counted():
    reachability = Streets()
    topomap = TopoMap(reachability)
    for aside in (0.0, 0.2, 5.0):
        before = reachability.queries
        added = add_trajectory(topomap, anchors_at(street((0, 0), (9, 0), aside=aside)))
        assert added.queries == reachability.queries - before > 0
    assert topomap.vertices.queries == reachability.queries


def test_a_trajectory_that_is_known_altogether_makes_no_vertices():
    table = np.full((6, 6), YES)
    topomap = TopoMap(Table(table), MapSettings(p_edge=1.0, sequence=0))
    add_trajectory(topomap, anchors([0, 1, 2]))
    added = add_trajectory(topomap, anchors([3, 4]))
    assert added.reused.all()
    assert len(topomap) == len(topomap.vertices) == 3
    assert (np.diff(added.path) > 0).all()
    add_trajectory(topomap, anchors([4, 5, 3]))
    assert len(topomap.paths) == 3


# Retrieval.


def city():
    """Trajectories along the streets of a small city, some of them twice."""
    corners = [(0, 0), (8, 0), (8, 8), (0, 8)]
    trajectories = [street(*corners, (0, 0)), street((0, 4), (8, 4)), street((4, 8), (4, 0))]
    trajectories += [street((0, 0), (8, 0), (8, 4), aside=0.15), street(*corners[::-1], aside=-0.1)]
    trajectories += [street((8, 4), (0, 4)), street((0, 4), (4, 4), (4, 0), aside=0.05)]
    return [anchors_at(poses, 100.0 * number) for number, poses in enumerate(trajectories)]


def grown(reachability, **settings):
    topomap = TopoMap(reachability, MapSettings(**settings))
    added = [add_trajectory(topomap, trajectory) for trajectory in city()]
    return topomap, added


@pytest.fixture(scope="module")
def cities_twice():
    """The same map by querying every pair and by querying what looks alike."""
    return grown(Streets()), grown(StreetsAlike(), candidates=8)


def test_retrieval_makes_the_same_map_with_fewer_queries(cities_twice):
    (every, added), (some, also) = cities_twice
    assert edges_of(every) == edges_of(some)
    assert every.paths == some.paths
    for one, other in zip(added, also, strict=True):
        assert one.path.tolist() == other.path.tolist()
        assert one.reused.tolist() == other.reused.tolist()
    assert sum(a.reused.sum() for a in added) > 15
    assert some.vertices.queries < 0.5 * every.vertices.queries
    assert some.vertices.reachability.queries == some.vertices.queries


def test_retrieval_queries_less_and_less_of_all_pairs(cities_twice):
    (_, added), (_, also) = cities_twice
    shares = [b.queries / a.queries for a, b in zip(added, also, strict=True)]
    assert max(shares[4:]) < 0.5


def test_where_observations_are_shown_no_embedding_of_targets_is_needed(cities_twice):
    class Seen(Streets):
        embed = StreetsAlike.embed
        _directions = StreetsAlike._directions
        size = StreetsAlike.size

    (every, _), _ = cities_twice
    topomap, _ = grown(Seen(), candidates=8)
    assert not hasattr(topomap.vertices.reachability, "embed_targets")
    assert edges_of(topomap) == edges_of(every)
    assert topomap.vertices.queries < every.vertices.queries


def test_the_nearest_look_alike(cities_twice):
    _, (topomap, _) = cities_twice
    poses = topomap.vertices.observations[topomap.alive].odometry
    here = sensed([[3.9, 0.1, 0.0], [0.0, 4.0, 0.0]])
    near = topomap.nearby(here, 5)
    assert near.shape == (2, 5)
    for row, numbers in zip(here.odometry, near, strict=True):
        off = np.abs(poses - row)
        alike = np.cos(off[:, :2] / StreetsAlike.size).sum(axis=1) + np.cos(off[:, 2])
        assert sorted(alike[numbers]) == pytest.approx(sorted(alike)[-5:], abs=1e-5)
    goals = here.odometry[:, None]
    around = topomap.around(here, topomap.vertices.reachability.prepare(goals), 5)
    assert np.sort(around).tolist() == np.sort(near).tolist()
    assert topomap.nearby(here, 1_000).tolist() == [topomap.alive.tolist()] * 2
    assert topomap.around(here, None, 1_000).tolist() == [topomap.alive.tolist()] * 2


# What looks different by now.

PATH = street((0, 0), (7, 0))


def again(reachability, hidden=(), aside=0.1, **settings):
    """A path, driven and then driven again, when some poses cannot be seen again."""
    topomap = TopoMap(reachability, MapSettings(**settings))
    add_trajectory(topomap, anchors_at(PATH))
    reachability.hidden = [PATH[number] for number in hidden]
    return topomap, add_trajectory(topomap, anchors_at(street((0, 0), (7, 0), aside=aside), 50.0))


@pytest.mark.parametrize("kind", [Streets, StreetsAlike])
@pytest.mark.parametrize("hidden", [[3], [2, 5]])
def test_a_vertex_that_looks_different_by_now_is_removed(kind, hidden):
    topomap, added = again(kind(), hidden, candidates=3)
    assert added.outdated.tolist() == hidden
    assert not set(hidden) & set(topomap.graph)
    assert set(hidden) & set(added.path.tolist()) == set()
    for number, path in enumerate(topomap.paths):
        assert not set(hidden) & set(path)
        for place, vertex in enumerate(path):
            if topomap.trajectory[vertex] == number:
                assert topomap.place[vertex] == place


@pytest.mark.parametrize("kind", [Streets, StreetsAlike])
@pytest.mark.parametrize("p_reuse", [0.99, 1.0])
def test_nothing_is_removed_where_nothing_changes(kind, p_reuse):
    reachability = kind()
    topomap = TopoMap(reachability, MapSettings(p_reuse=p_reuse, candidates=3))
    for trajectory in city():
        assert add_trajectory(topomap, trajectory).outdated.tolist() == []
    assert len(topomap) == len(topomap.vertices)


def test_what_is_doubtful_is_kept():
    # RE of what is hidden is 0.01: not below this.
    _, added = again(Streets(), [3], p_outdated=0.005)
    assert added.outdated.tolist() == []


def test_what_another_path_does_not_pass_is_kept():
    topomap = TopoMap(Streets())
    add_trajectory(topomap, anchors_at(PATH))
    topomap.vertices.reachability.hidden = [PATH[3]]
    # Round it, and across it.
    for poses in (street((0, 0), (2, 0), (2, 5), (4, 5), (4, 0), (7, 0)), street((3, -4), (3, 4))):
        assert add_trajectory(topomap, anchors_at(poses, 50.0)).outdated.tolist() == []


def test_what_was_removed_is_never_met_again():
    for kind in (Streets, StreetsAlike):
        topomap, _ = again(kind(), [3], candidates=3)
        topomap.vertices.reachability.hidden = []  # it could be seen again, had it not been removed
        here = sensed(PATH[3:4])
        for count in (4, 1_000):
            assert 3 not in topomap.nearby(here, count)
            prepared = topomap.vertices.reachability.prepare(PATH[3:4, None])
            assert 3 not in topomap.around(here, prepared, count)
        for aside in (0.0, 0.05, 3.0):
            added = add_trajectory(topomap, anchors_at(street((0, 0), (7, 0), aside=aside), 99.0))
            assert 3 not in added.path
            assert 3 not in added.outdated
        assert 3 not in topomap.graph
        plan = DijkstraPlanner().plan(
            sensed([[0, 0.05, 0.0]]), Goals(sensed(PATH[6:7]), PATH[6:7, None]), topomap
        )
        assert not plan.refusal
        assert len(plan.vertices) >= 3
        assert 3 not in plan.vertices


def test_the_others_keep_their_numbers():
    topomap = table_map(np.eye(6), 6, paths=[[0, 1, 2], [3, 4, 5]])
    topomap.paths[1] = [3, 1, 4, 5]
    topomap.place[4:] += 1
    topomap.connect(0, 1, 0.9)
    topomap.connect(4, 5, 0.9)
    topomap.remove([1, np.int64(3)])
    assert topomap.alive.tolist() == [0, 2, 4, 5]
    assert len(topomap) == 4
    assert len(topomap.vertices) == 6
    assert topomap.paths == [[0, 2], [4, 5]]
    assert topomap.trajectory[topomap.alive].tolist() == [0, 0, 1, 1]
    assert topomap.place[topomap.alive].tolist() == [0, 1, 0, 1]
    assert list(topomap.graph.edges) == [(4, 5)]
    before = topomap.paths
    topomap.remove([])
    assert topomap.paths is before


# Vertices and anchors.


def test_pairs_are_queried_source_by_source_and_returned_in_order():
    rng = np.random.default_rng(0)
    reachability = Table(rng.random((40, 40)))
    vertices = Vertices(reachability)
    for numbers in (np.arange(25), np.arange(25, 40)):
        added = vertices.append(numbered(numbers), numbers[:, None], numbers * 1.0, numbers)
        assert added.tolist() == numbers.tolist()
    sources, targets = rng.integers(40, size=(2, 5000))
    assert (vertices.between(sources, targets) == reachability.table[sources, targets]).all()
    queried = np.array(reachability.queried)
    assert len(queried) == vertices.queries == 5000
    assert (np.diff(queried[:, 0]) >= 0).all()
    rows = rng.integers(3, size=20)
    seen = numbered([7, 5, 9])
    into = vertices.into(seen, rows, targets[:20])
    assert (into == reachability.table[np.array([7, 5, 9])[rows], targets[:20]]).all()
    onward = vertices.onward(targets[:20], np.array([7, 5, 9]), rows)
    assert (onward == reachability.table[targets[:20], np.array([7, 5, 9])[rows]]).all()
    assert vertices.queries == 5040
    assert vertices.between([], []).shape == (0,)


def test_prepared_targets_are_handed_out_by_index():
    vertices = Vertices(Streets())
    for poses in (WEST, SOUTH):
        prepared = vertices.prepare(poses[:, None])
        vertices.append(sensed(poses), poses[:, None], np.arange(len(poses)), prepared)
    poses, index = np.concatenate([WEST, SOUTH]), [7, 0, 3, 3]
    assert (vertices.prepared_targets(index) == poses[index]).all()
    assert (vertices.prepared_targets(np.arange(len(vertices))) == poses).all()


class Counting(StreetsAlike):
    """Counts the targets that it prepares."""

    def __init__(self):
        super().__init__()
        self.count = 0

    def prepare(self, contexts):
        self.count += len(contexts)
        return super().prepare(contexts)


def test_targets_prepared_for_sparsifying_are_not_prepared_again():
    maps = TopoMap(Counting()), TopoMap(Counting())
    for topomap, kept in zip(maps, (True, False), strict=True):
        reachability, frames = topomap.vertices.reachability, 0
        for poses in (WEST, SOUTH, WEST):
            found = anchors_of(reachability, sensed(poses), poses, 1, 0.95, np.arange(len(poses)))
            assert found.prepared_by is reachability
            assert (found.prepared == Streets().prepare(found.contexts)).all()
            frames += len(poses)
            add_trajectory(topomap, found if kept else replace(found, prepared=None))
        assert (reachability.count == frames) == kept
    one, other = maps
    assert edges_of(one) == edges_of(other)
    assert one.paths == other.paths
    every = np.arange(len(one.vertices))
    assert (one.vertices.prepared_targets(every) == other.vertices.prepared_targets(every)).all()


def test_targets_that_another_estimator_prepared_are_prepared_again():
    times = np.arange(len(WEST))
    found = anchors_of(Counting(), sensed(WEST), WEST, 1, 0.95, times)
    topomap = TopoMap(Counting())
    add_trajectory(topomap, found)
    assert topomap.vertices.reachability.count == len(found)


@pytest.mark.parametrize("prepared", [np.zeros((2, 3)), [0] * 7, 5])
def test_prepared_targets_are_checked(prepared):
    reachability = Counting()
    found = anchors_of(reachability, sensed(WEST), WEST, 1, 0.95, np.arange(len(WEST)))
    with pytest.raises(InputError, match="reachability: prepared"):
        add_trajectory(TopoMap(reachability), replace(found, prepared=prepared))


def test_the_fakes_fit_the_seam():
    assert isinstance(Streets(), Reachability)
    assert isinstance(Table(np.eye(2)), Reachability)


def test_anchors_of_a_trajectory_are_what_sparsification_keeps():
    count = 30
    ahead = np.arange(count) - np.arange(count)[:, None]
    reachability = Table(np.where((ahead >= 0) & (ahead <= 9), YES, NO))
    pictures = np.arange(count)
    found = anchors_of(reachability, numbered(pictures), pictures, 1, 0.9, pictures * 0.1)
    assert found.observations.odometry[:, 0].tolist() == [0, 9, 18, 27, 29]
    assert found.contexts.tolist() == [
        [0, 0, 3],
        [6, 9, 12],
        [15, 18, 21],
        [24, 27, 29],
        [26, 29, 29],
    ]
    assert found.timestamps == pytest.approx([0.0, 0.9, 1.8, 2.7, 2.9])
    seen, contexts, times = found.subset(np.array([1, 3]))
    assert seen.odometry[:, 0].tolist() == contexts[:, 1].tolist() == [9, 27]
    assert times == pytest.approx([0.9, 2.7])


@pytest.mark.parametrize(
    ("count", "contexts", "times"), [(1, 1, 1), (3, 2, 3), (3, 3, 4), (0, 0, 0)]
)
def test_anchors_come_with_all_that_is_needed(count, contexts, times):
    words = f"{count} observations, {contexts} contexts, {times} timestamps"
    with pytest.raises(InputError, match=f"anchors: {words}; give as many of each, two"):
        Anchors(numbered(range(count)), np.zeros((contexts, 1)), np.zeros(times))


# What can go wrong.


class Wrong(Streets):
    """Returns or prepares something else."""

    def __init__(self, returned=None, prepared=None):
        super().__init__()
        self.returned, self.prepared = returned, prepared

    def prepare(self, contexts):
        found = super().prepare(contexts)
        return found if self.prepared is None else self.prepared(found)

    def probability(self, observations, prepared):
        found = super().probability(observations, prepared)
        return found if self.returned is None else self.returned(found)


@pytest.mark.parametrize(
    ("reachability", "words"),
    [
        (Wrong(returned=lambda p: p + 1), "reachability: .* probabilities from 0 to 1"),
        (Wrong(returned=lambda p: p[:-1]), "reachability: shape"),
        (Wrong(returned=lambda p: p * np.nan), "reachability: nan"),
        (
            Wrong(prepared=lambda x: np.concatenate([x, x])),
            "reachability: prepared 16 of 8 targets; give all",
        ),
        (
            Wrong(prepared=lambda x: x[1:]),
            "reachability: prepared 7 of 8 targets; give all",
        ),
        (
            Wrong(prepared=lambda x: {"poses": x}),
            "reachability: prepared 1 of 8 targets; give all",
        ),
        *(
            (Wrong(prepared=make), f"reachability: prepared a {name} of 8 targets, .*; give an")
            for make, name in [
                (list, "list"),
                (iter, "[a-z_]*iterator"),
                (lambda x: x[0, 0], "float64"),
                (lambda x: ..., "ellipsis"),
            ]
        ),
    ],
)
def test_an_estimator_that_does_not_fit_is_named(reachability, words):
    topomap = TopoMap(reachability)
    with pytest.raises(InputError, match=words):
        _ = [add_trajectory(topomap, anchors_at(PATH, begin)) for begin in (0.0, 50.0)]


def test_a_vertex_is_reused_only_where_the_anchors_around_match_as_well():
    table = np.full((10, 10), 0.01)
    for first in (0, 5):
        for number in range(first, first + 4):
            table[number, number + 1] = 0.99
    # Anchor 7 looks like vertex 2; those around it look like nothing on the map.
    table[6, 2] = table[2, 8] = table[7, 2] = 0.99
    alike = table.copy()
    alike[6, 1] = alike[8, 3] = 0.99
    for reach, reach_of_re, reused in ((0, table, True), (1, table, False), (1, alike, True)):
        topomap = TopoMap(Table(reach_of_re), MapSettings(reuse_sequence=reach))
        add_trajectory(topomap, anchors(range(5)))
        added = add_trajectory(topomap, anchors(range(5, 10)))
        assert bool(added.reused[2]) == reused
        assert (added.path[2] == 2) == reused


def test_a_map_of_indices_needs_no_observations():
    class Table:
        def prepare(self, targets):
            return targets

        def probability(self, observations, prepared):
            return np.where(np.abs(observations - prepared) < 2, 0.999, 0.1)

    topomap, own = TopoMap(Table()), np.arange(4)
    add_trajectory(topomap, Anchors(own, own, own * 1.0))
    assert list(topomap.graph.edges)
