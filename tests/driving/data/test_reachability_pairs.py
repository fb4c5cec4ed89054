"""ReachabilityPairs: from where to where, how far that is, and what is seen of the target."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from tests.conftest import make_box, make_trajectory
from tutorial_lib.driving import geodesics
from tutorial_lib.driving.data import reachability_pairs as module
from tutorial_lib.driving.data.perturbation import TRAINING_PERTURBATION
from tutorial_lib.driving.data.reachability_pairs import (
    FAR,
    OTHER,
    SAME,
    SEEN,
    STARTS,
    ReachabilityPairs,
    draw_reachability_pairs,
    reachability_pairs,
)
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.floorplan import Room
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.visibility import mutual_overlap

COLUMNS = ("starts", "targets", "overlap", "geodesic")


@pytest.fixture(scope="module")
def paths(recorded):
    return GridPaths(recorded.scene.clearance)


@pytest.fixture(scope="module")
def pairs(recorded, paths):
    return draw_reachability_pairs(recorded, paths, 200, np.random.default_rng(0))


def two_rooms():
    """A room from (0, 0) to (4, 4), one from (4.2, 4.2) to (10.2, 10.2), and no door."""
    one, other = make_box(4.0, 4.0), make_box(6.0, 6.0)
    corners = ((4.2, 4.2), (10.2, 4.2), (10.2, 10.2), (4.2, 10.2))
    plan = replace(
        one,
        walls=np.concatenate([one.walls, other.walls + 4.2]),
        wall_materials=one.wall_materials * 2,
        wall_offsets=np.zeros(8),
        rooms=(one.rooms[0], Room("office", corners)),
    )
    trajectories = [
        make_trajectory([(1.0, 1.0), (3.0, 1.0), (3.0, 3.0)]),
        make_trajectory([(5.0, 5.0), (9.0, 9.0)]),
    ]
    return RecordedWorld(Scene(plan), trajectories)


def equal(one, two):
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in COLUMNS)


# What is measured.


def test_every_pair_is_measured_for_itself(recorded, paths, pairs):
    goals = recorded.poses[pairs.targets]
    overlap = mutual_overlap(recorded.scene.caster, pairs.starts, goals)
    assert (pairs.overlap == overlap).all()
    assert pairs.geodesic == pytest.approx(paths.between(pairs.starts[:, :2], goals[:, :2]))
    straight = np.hypot(*(pairs.starts - goals)[:, :2].T)
    assert (pairs.geodesic >= straight - 1e-9).all()
    for name, shape in zip(COLUMNS, ((3,), (), (2,), ()), strict=True):
        assert getattr(pairs, name).shape == (len(pairs), *shape)


def test_the_path_back_is_as_long_and_sees_the_same_in_reverse(recorded, paths):
    here, there = np.random.default_rng(1).integers(len(recorded.poses), size=(2, 60))
    out = reachability_pairs(recorded, paths, recorded.poses[here], there)
    back = reachability_pairs(recorded, paths, recorded.poses[there], here)
    assert out.geodesic == pytest.approx(back.geodesic)
    assert (out.overlap == back.overlap[:, ::-1]).all()
    assert (out.overlap[:, 0] != out.overlap[:, 1]).mean() > 0.1


def test_a_robot_at_its_target_has_no_distance_to_go_and_sees_all(recorded, paths):
    frames = np.arange(5, 900, 100)
    there = reachability_pairs(recorded, paths, recorded.poses[frames], frames)
    assert there.geodesic == pytest.approx(0.0)
    assert there.overlap.min() > 0.95
    assert there.limit == pytest.approx(5.0)


def test_pairs_without_a_path_are_left_out():
    recorded = two_rooms()
    paths, frames = GridPaths(recorded.scene.clearance), np.array([0, 100, 40, 150, 3])
    starts = recorded.poses[[20, 20, 120, 160, 60]]
    found = reachability_pairs(recorded, paths, starts, frames)
    assert found.targets.tolist() == [0, 150, 3]
    assert (found.starts == starts[[0, 3, 4]]).all()
    assert (found.overlap == mutual_overlap(
        recorded.scene.caster, starts[[0, 3, 4]], recorded.poses[[0, 150, 3]]
    )).all()  # fmt: skip
    drawn = draw_reachability_pairs(recorded, paths, 40, np.random.default_rng(0))
    assert np.isfinite(drawn.geodesic).all()
    assert len(drawn) == pytest.approx(40 * SAME, abs=8)  # other trajectories are in the other room


# What follows from it.

shares = st.floats(0.0, 1.0)


@given(st.lists(st.tuples(shares, shares, st.floats(0.0, 40.0)), min_size=1, max_size=20))
def test_a_pair_is_never_both_seen_and_far_and_occluded(rows):
    first, second, geodesic = np.array(rows).T
    nothing = np.zeros(len(rows))
    some = ReachabilityPairs(
        np.stack([nothing] * 3, axis=1),
        nothing.astype(int),
        np.column_stack([first, second]),
        geodesic,
    )
    for number, (one, two, metres) in enumerate(rows):
        assert some.seen[number] == (one >= SEEN and two >= SEEN)
        assert some.far_and_occluded[number] == (metres > FAR and one < SEEN and two < SEEN)
        assert some.limit[number] == pytest.approx(5.0 + metres / 0.3)
    assert not (some.seen & some.far_and_occluded).any()


@pytest.mark.parametrize(
    ("overlap", "metres", "seen", "far_and_occluded"),
    [
        ((0.1, 0.1), 9.0, True, False),
        ((0.1, 0.09), 9.0, False, False),
        ((0.09, 0.1), 9.0, False, False),
        ((0.09, 0.09), 9.0, False, True),
        ((0.0, 0.0), 5.0, False, False),
        ((0.0, 0.0), 5.01, False, True),
        ((0.9, 0.9), 40.0, True, False),
    ],
)
def test_what_is_seen_and_what_is_far_and_occluded(overlap, metres, seen, far_and_occluded):
    one = ReachabilityPairs(
        np.zeros((1, 3)), np.zeros(1, int), np.array([overlap]), np.array([metres])
    )
    assert one.seen.tolist() == [seen]
    assert one.far_and_occluded.tolist() == [far_and_occluded]


@pytest.mark.parametrize("numbers", [np.array([7, 3, 3]), slice(4, 9), np.arange(900) % 9 == 1])
def test_a_subset_of_pairs_keeps_its_rows(pairs, numbers):
    pairs = pairs.subset(np.arange(900))
    some = pairs.subset(numbers)
    for name in COLUMNS:
        assert (getattr(some, name) == getattr(pairs, name)[numbers]).all()
    assert len(some) == len(some.targets)


# How they are drawn.


@pytest.mark.full
def test_the_same_seed_draws_the_same_pairs(recorded, paths, pairs):
    assert equal(draw_reachability_pairs(recorded, paths, 200, np.random.default_rng(0)), pairs)
    assert not equal(draw_reachability_pairs(recorded, paths, 200, np.random.default_rng(1)), pairs)


def test_starts_of_one_target_come_in_a_row(pairs):
    changes = np.flatnonzero(np.diff(pairs.targets, prepend=-1))
    sizes = np.diff(np.append(changes, len(pairs)))
    assert STARTS == SAME + OTHER == 5
    assert len(sizes) == pytest.approx(200, abs=5)  # now and then a frame is drawn twice in a row
    assert len(pairs) <= 1000
    assert np.median(sizes) == STARTS


def test_a_robot_can_stand_at_every_start(recorded, pairs):
    free = is_free(recorded.scene, BicycleCar(), pairs.starts)
    recorded_too = cKDTree(recorded.poses).query(pairs.starts)[0] < 1e-9
    assert (free | recorded_too).all()
    assert free.mean() > 0.99


def test_a_third_of_the_starts_lies_on_a_trajectory_and_the_others_beside_one(recorded, pairs):
    on_it = cKDTree(recorded.poses).query(pairs.starts)[0] < 1e-9
    assert on_it.mean() == pytest.approx(0.35, abs=0.05)
    beside = cKDTree(recorded.poses[:, :2]).query(pairs.starts[~on_it, :2])[0]
    assert 0.03 < np.median(beside) < 0.4
    assert beside.max() <= TRAINING_PERTURBATION.most + 1e-9


def test_where_no_start_beside_a_trajectory_is_free_only_starts_on_it_remain(
    recorded, paths, monkeypatch
):
    def nowhere(scene, poses, perturbation, rng):
        return np.full(poses.shape, 1e6), np.zeros(len(poses), dtype=bool)

    monkeypatch.setattr(module, "perturbed", nowhere)
    found = draw_reachability_pairs(recorded, paths, 100, np.random.default_rng(0))
    assert cKDTree(recorded.poses).query(found.starts)[0].max() == 0.0
    assert len(found) == pytest.approx(0.35 * 500, abs=40)


@pytest.fixture
def unshifted(recorded, paths, monkeypatch):
    """Frames (G, 5) that starts were drawn from, and their targets (G, 1)."""

    def stay(scene, poses, perturbation, rng):
        return poses.copy(), np.ones(len(poses), dtype=bool)

    monkeypatch.setattr(module, "perturbed", stay)
    found = draw_reachability_pairs(recorded, paths, 400, np.random.default_rng(2))
    gap, sources = cKDTree(recorded.poses).query(found.starts)
    assert gap.max() == 0.0
    assert len(found) == 400 * STARTS
    return sources.reshape(400, STARTS), found.targets.reshape(400, STARTS)[:, :1]


def test_three_starts_are_on_the_target_s_trajectory_and_two_on_others(recorded, unshifted):
    sources, targets = unshifted
    own = recorded.first[sources] == recorded.first[targets]
    assert own[:, :SAME].all()
    assert not own[:, SAME:].any()


def test_on_its_own_trajectory_a_target_is_mostly_near_and_ahead(recorded, unshifted):
    sources, targets = (part[:, :SAME] for part in np.broadcast_arrays(*unshifted))
    ahead = recorded.arc[targets] - recorded.arc[sources]
    frame = 0.09  # metres between two frames at most
    assert -6.0 - frame <= ahead.min() < -3.0
    assert 12.0 < ahead.max() <= 20.0 + frame
    near = (ahead > -1.0 - frame) & (ahead < 4.0 + frame)
    # 65% of all, those of the others that fall there, and where a trajectory ends earlier.
    assert 0.7 < near.mean() < 0.92
    assert (ahead > 0.5).mean() > 0.6
    assert (ahead > 5.0).mean() > 0.04
    assert (ahead < -0.1).mean() > 0.1


def test_one_start_on_another_trajectory_is_near_and_one_is_anywhere(recorded, unshifted):
    sources, targets = unshifted
    gap = np.hypot(*np.moveaxis(recorded.poses[sources] - recorded.poses[targets], -1, 0)[:2])
    every = recorded.poses[:, :2]
    apart = np.hypot(*np.moveaxis(every - every[targets], -1, 0))
    other = recorded.first != recorded.first[targets]
    chance = ((apart < 4.0) & other).mean(axis=1)
    crowded = chance > 0.25  # where one of 24 tries will be near, but for one in a thousand
    assert crowded.sum() > 50
    assert (gap[crowded, SAME] < 4.0).mean() > 0.97
    assert (gap[crowded, SAME + 1] < 4.0).mean() < 0.7


def test_half_of_those_anywhere_start_in_a_room_of_the_same_type(recorded, unshifted):
    sources, targets = unshifted[0][:, SAME + 1], unshifted[1][:, 0]
    kind = np.full(len(recorded.poses), "none", dtype=object)
    for room in recorded.scene.plan.rooms:
        kind[room.contains(recorded.poses[:, :2])] = room.kind
    every = recorded.poses[:, :2]
    apart = np.hypot(*np.moveaxis(every - every[targets][:, None], -1, 0))
    other = recorded.first != recorded.first[targets][:, None]
    fits = (apart > 4.0) & (kind == kind[targets][:, None]) & other
    chance = fits.sum(axis=1) / other.sum(axis=1)
    often = chance > 0.2
    assert often.sum() > 50
    alike = fits[np.arange(len(sources)), sources][often].mean()
    assert alike == pytest.approx(0.5 + 0.5 * chance[often].mean(), abs=0.1)


def test_where_there_is_only_one_trajectory_all_starts_are_on_it(box):
    recorded = RecordedWorld(box, [make_trajectory([(1.0, 1.0), (9.0, 1.0), (9.0, 8.0)])])
    found = draw_reachability_pairs(
        recorded, GridPaths(box.clearance), 30, np.random.default_rng(0)
    )
    assert len(found) == 30 * STARTS


# Geodesics between many places.


@pytest.fixture(scope="module")
def places(paths):
    """Starts and goals, of which some goals come again."""
    rng = np.random.default_rng(3)
    starts, goals = paths.points[rng.integers(len(paths.points), size=(2, 40))]
    starts = starts + rng.uniform(-0.2, 0.2, starts.shape)
    return starts, goals[rng.integers(12, size=40)] + 0.03


@pytest.mark.parametrize("at_once", [1, 5, 12, 256])
def test_geodesics_between_places_are_those_of_each_goal_s_field(
    paths, places, monkeypatch, at_once
):
    monkeypatch.setattr(geodesics, "_AT_ONCE", at_once)
    starts, goals = places
    found = paths.between(starts, goals)
    for start, goal, metres in zip(starts, goals, found, strict=True):
        assert metres == paths.fields(goal, shortest=True).distance(start[None])[0]
    order = np.random.default_rng(0).permutation(len(starts))
    assert (paths.between(starts[order], goals[order]) == found[order]).all()


def test_where_no_path_leads_it_is_infinitely_far():
    paths = GridPaths(two_rooms().scene.clearance)
    starts = [[1.0, 1.0], [5.0, 5.0], [1.0, 1.0], [-3.0, 0.0]]
    goals = [[3.0, 1.0], [9.0, 5.0], [5.0, 5.0], [3.0, 1.0]]
    found = paths.between(starts, goals)
    assert found[:2] == pytest.approx([2.0, 4.0], abs=0.3)
    assert np.isinf(found[2:]).all()
    assert paths.between(np.empty((0, 2)), np.empty((0, 2))).shape == (0,)


def test_a_goal_in_a_wall_is_refused(paths):
    with pytest.raises(InputError, match="not in free space"):
        paths.between([[1.0, 1.0]], [[-5.0, 0.0]])
