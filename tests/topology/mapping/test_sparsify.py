from itertools import pairwise

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import trajectory_of
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.sparsify import contextified, every_nth, sparsify, stored_frames
from tutorial_lib.topology.query import query
from tutorial_lib.world.sensors import Camera


class Table:
    """RE read from a table (T, T): from frame i, which the odometer holds, to frame j."""

    def __init__(self, table):
        self.table, self.calls = np.asarray(table, dtype=float), []

    def prepare(self, targets):
        return targets

    def probability(self, observations, prepared):
        self.calls.append(len(observations))
        return self.table[observations.odometry[:, 0].astype(int), prepared]


class Returns:
    """RE that always returns the same."""

    def __init__(self, returned):
        self.returned = returned

    def prepare(self, targets):
        return targets

    def probability(self, observations, prepared):
        del observations, prepared
        return self.returned


def frames(count):
    """Observations of so many frames; the odometer holds which."""
    nothing, odometry = np.zeros(count), np.zeros((count, 3))
    odometry[:, 0] = np.arange(count)
    image = np.zeros((count, 1, 1, 3), np.uint8)
    return Observation(image, None, np.ones((count, 4)), odometry, nothing, nothing)


def anchors_in(table, threshold, **extra):
    count = len(table)
    return sparsify(Table(table), frames(count), np.arange(count), threshold, **extra).tolist()


def by_the_book(table, threshold):
    """The greedy rule, word for word."""
    last, anchors = len(table) - 1, [0]
    while anchors[-1] < last:
        i = anchors[-1]
        fit = [j for j in range(i + 1, last + 1) if all(table[i, i + 1 : j + 1] > threshold)]
        anchors.append(max(fit, default=i + 1))
    return anchors


@st.composite
def tables(draw):
    """RE matrices in which long stretches hold now and then."""
    count, seed = draw(st.integers(2, 40)), draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    table = rng.random((count, count)) ** draw(st.sampled_from([0.02, 0.1, 1.0]))
    return table, draw(st.sampled_from([0.5, 0.9, 0.99]))


def test_the_fakes_fit_the_seam():
    assert isinstance(Table(np.eye(2)), Reachability)


@given(tables(), st.integers(1, 50))
@settings(max_examples=150, deadline=None)
def test_it_is_the_greedy_rule_whatever_the_window(drawn, window):
    table, threshold = drawn
    anchors = anchors_in(table, threshold, window=window)
    assert anchors == by_the_book(table, threshold)
    assert anchors[0] == 0
    assert anchors[-1] == len(table) - 1
    for i, j in pairwise(anchors):
        # Each gap holds throughout, or is a single step; and it could not be longer.
        assert (table[i, i + 1 : j + 1] > threshold).all() or j == i + 1
        assert j == len(table) - 1 or j == i + 1 or not table[i, j + 1] > threshold


def test_a_higher_threshold_can_only_shorten_the_first_gap():
    table = np.random.default_rng(0).random((60, 60)) ** 0.02
    first = [anchors_in(table, threshold)[1] for threshold in (0.9, 0.95, 0.99)]
    assert first == sorted(first, reverse=True)
    assert len(set(first)) > 1


def test_one_must_get_on_where_nothing_can_be_reached():
    assert anchors_in(np.zeros((5, 5)), 0.9) == [0, 1, 2, 3, 4]


def test_where_all_can_be_reached_only_the_ends_stay():
    assert anchors_in(np.ones((100, 100)), 0.9, window=7) == [0, 99]


def test_what_is_reachable_behind_a_gap_does_not_count():
    table = np.ones((6, 6))
    table[0, 2] = 0.5
    assert anchors_in(table, 0.9) == [0, 1, 5]


def test_exactly_the_threshold_is_not_above_it():
    assert anchors_in(np.full((3, 3), 0.75), 0.75) == [0, 1, 2]


def test_a_trajectory_is_a_handful_of_calls():
    count = 300
    ahead = np.arange(count) - np.arange(count)[:, None]
    reachability = Table(np.where(ahead <= 40, 0.99, 0.1))
    anchors = sparsify(reachability, frames(count), np.arange(count), 0.9)
    assert (np.diff(anchors)[:-1] == 40).all()
    assert len(reachability.calls) == 2 * (len(anchors) - 2) + 1  # 19 frames are left at the end
    assert max(reachability.calls) == 32


def test_anything_that_an_array_selects_from_can_be_prepared():
    reachability = Table(np.ones((4, 4)))
    found = sparsify(reachability, frames(4), torch.arange(4), 0.5)
    assert found.tolist() == [0, 3]
    assert found.dtype.kind == "i"


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda r: sparsify(r, frames(0), np.arange(0), 0.9), "0 frames; give two at least"),
        (lambda r: sparsify(r, frames(1), np.arange(1), 0.9), "1 frames; give two at least"),
        (lambda r: sparsify(r, frames(4), np.arange(3), 0.9), "3 prepared targets for 4"),
        (lambda r: sparsify(r, frames(4), np.arange(4), 0.0), "threshold 0.0; give a prob"),
        (lambda r: sparsify(r, frames(4), np.arange(4), 1.0), "threshold 1.0; give a prob"),
        (lambda r: sparsify(r, frames(4), np.arange(4), np.nan), "threshold: nan; give one"),
        (
            lambda r: sparsify(r, frames(4), np.arange(4), 0.9, window=0),
            "window: 0; give one whole",
        ),
        (lambda r: every_nth(1, 3), "1 frames"),
        (lambda r: every_nth(9, 0), "n: 0; give one whole"),
        (lambda r: contextified(np.zeros((0, 2)), 1), "there are none"),
        (lambda r: contextified(np.zeros((3, 2)), -1), "k: -1; give one whole"),
        (
            lambda r: stored_frames([0, 9], 9, 2),
            "anchors: .*; give whole numbers (from 0 to 8|of shape .A,.)",
        ),
        (
            lambda r: stored_frames([[0, 1]], 9, 2),
            "anchors: .*; give whole numbers (from 0 to 8|of shape .A,.)",
        ),
        (lambda r: stored_frames([0], 9, -1), "k: -1; give one whole"),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(InputError, match=words):
        make(Table(np.ones((4, 4))))


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (np.array([0.5, np.nan, 0.5]), "nan for pair 1; give probabilities from 0 to 1"),
        (np.array([0.5, 0.5, 3.2]), "3.2 for pair 2; .* of a logit the sigmoid"),
        (np.array([-0.1, 0.5, 0.5]), "-0.1 for pair 0"),
        (np.array([0.5, 0.5]), r"shape \(2,\); give probabilities of shape \(3,\)"),
        (np.full((3, 1), 0.5), r"shape \(3, 1\); give probabilities of shape \(3,\)"),
        (0.5, r"shape \(\); give probabilities of shape \(3,\)"),
        (None, "None; give probabilities"),
        ("likely", "'likely'; give probabilities"),
        (np.full(3, 0.5 + 0.1j), "array of complex128; give probabilities"),
        (np.ma.array([0.5] * 3, mask=[0, 1, 0]), "an array with a mask; give probabilities"),
        ([[0.5], [0.5, 0.5], 0.5], "setting an array element .*; give probabilities"),
    ],
)
def test_what_is_no_probability_is_refused(returned, words):
    with pytest.raises(InputError, match=f"reachability: .*{words}"):
        query(Returns(returned), frames(3), np.arange(3))
    with pytest.raises(InputError, match="reachability"):
        sparsify(Returns(returned), frames(4), np.arange(4), 0.5, window=3)


def test_without_pairs_re_is_not_queried():
    assert query(Returns("nonsense"), frames(0), np.arange(0)).shape == (0,)


def test_lists_and_tensors_are_probabilities_too():
    for returned in ([0.0, 0.5, 1.0], torch.tensor([0.0, 0.5, 1.0])):
        assert query(Returns(returned), frames(3), np.arange(3)).tolist() == [0.0, 0.5, 1.0]


# Frames and their contexts.


@settings(deadline=None)
@given(st.integers(2, 200), st.integers(1, 250))
def test_every_nth_frame_and_the_last(count, n):
    kept = every_nth(count, n)
    assert kept[-1] == count - 1
    assert (kept[:-1] == np.arange(0, count - 1, n)).all()


@settings(deadline=None)
@given(st.integers(1, 60), st.integers(0, 5), st.integers(0, 2**32 - 1))
def test_a_target_is_an_image_in_its_context(count, k, seed):
    images = np.random.default_rng(seed).integers(0, 256, (count, 2, 3))
    targets = contextified(images, k)
    assert targets.shape == (count, 2 * k + 1, 2, 3)
    for i in range(count):
        for j in range(-k, k + 1):
            assert (targets[i, k + j] == images[min(max(i + 3 * j, 0), count - 1)]).all()


def test_it_is_the_context_that_networks_learn_from(recorded):
    numbers = recorded.frames_of(1)
    assert (contextified(numbers, 2) == recorded.context(numbers, 2)).all()


@settings(deadline=None)
@given(st.integers(1, 80), st.integers(0, 4), st.data())
def test_stored_frames_are_those_of_the_targets(count, k, data):
    anchors = data.draw(st.lists(st.integers(0, count - 1), max_size=8))
    kept = stored_frames(np.array(anchors, dtype=int), count, k)
    assert kept == len(np.unique(contextified(np.arange(count), k)[anchors]))
    assert kept <= min(count, len(anchors) * (2 * k + 1))


# What was recorded, as it was sensed.


def test_recorded_frames_are_observed_as_they_were_sensed(recorded):
    rows = np.array([5, 0, len(recorded.poses) - 1, 5])
    seen = recorded.observe(rows)
    assert len(seen) == 4
    assert seen.depth is None
    assert (seen.image == Camera().look(recorded.scene, recorded.poses[rows])[0]).all()
    assert recorded.observe(rows, Camera(rows=64)).image.shape == (4, 64, 64, 3)
    starts = np.cumsum([0] + [len(trajectory) for trajectory in recorded.trajectories])
    for row, frame in enumerate(rows):
        number = np.searchsorted(starts, frame, side="right") - 1
        trajectory, i = recorded.trajectories[number], frame - starts[number]
        assert (seen.laser[row] == trajectory.laser[i]).all()
        assert (seen.odometry[row] == trajectory.odometry[i]).all()
        assert seen.speed[row] == trajectory.speed[i]
        assert seen.steering[row] == trajectory.steering[i]


def test_what_was_not_recorded_cannot_be_observed(recorded, box):
    for frames_wanted in ([len(recorded.poses)], [-1], [0.5], [[0]]):
        with pytest.raises(InputError, match="frames"):
            recorded.observe(np.array(frames_wanted))
    trajectories = [trajectory_of(np.tile([2.0, 2.0, 0.0], (40, 1))) for _ in range(2)]
    object.__setattr__(trajectories[1], "laser", np.zeros((40, 64), np.float32))
    with pytest.raises(InputError, match="different numbers of beams"):
        RecordedWorld(box, trajectories).observe(np.array([0]))
