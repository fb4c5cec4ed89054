"""Plain image similarity: what learned reachability is compared with."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.query import query
from tutorial_lib.topology.similarity import ImageSimilarity

SIMILARITY = ImageSimilarity()


def seen(images):
    """Robots that see images (N, H, W, 3), and nothing else."""
    nothing = np.zeros(len(images))
    laser, odometry = np.zeros((len(images), 4)), np.zeros((len(images), 3))
    return Observation(np.asarray(images), None, laser, odometry, nothing, nothing)


def images(count, seed=0, low=0, high=256):
    return np.random.default_rng(seed).integers(low, high, (count, 4, 6, 3)).astype(np.uint8)


def similarity_of(current, targets):
    """Similarities of images (N, H, W, 3) to targets without context."""
    return SIMILARITY.probability(seen(current), SIMILARITY.prepare(targets[:, None]))


def test_it_stands_where_reachability_is_expected():
    assert isinstance(SIMILARITY, Reachability)
    prepared = SIMILARITY.prepare(images(5)[:, None])
    assert query(SIMILARITY, seen(images(5, 1)), prepared).shape == (5,)


@given(st.integers(0, 1000))
def test_it_is_the_correlation_of_all_pixels_moved_to_0_to_1(seed):
    current, targets = images(4, seed), images(4, seed + 1)
    targets[1] = current[1] // 2  # alike
    for mine, other, similarity in zip(
        current, targets, similarity_of(current, targets), strict=True
    ):
        wanted = np.corrcoef(mine.ravel().astype(float), other.ravel().astype(float))[0, 1]
        assert similarity == pytest.approx(0.5 + 0.5 * wanted, abs=1e-5)


def test_the_same_is_1_and_the_reverse_is_0():
    some = images(6)
    assert similarity_of(some, some) == pytest.approx(1.0, abs=1e-6)
    assert similarity_of(some, 255 - some) == pytest.approx(0.0, abs=1e-6)
    assert similarity_of(some, some).max() <= 1.0
    assert similarity_of(some, 255 - some).min() >= 0.0


def test_brightness_and_contrast_do_not_matter():
    some, others = images(6, high=100), images(6, 1, high=100)
    assert similarity_of(some, 2 * others + 30) == pytest.approx(
        similarity_of(some, others), abs=1e-6
    )


def test_images_that_have_nothing_in_common_are_in_the_middle():
    assert similarity_of(images(200), images(200, 1)).mean() == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("level", [0, 77, 255])
def test_a_picture_of_nothing_is_like_no_other(level):
    nothing = np.full((3, 4, 6, 3), level, np.uint8)
    assert similarity_of(nothing, images(3)) == pytest.approx(0.5)
    assert similarity_of(images(3), nothing) == pytest.approx(0.5)
    assert similarity_of(nothing, nothing) == pytest.approx(0.5)


def test_each_robot_is_compared_with_its_own_target():
    current, targets = images(8), images(8, 1)
    together, order = similarity_of(current, targets), np.array([5, 2, 2, 7])
    prepared = SIMILARITY.prepare(targets[:, None])
    some = SIMILARITY.probability(seen(current[order]), prepared[order])
    assert some == pytest.approx(together[order])
    assert similarity_of(targets, current) == pytest.approx(together)


@pytest.mark.parametrize("k", [0, 1, 2, 5])
def test_of_a_context_the_picture_in_the_middle_counts(k):
    contexts = images(3 * (2 * k + 1)).reshape(3, 2 * k + 1, 4, 6, 3)
    prepared = SIMILARITY.prepare(contexts)
    assert prepared == pytest.approx(SIMILARITY.prepare(contexts[:, [k]]))
    assert SIMILARITY.probability(seen(contexts[:, k]), prepared) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("shape", [(3, 4, 6, 3), (4, 6, 3), (1, 3, 1, 4, 6, 3)])
def test_targets_that_are_no_contexts_are_refused(shape):
    with pytest.raises(InputError, match=r"images: .*shape \(M, P, H, W, 3\)"):
        SIMILARITY.prepare(np.zeros(shape, np.uint8))


@pytest.mark.parametrize("count", [1, 4])
def test_as_many_targets_as_robots_are_needed(count):
    prepared = SIMILARITY.prepare(images(count)[:, None])
    with pytest.raises(InputError, match=f"{count} for 3; give as many"):
        SIMILARITY.probability(seen(images(3)), prepared)


def test_along_a_trajectory_the_next_frames_are_the_most_alike(recorded):
    frames = np.arange(0, 200, 4)
    there = recorded.observe(frames)
    prepared = SIMILARITY.prepare(there.image[:, None])
    rows, columns = (pairs.ravel() for pairs in np.indices((len(frames), len(frames))))
    table = SIMILARITY.probability(there[rows], prepared[columns]).reshape(50, 50)
    apart = np.abs(np.subtract.outer(frames, frames))
    assert np.diag(table) == pytest.approx(1.0, abs=1e-6)
    assert table[apart == 4].mean() > table[apart == 40].mean() + 0.05
