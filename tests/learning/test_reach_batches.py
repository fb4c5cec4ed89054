"""What reachability is trained on: blocks of errands with how they ended, and of SPTM's pairs."""

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
from tutorial_lib.learning.networks import VIEWS, Architecture
from tutorial_lib.learning.reach_batches import (
    FAR_IN_TIME,
    NEAR_IN_TIME,
    LabelledWorld,
    OutcomeSource,
    ProximitySource,
    by_target,
)

K = 2
ARRAYS = [field.name for field in fields(Batch)]


def made_up(world, targets, seed):
    """ReachabilityPairs whose ends were drawn by lot."""
    rng = np.random.default_rng(seed)
    errands = draw_reachability_pairs(world, GridPaths(world.scene.clearance), targets, rng)
    every = np.column_stack([errands.starts, errands.targets])
    errands = errands.subset(np.sort(np.unique(every, axis=0, return_index=True)[1]))  # none twice
    count = len(errands)
    driven = rng.random(count) < 0.8
    reached = driven & (rng.random(count) < 0.6)
    return RolloutOutcomes(errands, driven, reached, driven & ~reached, np.zeros(count))


@pytest.fixture(scope="module")
def worlds(recorded, pillars):
    """An office and a room with pillars."""
    drive = make_trajectory([(1.0, 1.0), (9.0, 1.0), (9.0, 5.5), (2.0, 5.5)])
    return [recorded, RecordedWorld(pillars, [drive])]


@pytest.fixture(scope="module")
def lessons(worlds):
    """Of the mined errands' starts, about two are left for each target."""
    found = []
    for number, world in enumerate(worlds):
        mined = made_up(world, 8, 10 + number)
        few = mined.subset(np.flatnonzero(np.arange(len(mined)) % STARTS < 2))
        found.append(LabelledWorld(world, made_up(world, 15, number), few))
    return found


@pytest.fixture
def source(lessons, monkeypatch):
    """Shows poses in place of pictures."""
    monkeypatch.setitem(VIEWS, "poses", PoseView())
    architecture = Architecture(K, "pair", "poses", "reachability")
    return OutcomeSource(lessons, architecture, worlds=6, targets=20, vary=False)


def poses_in(block):
    """Poses (N, 3) of the current pictures, and (N, 2k+1, 3) of their targets' contexts."""
    return block.current[:, 0, :, 0], np.repeat(block.contexts[:, :, 0, :, 0], STARTS, axis=0)


def rows_of(lessons):
    """All errands of all worlds: starts and goals (R, 6), labels, overlaps and whether mined."""
    parts = []
    for lesson in lessons:
        for mined, outcomes in enumerate((lesson.outcomes, lesson.mined)):
            errands, count = outcomes.pairs, len(outcomes)
            goals = lesson.recorded.poses[errands.targets]
            ends = [outcomes.reached, errands.overlap, np.full(count, mined)]
            parts.append(np.column_stack([errands.starts, goals, *ends]))
    return np.concatenate(parts)


def errands_in(block, lessons):
    """The errand (N, 10) that each row of a block was made from."""
    rows = rows_of(lessons)
    assert len(np.unique(rows[:, :6], axis=0)) == len(rows)
    starts, contexts = poses_in(block)
    gap, numbers = cKDTree(rows[:, :6]).query(np.column_stack([starts, contexts[:, K]]))
    assert gap.max() < 1e-9
    return rows[numbers]


def same(one, two):
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ARRAYS)


# ReachabilityPairs and their outcomes.


def test_labels_of_a_block_are_those_of_its_errands(source, lessons):
    block = source.block([1])
    rows = errands_in(block, lessons)
    assert block.reached == pytest.approx(rows[:, 6])
    assert block.overlap == pytest.approx(rows[:, 7:9])
    assert (block.weight == 1.0).all()
    assert (block.placed == (rows[:, 7:9].min(axis=1) >= 0.1)).all()
    for labels in (block.placed, block.reached):
        assert 0.0 < labels.mean() < 1.0


def test_starts_of_one_target_share_its_context(source, lessons, worlds):
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
def test_a_share_of_the_targets_is_mined(source, lessons, share):
    blocks = [replace(source, mined=share).block([4, i]) for i in range(4)]
    mined = np.concatenate([errands_in(block, lessons)[::STARTS, 9] for block in blocks])
    assert mined.mean() == pytest.approx(share, abs=0.08)


def test_worlds_without_mined_errands_teach_those_that_they_have(source, lessons):
    none = lessons[1].outcomes.subset(np.array([], dtype=int))
    few = [lessons[0], replace(lessons[1], mined=none), replace(lessons[1], mined=None)]
    block = replace(source, labelled=few, mined=0.5).block([5])
    rows = errands_in(block, lessons)
    office = cKDTree(lessons[0].recorded.poses).query(rows[:, 3:6])[0] < 1e-9
    assert 0.3 < rows[office, 9].mean() < 0.7
    assert not rows[~office, 9].any()
    assert (~office).mean() > 0.2


@pytest.mark.parametrize("vary", [False, True])
def test_all_targets_of_a_block_may_be_mined(source, lessons, vary):
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


def test_a_source_tells_what_its_blocks_are_made_of(source, lessons):
    told = source.recipe
    ends = [lesson.outcomes.reached for lesson in lessons]
    assert told["errands"] == sum(len(reached) for reached in ends)
    assert told["reached"] == sum(reached.sum() for reached in ends)
    assert told["mined"] == [sum(len(lesson.mined) for lesson in lessons), source.mined]
    others = [
        replace(source, mined=0.25),
        replace(source, vary=True),
        replace(source, targets=9),
        replace(source, labelled=lessons[:1]),
        replace(source, labelled=[replace(lesson, mined=None) for lesson in lessons]),
    ]
    assert all(other.recipe != told for other in others)


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
    ways = [(1.0, 1.0), (9.0, 1.0), (9.0, 9.0)], [(1.0, 9.0), (1.0, 2.0), (8.0, 2.0)]
    drives = [RecordedWorld(box, [make_trajectory(way) for way in ways])]
    drives.append(RecordedWorld(pillars, [make_trajectory([(1.5, 1.5), (8.5, 1.5), (8.5, 8.5)])]))
    return ProximitySource(drives, Architecture(0, "pair", "poses", "reachability"), 8, 16)


def without_marks(poses):
    """Poses (N, 3) as x, y, cosine and sine; `PoseView.vary` adds whole turns."""
    return np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])


def pairs_in(block, drives):
    """Number of the world and frames (N,) of sources and targets."""
    starts, contexts = poses_in(block)
    number, found = np.full(len(starts), -1), np.zeros((2, len(starts)), int)
    for world, recorded in enumerate(drives):
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
    # Forwards and backwards in time alike, and the pictures' overlap is not told.
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
