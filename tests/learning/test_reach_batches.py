"""What reachability is trained on: blocks of pairs with their outcomes, and of SPTM's pairs."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from tests.conftest import make_trajectory
from tests.learning.test_training import PoseView
from tutorial_lib.driving.data.reachability_pairs import STARTS, draw_reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.geometry import relative
from tutorial_lib.learning.batches import Batch, batches
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.reach_batches import (
    FAR_IN_TIME,
    NEAR_IN_TIME,
    LabelledWorld,
    OutcomeSource,
    ProximitySource,
    by_target,
)
from tutorial_lib.learning.views import VIEWS

K = 2
ARRAYS = [field.name for field in fields(Batch)]


def made_up(world, targets, seed):
    """ReachabilityPairs whose ends were drawn by lot."""
    rng = np.random.default_rng(seed)
    pairs = draw_reachability_pairs(world, GridPaths(world.scene.clearance), targets, rng)
    every = np.column_stack([pairs.starts, pairs.targets])
    pairs = pairs.subset(np.sort(np.unique(every, axis=0, return_index=True)[1]))  # none twice
    count = len(pairs)
    driven = rng.random(count) < 0.8
    reached = driven & (rng.random(count) < 0.6)
    return RolloutOutcomes(pairs, driven, reached, driven & ~reached, np.zeros(count))


@pytest.fixture(scope="module")
def worlds(recorded, pillars):
    """An office and a room with pillars."""
    trajectory = make_trajectory([(1.0, 1.0), (9.0, 1.0), (9.0, 5.5), (2.0, 5.5)])
    return [recorded, RecordedWorld(pillars, [trajectory])]


@pytest.fixture(scope="module")
def labelled(worlds):
    """Of the mined pairs' starts, about two are left for each target."""
    found = []
    for number, world in enumerate(worlds):
        mined = made_up(world, 8, 10 + number)
        few = mined.subset(np.flatnonzero(np.arange(len(mined)) % STARTS < 2))
        found.append(LabelledWorld(world, made_up(world, 15, number), few))
    return found


@pytest.fixture
def source(labelled, monkeypatch):
    """Shows poses in place of images."""
    monkeypatch.setitem(VIEWS, "poses", PoseView())
    architecture = Architecture(K, "pair", "poses", "reachability")
    return OutcomeSource(labelled, architecture, worlds=6, targets=20, vary=False)


def poses_in(block):
    """Poses (N, 3) of the current images, and (N, 2k+1, 3) of their targets' contexts."""
    return block.current[:, 0, :, 0], np.repeat(block.contexts[:, :, 0, :, 0], STARTS, axis=0)


def rows_of(labelled):
    """All pairs of all worlds: starts and goals (R, 6), labels, overlaps and whether mined."""
    parts = []
    for entry in labelled:
        for mined, outcomes in enumerate((entry.outcomes, entry.mined)):
            pairs, count = outcomes.pairs, len(outcomes)
            goals = entry.recorded.poses[pairs.targets]
            ends = [outcomes.reached, pairs.overlap, np.full(count, mined)]
            parts.append(np.column_stack([pairs.starts, goals, *ends]))
    return np.concatenate(parts)


def labelled_pairs_in(block, labelled):
    """The pair (N, 10) that each row of a block was made from."""
    rows = rows_of(labelled)
    assert len(np.unique(rows[:, :6], axis=0)) == len(rows)
    starts, contexts = poses_in(block)
    gap, numbers = cKDTree(rows[:, :6]).query(np.column_stack([starts, contexts[:, K]]))
    assert gap.max() < 1e-9
    return rows[numbers]


def same(one, two):
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ARRAYS)


# ReachabilityPairs and their outcomes.


def test_labels_of_a_block_are_those_of_its_pairs(source, labelled):
    block = source.block([1])
    rows = labelled_pairs_in(block, labelled)
    assert block.reached == pytest.approx(rows[:, 6])
    assert block.overlap == pytest.approx(rows[:, 7:9])
    assert (block.weight == 1.0).all()
    assert (block.placed == (rows[:, 7:9].min(axis=1) >= 0.1)).all()
    for labels in (block.placed, block.reached):
        assert 0.0 < labels.mean() < 1.0


def test_starts_of_one_target_share_its_context(source, labelled, worlds):
    block = source.block([2])
    assert block.contexts.shape == (120, 2 * K + 1, 1, 3, 1)
    assert block.current.shape == (120 * STARTS, 1, 3, 1)
    starts, contexts = poses_in(block)
    every = np.concatenate([world.poses for world in worlds])
    assert cKDTree(every).query(contexts.reshape(-1, 3))[0].max() < 1e-9
    seen = relative(starts[:, None], contexts)
    turn = np.stack([np.cos(seen[..., 2]), np.sin(seen[..., 2])], axis=-1)
    assert block.context_poses[..., :2] == pytest.approx(seen[..., :2], abs=1e-4)
    assert block.context_poses[..., 2:] == pytest.approx(turn, abs=1e-5)
    for name in ARRAYS[2:]:
        assert getattr(block, name).dtype == np.float32, name


def test_targets_of_different_worlds_are_mixed(source, worlds):
    _, contexts = poses_in(source.block([3]))
    first = cKDTree(worlds[0].poses).query(contexts[::STARTS, K])[0] < 1e-9
    assert 0 < first.sum() < len(first)
    assert (np.diff(first) != 0).sum() > 10


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_a_share_of_the_targets_is_mined(source, labelled, share):
    blocks = [replace(source, mined=share).block([4, i]) for i in range(4)]
    mined = np.concatenate([labelled_pairs_in(block, labelled)[::STARTS, 9] for block in blocks])
    assert mined.mean() == pytest.approx(share, abs=0.08)


def test_worlds_without_mined_pairs_give_those_that_they_have(source, labelled):
    none = labelled[1].outcomes.subset(np.array([], dtype=int))
    few = [labelled[0], replace(labelled[1], mined=none), replace(labelled[1], mined=None)]
    block = replace(source, labelled=few, mined=0.5).block([5])
    rows = labelled_pairs_in(block, labelled)
    office = cKDTree(labelled[0].recorded.poses).query(rows[:, 3:6])[0] < 1e-9
    assert 0.3 < rows[office, 9].mean() < 0.7
    assert not rows[~office, 9].any()
    assert (~office).mean() > 0.2


@pytest.mark.parametrize("vary", [False, True])
def test_all_targets_of_a_block_may_be_mined(source, labelled, vary):
    block = replace(source, mined=1.0, vary=vary).block([6])
    assert len(block.contexts) == 120


def test_all_pictures_of_a_target_are_varied_alike(source):
    block = replace(source, vary=True).block([7])
    starts, contexts = poses_in(block)
    current, shown = (np.rint(part[..., 2] / (20 * np.pi)) for part in (starts, contexts))
    assert (current == shown[:, 0]).all()
    assert (shown == shown[:, :1]).all()
    assert len(np.unique(current)) > 60


def test_the_same_seed_makes_the_same_block(source):
    assert same(source.block([1, 2]), source.block([1, 2]))
    assert not same(source.block([1, 2]), source.block([1, 3]))
    coming = batches(source, 5, 0, 30)
    assert same(next(coming), source.block([5, 0]).targets(slice(0, 30)))
    coming.close()


def test_a_source_describes_what_its_blocks_are_made_of(source, labelled):
    recipe = source.recipe
    ends = [entry.outcomes.reached for entry in labelled]
    assert recipe["errands"] == sum(len(reached) for reached in ends)
    assert recipe["reached"] == sum(reached.sum() for reached in ends)
    assert recipe["mined"] == [sum(len(entry.mined) for entry in labelled), source.mined]
    others = [
        replace(source, mined=0.25),
        replace(source, vary=True),
        replace(source, targets=9),
        replace(source, labelled=labelled[:1]),
        replace(source, labelled=[replace(entry, mined=None) for entry in labelled]),
    ]
    assert all(other.recipe != recipe for other in others)


# Rows by target.


@given(
    st.lists(st.tuples(st.integers(1, 12), st.integers(0, 99)), min_size=1, max_size=9),
    st.integers(0, 20),
    st.integers(0, 99),
)
def test_rows_are_those_of_their_targets_and_short_ones_are_repeated(groups, count, seed):
    sizes, gaps = np.array(groups).T
    targets = np.repeat(np.cumsum(gaps + 1), sizes)
    frames, rows = by_target(targets, count, np.random.default_rng(seed))
    assert frames.shape == (count,)
    rows = rows.reshape(count, STARTS)
    assert (targets[rows] == frames[:, None]).all()
    for frame, some in zip(frames, rows, strict=True):
        # All rows of a target with few of them, and no row twice where there are enough.
        assert len(set(some)) == min((targets == frame).sum(), STARTS)


def test_sooner_or_later_every_row_is_drawn_and_targets_as_often_as_each_other():
    targets = np.repeat([7, 3, 30, 4], [1, 40, 5, 7])
    frames, rows = by_target(targets, 2000, np.random.default_rng(0))
    often = np.bincount(rows, minlength=53)
    # 2,000 x 5 rows of 4 groups: of the largest each is expected 62 times.
    assert often.min() > 35
    assert often[1:41].max() < 95
    drawn = np.bincount(frames)[[7, 3, 30, 4]] / 2000
    assert drawn == pytest.approx(0.25, abs=0.04)


# SPTM's pairs.


@pytest.fixture
def proximity(pillars, box, monkeypatch):
    monkeypatch.setitem(VIEWS, "poses", PoseView())
    lines = [(1.0, 1.0), (9.0, 1.0), (9.0, 9.0)], [(1.0, 9.0), (1.0, 2.0), (8.0, 2.0)]
    worlds = [RecordedWorld(box, [make_trajectory(line) for line in lines])]
    worlds.append(RecordedWorld(pillars, [make_trajectory([(1.5, 1.5), (8.5, 1.5), (8.5, 8.5)])]))
    return ProximitySource(worlds, Architecture(0, "pair", "poses", "reachability"), 8, 16)


def without_marks(poses):
    """Poses (N, 3) as x, y, cosine and sine; `PoseView.vary` adds whole turns."""
    return np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])


def pairs_in(block, worlds):
    """Number of the world and frames (N,) of sources and targets."""
    starts, contexts = poses_in(block)
    number, found = np.full(len(starts), -1), np.zeros((2, len(starts)), int)
    for world, recorded in enumerate(worlds):
        tree = cKDTree(without_marks(recorded.poses))
        for place, poses in enumerate((starts, contexts[:, 0])):
            gap, frames = tree.query(without_marks(poses))
            found[place, gap < 1e-6] = frames[gap < 1e-6]
            number[gap < 1e-6] = world
    assert number.min() >= 0
    return number, *found


def test_what_is_close_in_time_is_close(proximity):
    block = proximity.block([0])
    number, sources, targets = pairs_in(block, proximity.recorded_worlds)
    longest = max(len(recorded.poses) for recorded in proximity.recorded_worlds)
    first = np.zeros((2, longest), int)
    for world, recorded in enumerate(proximity.recorded_worlds):
        first[world, : len(recorded.poses)] = recorded.first
    own = first[number, sources] == first[number, targets]
    apart = np.abs(sources - targets)
    close = own & (apart <= NEAR_IN_TIME)
    undecided = own & (apart > NEAR_IN_TIME) & (apart < FAR_IN_TIME)
    assert (block.reached == close).all()
    assert (block.weight == ~undecided).all()
    assert 0.45 < close.mean() < 0.65
    assert undecided.any()
    assert (~own).any()
    assert close[apart == NEAR_IN_TIME].any()
    # Forwards and backwards in time alike, and the images' overlap plays no part.
    assert 0.3 < (sources < targets)[close & (apart > 0)].mean() < 0.7
    assert not block.placed.any()


def test_blocks_of_pairs_are_drawn_by_their_seed_and_varied_by_target(proximity):
    block = proximity.block([3])
    assert same(block, proximity.block([3]))
    assert not same(block, proximity.block([4]))
    assert block.contexts.shape[:2] == (8 * 16, 1)
    starts, contexts = poses_in(block)
    marks = [np.rint(part[..., 2] / (20 * np.pi)) for part in (starts, contexts[:, 0])]
    assert (marks[0] == marks[1]).all()
    assert len(np.unique(marks[0])) > 50
