"""The rules by which maps grow: shelves, retrieval, comparison, linking."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation
from tutorial_lib.topology.mapping.edge_rules import (
    MapSettings,
    ahead_of,
    outdated,
    reusable,
    weight,
)
from tutorial_lib.topology.mapping.edge_search import (
    along_trajectories,
    search_edges,
    weakest_aligned,
)
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch, joined
from tutorial_lib.topology.mapping.retrieval import Index, likeness, most_alike

seeds = st.integers(0, 2**32 - 1)


def observations(numbers, depth=None):
    """Observations of those numbers, each different in everything."""
    n = np.asarray(numbers, dtype=float)
    image = (n[:, None, None, None] + np.zeros((1, 2, 1, 3))).astype(np.uint8)
    odometry = np.column_stack([n, n + 1, n + 2])
    return Observation(image, depth, np.tile(n[:, None], (1, 4)), odometry, n + 3, n + 4)


# Shelves.


@given(st.lists(st.integers(0, 6), min_size=1, max_size=20), st.data())
def test_a_growing_batch_selects_as_if_all_batches_were_one(lengths, data):
    batch, bounds = GrowingBatch(), np.cumsum([0, *lengths])
    for first, last in pairwise(bounds):
        batch.append(np.arange(first, last)[:, None] * [1, 10])
    assert len(batch) == bounds[-1]
    if len(batch):
        numbers = data.draw(st.lists(st.integers(0, len(batch) - 1), min_size=1, max_size=12))
        assert (batch[numbers] == np.array(numbers)[:, None] * [1, 10]).all()


def test_a_growing_batch_selects_between_batches_too():
    # What was selected before a batch came is the same after it.
    batch, numbers = GrowingBatch(), np.array([4, 0, 2, 2])
    batch.append(np.arange(5))
    before = batch[numbers]
    for _ in range(9):
        batch.append(np.arange(100, 103))
        assert (batch[numbers] == before).all()
    assert batch[[4, 31]].tolist() == [4, 102]


class Counted(list):
    """A batch that counts how many things were ever copied to merge batches."""

    copied = 0

    @classmethod
    def joined(cls, parts):
        cls.copied += sum(len(part) for part in parts)
        return cls(x for part in parts for x in part)


def test_a_long_growing_batch_is_seldom_copied():
    batch, Counted.copied = GrowingBatch(), 0
    for number in range(1024):
        batch.append(Counted([number]))
    # To copy all each time would be half a million.
    assert Counted.copied <= 1024 * 11


def test_observations_are_put_into_a_growing_batch():
    batch = GrowingBatch()
    for numbers in ([0, 1, 2], [3], [4, 5], [6, 7, 8, 9]):
        batch.append(observations(numbers))
    some = batch[[9, 0, 5, 5, 3]]
    wanted = observations([9, 0, 5, 5, 3])
    for name in ("image", "laser", "odometry", "speed", "steering"):
        assert (getattr(some, name) == getattr(wanted, name)).all()
    assert some.depth is None


def test_observations_joined_keep_depth_only_where_all_have_it():
    near, far = np.full((2, 4), 1.0), np.full((1, 4), 9.0)
    both = Observation.joined([observations([0, 1], near), observations([2], far)])
    assert both.depth.tolist() == [[1.0] * 4, [1.0] * 4, [9.0] * 4]
    assert both.odometry[:, 0].tolist() == [0, 1, 2]
    assert both.speed.tolist() == [3, 4, 5]
    assert both.steering.tolist() == [4, 5, 6]
    assert both.image.dtype == np.uint8
    assert Observation.joined([observations([0]), observations([2], far)]).depth is None


def test_what_cannot_be_joined_is_named():
    with pytest.raises(InputError, match="dict has no method `joined`; let `prepare` return"):
        joined([{"a": 1}, {"a": 2}])
    batch = GrowingBatch()
    batch.append([1, 2])
    with pytest.raises(InputError, match="map: list has no method"):
        batch.append([3, 4])


# Retrieval.


def by_the_book(seen, shown):
    """Likeness, image by image."""
    found = np.empty((len(seen), len(shown)))
    for n, mine in enumerate(seen):
        for m, images in enumerate(shown):
            alike = []
            for image in images:
                cosines = mine @ image.T
                alike.append(cosines.max(axis=1).mean() + cosines.max(axis=0).mean())
            found[n, m] = max(alike)
    return found


def directions(rng, *shape):
    found = rng.normal(size=shape).astype(np.float32)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


@settings(max_examples=40)
@given(
    st.integers(1, 20), st.integers(1, 6), st.integers(1, 3), st.integers(1, 4), st.integers(1, 5),
    seeds,
)  # fmt: skip
def test_likeness_is_late_interaction(count, targets, images, parts, size, seed):
    rng = np.random.default_rng(seed)
    seen = directions(rng, count, parts, size)
    shown = directions(rng, targets, images, parts, size)
    alike = likeness(seen, shown)
    assert alike == pytest.approx(by_the_book(seen, shown), abs=1e-5)
    assert (np.abs(alike) <= 2 + 1e-5).all()


def test_what_looks_the_same_is_most_alike_wherever_its_parts_are():
    seen = directions(np.random.default_rng(0), 5, 8, 6)
    turned = np.roll(seen, 3, axis=1)[:, None]
    alike = likeness(seen, turned)
    assert np.diag(alike) == pytest.approx(2.0, abs=1e-5)
    assert (alike.argmax(axis=1) == np.arange(5)).all()


def test_a_small_part_of_an_image_is_not_the_image():
    # Each part of one has its like in the other, but not the other way round.
    one = np.tile([1.0, 0.0, 0.0], (4, 1))
    other = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]])
    assert likeness([one], [[other]])[0, 0] == pytest.approx(1.25)
    assert likeness([other], [[one]])[0, 0] == pytest.approx(1.25)


@pytest.mark.parametrize(
    ("seen", "shown", "words"),
    [
        (np.ones((2, 3)), np.ones((2, 1, 1, 3)), r"\(2, 3\); give finite \(N, R, D\)"),
        (np.ones((2, 1, 3)), np.ones((2, 1, 3)), r"give finite \(N, P, R, D\)"),
        (np.full((2, 1, 3), np.nan), np.ones((2, 1, 1, 3)), "give finite"),
        (np.ones((2, 1, 3)), np.full((2, 1, 1, 3), np.inf), "give finite"),
        (np.ones((2, 1, 3)), np.ones((2, 1, 1, 4)), "3 and shown 4 dimensions.* same network"),
    ],
)
def test_embeddings_that_do_not_fit_are_named(seen, shown, words):
    with pytest.raises(InputError, match=f"embeddings: .*{words}"):
        likeness(seen, shown)


@given(st.integers(1, 6), st.integers(1, 12), st.integers(1, 15), seeds)
def test_the_most_alike_are_found(rows, columns, count, seed):
    alike = np.random.default_rng(seed).permutation(rows * columns).reshape(rows, columns)
    found = most_alike(alike, count)
    assert found.shape == (rows, min(count, columns))
    for row, numbers in zip(alike, found, strict=True):
        best = np.argsort(row)[::-1][:count]
        assert sorted(numbers) == sorted(best)


def test_the_most_alike_are_found_in_lists_too():
    assert most_alike([[0.2, 0.9, 0.1], [0.3, 0.1, 0.2]], 1).tolist() == [[1], [0]]


def test_an_index_is_what_was_put_into_it():
    rng, index = np.random.default_rng(0), Index()
    batches = [(directions(rng, n, 2, 3), directions(rng, n, 2, 2, 3)) for n in (3, 1, 4)]
    for number, batch in enumerate(batches):
        index.append(*batch)
        assert (index.seen == np.concatenate([b[0] for b in batches[: number + 1]])).all()
        assert (index.shown == np.concatenate([b[1] for b in batches[: number + 1]])).all()
    with pytest.raises(InputError, match="give finite"):
        index.append(np.ones((2, 3)), batches[0][1])


# Comparison: trajectories are columns in a row, and the row below counts anchors.


def chains(lengths, reach=1):
    """The columns around each, for trajectories of those lengths end to end."""
    bounds = np.cumsum([0, *lengths])
    paths = [list(range(*ends)) for ends in pairwise(bounds.tolist())]
    owner = np.repeat(np.arange(len(lengths)), lengths)
    return along_trajectories(paths, owner, np.arange(bounds[-1]) - bounds[owner], reach)


def ends_of(lengths):
    """The column before and after each."""
    return chains(lengths)[:, [0, 2]].T


@st.composite
def comparisons(draw):
    """RE of a few anchors and trajectories, in which diagonals hold now and then."""
    lengths = draw(st.lists(st.integers(1, 5), min_size=1, max_size=3))
    rows, rng = draw(st.integers(1, 6)), np.random.default_rng(draw(seeds))
    table = rng.random((rows, sum(lengths))) ** draw(st.sampled_from([0.05, 0.3, 1.0]))
    return table, lengths, chains(lengths, draw(st.integers(1, 4)))


@given(st.lists(st.integers(0, 6), max_size=4), st.integers(0, 4), seeds)
def test_vertices_are_laid_out_along_the_trajectories_they_were_made_for(lengths, reach, seed):
    # Of each path, some vertices are its own and some are reused.
    rng, paths, made = np.random.default_rng(seed), [], []
    for number, length in enumerate(lengths):
        path = []
        for place in range(length):
            if made and rng.random() < 0.4:
                path.append(int(rng.integers(len(made))))
            else:
                path.append(len(made))
                made.append((number, place))
        paths.append(path)
    trajectory, place = np.array(made, dtype=int).reshape(-1, 2).T
    found = along_trajectories(paths, trajectory, place, reach)
    assert found.shape == (len(made), 2 * reach + 1)
    for v, (number, at) in enumerate(made):
        for step in range(-reach, reach + 1):
            exists = 0 <= at + step < len(paths[number])
            wanted = paths[number][at + step] if exists else -1
            assert found[v, reach + step] == wanted
    assert (found[:, reach] == np.arange(len(made))).all()


def walk(column, step, along):
    """The column `step` on along its trajectory, or None."""
    other = along[column, along.shape[1] // 2 + step]
    return None if other < 0 else int(other)


def aligned(table, along, row, column, reach):
    """Pairs around a pair, along both."""
    return [
        (row + step, other)
        for step in range(-reach, reach + 1)
        if 0 <= row + step < len(table) and (other := walk(column, step, along)) is not None
    ]


class Queries:
    """RE from a table, each pair once at most."""

    def __init__(self, table):
        self.table, self.pairs = table, set()

    def __call__(self, rows, columns):
        pairs = set(zip(rows.tolist(), columns.tolist(), strict=True))
        assert len(pairs) == len(rows)
        assert not pairs & self.pairs
        self.pairs |= pairs
        return self.table[rows, columns]


@given(comparisons(), st.data(), st.sampled_from([0.0, 0.3, 1.0]), seeds)
def test_the_weakest_of_aligned_pairs_counts(drawn, data, known, seed):
    table, _, along = drawn
    reach = data.draw(st.integers(0, along.shape[1] // 2))
    least = data.draw(st.sampled_from([0.2, 0.8]))
    probabilities = np.where(np.random.default_rng(seed).random(table.shape) < known, table, np.nan)
    before, ask = probabilities.copy(), Queries(table)
    found = weakest_aligned(ask, probabilities, along, reach, least)
    worth = set()
    for row, column in np.ndindex(table.shape):
        pairs = aligned(table, along, row, column, reach)
        most = min(table[pair] for pair in pairs)
        if np.isnan(before[row, column]):
            assert found[row, column] == 0.0
        elif most > least:
            assert found[row, column] == most
        else:
            assert most <= found[row, column] <= min(least, table[row, column])
        if before[row, column] > least:
            worth.update(pairs)
            if most > least:
                assert not np.isnan([probabilities[pair] for pair in pairs]).any()
    # What is missing around what is good enough is queried, and filled in; all else stays.
    assert {pair for pair in ask.pairs if not np.isnan(before[pair])} == set()
    assert ask.pairs <= worth
    wanted = before.copy()
    for pair in ask.pairs:
        wanted[pair] = table[pair]
    assert np.array_equal(probabilities, wanted, equal_nan=True)


def test_aligned_pairs_that_are_unknown_are_queried():
    probabilities, ask = np.full((3, 3), np.nan), Queries(np.full((3, 3), 0.8))
    probabilities[1, 1] = 0.9
    weakest = weakest_aligned(ask, probabilities, chains([3]), 1, 0.7)
    assert ask.pairs == {(0, 0), (2, 2)}
    assert probabilities[0, 0] == probabilities[2, 2] == weakest[1, 1] == 0.8
    # These were no pairs to begin with.
    assert weakest[0, 0] == weakest[2, 2] == 0.0
    assert np.isnan(probabilities).sum() == 6


def test_a_sequence_that_is_broken_already_is_not_queried():
    probabilities, ask = np.full((5, 5), np.nan), Queries(np.full((5, 5), 0.1))
    probabilities[2, 2] = 0.9
    assert weakest_aligned(ask, probabilities, chains([5], 2), 2, 0.7)[2, 2] == pytest.approx(0.1)
    assert len(ask.pairs) == 1
    assert max(abs(row - 2) for row, _ in ask.pairs) == 1
    probabilities = np.full((5, 5), 0.7)  # not more
    assert (weakest_aligned(None, probabilities, chains([5], 2), 0, 0.7) == 0.7).all()


@given(comparisons(), seeds)
def test_a_search_queries_what_is_beside_an_edge_and_nothing_else(drawn, seed):
    table, _, along = drawn
    rng = np.random.default_rng(seed)
    begin, worth = rng.random(table.shape) < 0.3, rng.random(table.shape) < 0.8
    ask = Queries(table)
    probabilities = search_edges(ask, begin.copy(), worth, along, 0.8)
    wanted, todo = set(), list(zip(*np.nonzero(begin), strict=True))
    while todo:
        row, column = todo.pop()
        if (row, column) in wanted or not worth[row, column]:
            continue
        wanted.add((row, column))
        if table[row, column] > 0.8:
            for step, across in ((1, 1), (-1, -1), (0, 1), (0, -1)):
                other = walk(column, across, along)
                if other is not None and 0 <= row + step < len(table):
                    todo.append((row + step, other))
    assert ask.pairs == {(int(row), int(column)) for row, column in wanted}
    known = ~np.isnan(probabilities)
    assert known.sum() == len(wanted)
    assert (probabilities[known] == table[known]).all()


def test_a_search_does_not_cross_the_end_of_a_trajectory():
    begin, worth = np.zeros((4, 4), dtype=bool), np.ones((4, 4), dtype=bool)
    begin[1, 1] = True
    probabilities = search_edges(
        lambda rows, columns: np.ones(len(rows)), begin, worth, chains([2, 2]), 0.5
    )
    assert np.isnan(probabilities[:, 2:]).all()
    assert not np.isnan(probabilities[:3, :2]).all()


def test_a_search_without_seeds_asks_nothing():
    pairs = np.zeros((2, 3), dtype=bool)
    assert np.isnan(search_edges(None, pairs, ~pairs, chains([3]), 0.5)).all()
    assert np.isnan(search_edges(None, ~pairs, pairs, chains([3]), 0.5)).all()


# Linking.

shares = hnp.arrays(float, 6, elements=st.floats(0, 1))


@given(shares, shares, hnp.arrays(bool, 6), st.floats(0, 1))
def test_of_what_is_good_enough_the_most_probable_is_reused(into, onward, allowed, p_reuse):
    found = reusable(into, onward, allowed, p_reuse)
    fit = [
        i for i in range(6) if allowed[i] and into[i] > p_reuse and onward[i] > p_reuse
    ]  # each with more, not both together
    if not fit:
        assert found == -1
    else:
        assert found in fit
        assert into[found] * onward[found] == max(into[i] * onward[i] for i in fit)


def test_exactly_p_reuse_is_not_enough():
    assert reusable([0.9], [1.0], [True], 0.9) == -1
    assert reusable([1.0], [0.9], [True], 0.9) == -1
    assert reusable([1.0], [1.0], [True], 1.0) == -1
    assert reusable([], [], [], 0.5) == -1


def test_a_trajectory_is_reused_forwards_only():
    trajectory, place = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 0, 1, 0])
    assert ahead_of(trajectory, place, []).all()
    assert ahead_of(trajectory, place, [1]).tolist() == [False, False, True, True, True, True]
    both = ahead_of(trajectory, place, [1, 3]).tolist()
    assert both == [False, False, True, False, True, True]
    # The one that is farther on counts, whichever came last.
    assert ahead_of(trajectory, place, [2, 0]).tolist() == [False] * 3 + [True] * 3


def gone_by_the_book(seen, unseen, before, after, reach):
    gone = set()
    for v in range(len(before)):
        if before[v] < 0 or after[v] < 0:
            continue
        for first in range(len(seen)):
            for last in range(first, min(first + reach + 1, len(seen))):
                met = seen[first][before[v]] and seen[last][after[v]]
                if met and all(unseen[a][v] for a in range(first, last + 1)):
                    gone.add(v)
    return sorted(gone)


@given(comparisons(), st.integers(0, 3))
def test_what_was_passed_and_not_seen_is_outdated(drawn, reach):
    table, lengths, _ = drawn
    before, after = ends_of(lengths)
    seen, unseen = table > 0.7, table < 0.4
    found = outdated(seen, unseen, before, after, reach).tolist()
    assert found == gone_by_the_book(seen, unseen, before, after, reach)


def test_outdated_takes_what_is_before_first():
    before, after = ends_of([3])
    forwards = np.array([[True, False, False], [False, False, True]])
    backwards = forwards[::-1]
    assert outdated(forwards, ~forwards, before, after, 2).tolist() == [1]
    assert outdated(backwards, ~backwards, before, after, 2).tolist() == []
    # The two that see what is around it may not be too far apart, nor one between them see it.
    apart = np.array([[True, False, False], [False] * 3, [False] * 3, [False, False, True]])
    assert outdated(apart, ~apart, before, after, 2).tolist() == []
    assert outdated(apart, ~apart, before, after, 3).tolist() == [1]
    apart[2, 1] = True
    assert outdated(apart, ~apart, before, after, 3).tolist() == []


@given(st.lists(st.floats(1e-9, 1.0), min_size=1, max_size=5))
def test_weights_add_up_to_the_product(probabilities):
    assert np.exp(-weight(probabilities).sum()) == pytest.approx(np.prod(probabilities))
    assert (weight(probabilities) >= 0).all()


def test_what_never_happens_has_a_finite_weight():
    assert 20 < weight(0.0) < np.inf
    assert weight(0.0) > weight(1e-9)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"p_edge": 1.1}, "p_edge: 1.1; give one real number from 0 to 1"),
        ({"p_edge": -0.1}, "p_edge: -0.1; give one real number"),
        ({"p_reuse": np.nan}, "p_reuse: nan; give one real number"),
        ({"p_outdated": 2}, "p_outdated: 2.0; give one real number"),
        ({"sequence": -1}, "sequence: -1; give one whole number from 0 on"),
        ({"sequence": 1.5}, "sequence: 1.5; give one whole number"),
        ({"candidates": 0}, "candidates: 0; give one whole number from 1 on"),
    ],
)
def test_settings_that_make_no_sense_are_refused(values, words):
    with pytest.raises(InputError, match=f"map: {words}"):
        MapSettings(**values)


def test_the_defaults_are_those_of_the_map():
    assert MapSettings() == MapSettings(0.99, 0.94, 2, 12, 0.1, 0.94, 0)
