from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box, make_trajectory, trajectory_of
from tutorial_lib.driving import geodesics
from tutorial_lib.driving.data import episodes as module
from tutorial_lib.driving.data.episodes import RADIUS, Episodes, draw_episodes, with_obstacles
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, Perturbation, perturbed
from tutorial_lib.driving.data.recorded_world import AHEAD, BEHIND, CLOSE, RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import geodesic_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import distance_to_segments, relative
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import scene_of

CAR = BicycleCar()
PASSED_AT, CLEAR = module._BESIDE, module._CLEAR
WIDE = Perturbation(aside=0.6, wide=0.5, wide_turn=1.0)


def halves():
    """A room with a thin wall across it, at x = 5, that ends 1 m before the upper wall."""
    plan = make_box()
    return Scene(
        replace(
            plan,
            walls=np.concatenate([plan.walls, [[5.0, 0.0, 5.0, 9.0]]]),
            wall_materials=("paint",) * 5,
            wall_offsets=np.append(plan.wall_offsets, 0.0),
        )
    )


# How far from a trajectory.


def test_a_perturbation_shifts_to_the_side_and_turns():
    poses = np.random.default_rng(0).uniform(-3, 3, (4000, 3))
    moved = relative(poses, PAPER_PERTURBATION.apply(poses, np.random.default_rng(1)))
    assert moved[:, 0] == pytest.approx(0.0, abs=1e-12)
    assert moved[:, 1:].mean(axis=0) == pytest.approx(0.0, abs=0.02)
    assert moved[:, 1].std() == pytest.approx(0.3, rel=0.05)
    assert moved[:, 2].std() == pytest.approx(np.deg2rad(9.0), rel=0.05)
    assert abs(np.corrcoef(moved[:, 1], moved[:, 2])[0, 1]) < 0.06


def test_no_shift_is_wider_than_the_most():
    poses = np.zeros((2000, 3))
    aside = Perturbation(aside=1.0, most=0.7).apply(poses, np.random.default_rng(0))[:, 1]
    assert aside.min() == -0.7
    assert aside.max() == 0.7


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_a_share_of_the_turns_is_wide(share):
    perturbation = Perturbation(turn=0.01, wide_turn=1.0, wide=share)
    turn = perturbation.apply(np.zeros((4000, 3)), np.random.default_rng(0))[:, 2]
    # Of the wide ones 4% are smaller than 0.05, and of the others none are larger.
    assert (np.abs(turn) > 0.05).mean() == pytest.approx(0.96 * share, abs=0.03)


def test_perturbed_poses_are_free_and_see_where_they_come_from(pillars):
    rng = np.random.default_rng(0)
    poses = np.column_stack([rng.uniform(0.3, 9.7, (400, 2)), rng.uniform(-3, 3, 400)])
    poses = poses[is_free(pillars, CAR, poses)]
    moved, found = perturbed(pillars, poses, WIDE, rng)
    assert found.mean() > 0.95
    assert is_free(pillars, CAR, moved[found]).all()
    assert pillars.caster.sees(poses[found, :2], moved[found, :2]).all()
    raw = WIDE.apply(poses, np.random.default_rng(0))
    assert not is_free(pillars, CAR, raw).all()  # so there was something to avoid


def test_nobody_is_put_behind_a_thin_wall():
    poses = np.tile([4.6, 5.0, np.pi / 2], (200, 1))
    moved, found = perturbed(halves(), poses, WIDE, np.random.default_rng(0))
    assert found.all()
    assert (moved[:, 0] < 5.0).all()
    assert (WIDE.apply(poses, np.random.default_rng(0))[:, 0] > 5.2).any()


def test_a_pose_without_a_free_place_stays_and_is_reported():
    corridor = Scene(make_box(10.0, 0.3))  # the car is 0.24 m wide and as good as never fits
    poses = np.tile([[5.0, 0.15, np.pi / 2]], (20, 1))
    kept = poses.copy()
    moved, found = perturbed(corridor, poses, Perturbation(turn=0.01), np.random.default_rng(0))
    assert not found.any()
    assert (moved == kept).all()
    assert (poses == kept).all()


def test_a_wider_body_needs_more_room():
    corridor, broad = Scene(make_box(10.0, 2.0)), BicycleCar(width=0.7)
    poses = np.tile([5.0, 1.0, 0.0], (100, 1))
    perturbation = Perturbation(aside=0.6, turn=0.01)
    for body in (CAR, broad):
        moved, found = perturbed(corridor, poses, perturbation, np.random.default_rng(0), body)
        assert found.all()
        assert is_free(corridor, body, moved).all()
    slim = perturbed(corridor, poses, perturbation, np.random.default_rng(0))[0]
    assert not is_free(corridor, broad, slim).all()


def test_the_same_seed_perturbs_alike(pillars):
    poses = np.tile([1.0, 1.0, 0.5], (30, 1))
    one, two, other = (
        perturbed(pillars, poses, WIDE, np.random.default_rng(seed))[0] for seed in (3, 3, 4)
    )
    assert (one == two).all()
    assert (one != other).any()


# Trajectories laid end to end.


@pytest.fixture(scope="module")
def trajectories():
    """Two along lines, one that stands still for a while, and one with a single frame."""
    still = np.repeat(make_trajectory([(1.0, 9.0), (2.0, 9.0)]).poses, [1] * 20 + [30], axis=0)
    return [
        make_trajectory([(1.0, 1.0), (7.0, 1.0), (7.0, 4.0)]),
        make_trajectory([(1.0, 6.0), (4.5, 6.0)], step=0.07),
        trajectory_of(still),
        trajectory_of([[5.0, 5.0, 0.0]]),
    ]


@pytest.fixture
def laid(box, trajectories):
    return RecordedWorld(box, trajectories)


def test_trajectories_lie_end_to_end(laid, trajectories):
    bounds = np.cumsum([0, *map(len, trajectories)])
    for number, trajectory in enumerate(trajectories):
        some = slice(bounds[number], bounds[number + 1])
        assert (laid.poses[some] == trajectory.poses).all()
        assert (laid.first[some] == bounds[number]).all()
        assert (laid.last[some] == bounds[number + 1] - 1).all()
        assert laid.arc[some] - laid.arc[some][0] == pytest.approx(trajectory.arc_length)
        assert laid.frames_of(number).tolist() == [*range(bounds[number], bounds[number + 1])]
    assert laid.first_frames.tolist() == bounds[:-1].tolist() == np.unique(laid.first).tolist()
    assert (np.diff(laid.arc) >= 0).all()
    assert (np.diff(laid.arc)[np.diff(laid.first) > 0] > BEHIND + AHEAD).all()


@given(st.integers(0, 10**6), st.floats(-12.0, 12.0))
@settings(deadline=None)
def test_the_frame_ahead_is_the_first_so_far_along_its_own_trajectory(recorded, number, ahead):
    frame = number % len(recorded.poses)
    found = recorded.frame_at(np.array([frame]), np.array([ahead]))[0]
    first, last = recorded.first[frame], recorded.last[frame]
    arc = recorded.arc[first : last + 1]
    beyond = [i for i in range(first, last + 1) if arc[i - first] >= recorded.arc[frame] + ahead]
    assert found == (beyond[0] if beyond else last)


def test_frames_ahead_of_all_frames_stay_within_their_trajectories(laid):
    frames = np.arange(len(laid.poses))
    for ahead, wanted in ((-50.0, laid.first), (50.0, laid.last)):
        assert (laid.frame_at(frames, np.full(len(frames), ahead)) == wanted).all()


def test_drawn_targets_are_1_m_behind_to_3_m_ahead_on_the_same_trajectory(recorded):
    starts, targets = recorded.draw(500, 3, np.random.default_rng(0))
    assert starts.shape == (1500,)
    assert targets.shape == (500,)
    goals = np.repeat(targets, 3)
    assert (recorded.first[starts] == recorded.first[goals]).all()
    ahead = recorded.arc[goals] - recorded.arc[starts]
    frame = max(np.diff(trajectory.arc_length).max() for trajectory in recorded.trajectories)
    assert -1.0 - frame <= ahead.min() < -0.9
    assert 2.9 < ahead.max() <= 3.0 + 1e-9
    middle = (recorded.first[goals] + 60 < goals) & (goals < recorded.last[goals] - 30)
    assert ahead[middle].mean() == pytest.approx(1.0, abs=0.15)  # uniform, away from the ends
    assert len(np.unique(recorded.first[targets])) == len(recorded.trajectories)


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_a_share_of_the_pairs_is_close(recorded, share):
    starts, targets = recorded.draw(800, 1, np.random.default_rng(0), close=share)
    ahead = recorded.arc[targets] - recorded.arc[starts]
    frame = max(np.diff(trajectory.arc_length).max() for trajectory in recorded.trajectories)
    near = (ahead >= -CLOSE - frame) & (ahead <= CLOSE)
    assert near.mean() == pytest.approx(share + (1 - share) * 2 * CLOSE / 4.0, abs=0.07)
    assert (recorded.first[starts] == recorded.first[targets]).all()


def test_the_same_seed_draws_the_same_frames(recorded):
    one, two, other = (recorded.draw(50, 2, np.random.default_rng(seed)) for seed in (5, 5, 6))
    for mine, theirs, unlike in zip(one, two, other, strict=True):
        assert (mine == theirs).all()
        assert (mine != unlike).any()


@pytest.mark.parametrize("k", [0, 1, 2, 5])
def test_a_context_is_that_of_its_own_trajectory(recorded, k):
    frames = np.arange(len(recorded.poses))
    found = recorded.context(frames, k)
    assert found.shape == (len(frames), 2 * k + 1)
    for frame, row in zip(frames.tolist(), found.tolist(), strict=True):
        first, last = recorded.first[frame], recorded.last[frame]
        assert row == [min(max(frame + 3 * j, first), last) for j in range(-k, k + 1)]


@pytest.mark.parametrize(
    ("frames", "k", "words"),
    [
        ([0], -1, "k: -1; give one whole number"),
        ([-1], 1, "frames: -1; give whole numbers from 0 to"),
        ([10**9], 1, "frames: 1000000000; give whole numbers from 0 to"),
        ([1.5], 1, "whole numbers"),
        ([[1, 2]], 1, r"\(N,\)"),
        ([0], 400, "k: 400 needs a trajectory of 2401 frames"),
    ],
)
def test_no_context_of_what_was_not_recorded(recorded, frames, k, words):
    with pytest.raises(InputError, match=words):
        recorded.context(np.array(frames), k)


def test_without_a_trajectory_there_is_nothing_to_draw(box):
    with pytest.raises(InputError, match="trajectories: there are none"):
        RecordedWorld(box, [])


# Episodes.


@pytest.fixture(scope="module")
def paths(recorded):
    return GridPaths(recorded.scene.clearance)


@pytest.fixture(scope="module")
def episodes(recorded, paths):
    return draw_episodes(recorded, paths, 120, np.random.default_rng(0))


def test_episodes_start_where_a_car_can_and_not_at_their_target(recorded, episodes):
    assert len(episodes) == len(episodes.targets) == len(episodes.ahead) == 120
    assert is_free(recorded.scene, CAR, episodes.starts).all()
    gap = np.hypot(*(episodes.starts - episodes.goals)[:, :2].T)
    assert gap.min() >= 0.30
    assert (episodes.goals == recorded.poses[episodes.targets]).all()


def test_episodes_know_how_far_ahead_their_targets_are(recorded, episodes):
    assert -1.1 <= episodes.ahead.min() < -0.5
    assert 2.5 < episodes.ahead.max() <= 3.0 + 1e-9
    # The source lies abeam of the start, `ahead` metres of the trajectory before the target.
    sources = recorded.frame_at(episodes.targets, -episodes.ahead - 1e-9)
    local = relative(recorded.poses[sources], episodes.starts)
    assert local[:, 0] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(local[:, 1]).max() <= PAPER_PERTURBATION.most
    assert 0.1 < np.abs(local[:, 1]).mean() < 0.4


def test_episodes_may_take_as_long_as_their_geodesics_allow(paths, episodes):
    wanted = geodesic_limit(paths, episodes.starts, episodes.goals[:, :2])
    assert episodes.limit == pytest.approx(wanted)


def test_episodes_are_the_same_however_many_fields_are_made_at_once(
    recorded, paths, episodes, monkeypatch
):
    monkeypatch.setattr(geodesics, "_AT_ONCE", 7)
    again = draw_episodes(recorded, paths, 120, np.random.default_rng(0))
    for name in ("starts", "targets", "ahead", "limit"):
        assert (getattr(again, name) == getattr(episodes, name)).all()
    other = draw_episodes(recorded, paths, 120, np.random.default_rng(1))
    assert (other.starts != episodes.starts).any()


def test_episodes_can_be_long_ones_only(recorded, paths):
    long = draw_episodes(recorded, paths, 40, np.random.default_rng(0), least=1.8)
    assert long.ahead.min() >= 1.8
    assert long.ahead.max() > 2.8
    gap = np.hypot(*(long.starts - long.goals)[:, :2].T)
    assert gap.min() >= 0.30
    assert is_free(recorded.scene, CAR, long.starts).all()


def test_where_nobody_can_start_there_are_no_episodes():
    # Shifted by 0.23 m at most, all starts are nearer than 0.30 m to the only place.
    corridor = Scene(make_box(10.0, 0.7))
    standing = trajectory_of(np.tile([5.0, 0.35, 0.0], (40, 1)))
    recorded = RecordedWorld(corridor, [standing])
    with pytest.raises(InputError, match="only 0 of 5"):
        draw_episodes(recorded, GridPaths(corridor.clearance), 5, np.random.default_rng(0))


def test_some_episodes_in_another_world(recorded, episodes):
    some = episodes.subset(np.array([7, 3]))
    assert len(some) == 2
    assert (some.starts == episodes.starts[[7, 3]]).all()
    assert (some.limit == episodes.limit[[7, 3]]).all()
    shifted = RecordedWorld(scene_of("office/1/shifted"), recorded.trajectories)
    there = some.within(shifted)
    assert there.recorded is shifted
    assert some.recorded is recorded
    for name in ("starts", "targets", "ahead", "limit", "goals"):
        assert (getattr(there, name) == getattr(some, name)).all()


# Obstacles.


@pytest.fixture(scope="module")
def far(recorded):
    """Episodes of 2.5 m to 5 m, which more often have room for two obstacles."""
    rng = np.random.default_rng(0)
    targets = rng.integers(len(recorded.poses), size=150)
    sources = recorded.frame_at(targets, -rng.uniform(2.5, 5.0, 150))
    starts, found = perturbed(recorded.scene, recorded.poses[sources], PAPER_PERTURBATION, rng)
    ahead = recorded.arc[targets] - recorded.arc[sources]
    limit = np.arange(150.0)
    return Episodes(recorded, starts, targets, ahead, limit).subset(np.flatnonzero(found))


@pytest.fixture(scope="module")
def course(far):
    return with_obstacles(far, 2, 15, np.random.default_rng(0))


def places_of(obstacles, robot):
    return np.array([person.route[0] for person in obstacles if person.owner == robot])


def test_each_robot_has_its_obstacles(far, course):
    blocked, obstacles = course
    assert len(blocked) == 15
    assert [person.owner for person in obstacles] == np.repeat(np.arange(15), 2).tolist()
    assert {person.radius for person in obstacles} == {RADIUS}
    assert all(len(person.route) == 1 for person in obstacles)  # they stand
    rows = [np.flatnonzero((far.starts == start).all(axis=1))[0] for start in blocked.starts]
    assert rows == sorted(set(rows))
    assert (blocked.limit == far.limit[rows]).all()
    assert (blocked.targets == far.targets[rows]).all()


def test_obstacles_block_the_path_and_keep_their_distances(course):
    blocked, obstacles = course
    for robot, (start, goal) in enumerate(zip(blocked.starts, blocked.goals, strict=True)):
        places = places_of(obstacles, robot)
        assert np.hypot(*(places - start[:2]).T).min() >= 0.75
        assert np.hypot(*(places - goal[:2]).T).min() >= 0.6
        assert np.hypot(*(places[0] - places[1])) >= 2 * RADIUS
        apart = distance_to_segments(places, [[*start[:2], *goal[:2]]])
        assert apart.max() <= 0.3 + 1e-9


def room_beside(walls, place, aside):
    """Metres from an obstacle's edge to the next wall in one direction, at most 1.5."""
    steps = np.arange(0.0, 1.5, 0.01)
    line = place + (RADIUS + steps)[:, None] * aside
    gap = distance_to_segments(line, walls).min(axis=1)
    touched = np.flatnonzero(gap < 0.02)
    return steps[touched[0]] if touched.size else 1.5


def test_a_passage_remains_beside_every_obstacle(recorded, course):
    blocked, obstacles = course
    walls = recorded.scene.plan.segments
    for robot, (start, goal) in enumerate(zip(blocked.starts, blocked.goals, strict=True)):
        along = (goal - start)[:2] / np.hypot(*(goal - start)[:2])
        aside = np.array([-along[1], along[0]])
        for place in places_of(obstacles, robot):
            room = [room_beside(walls, place, side * aside) for side in (1, -1)]
            assert max(room) >= PASSED_AT + CLEAR - 0.06  # a cell of the grid


def test_an_obstacle_exists_for_its_robot_alone(recorded, course):
    blocked, obstacles = course
    together = Simulation(recorded.scene, blocked.starts, people=obstacles).observe()
    empty = Simulation(recorded.scene, blocked.starts).observe()
    for robot in range(4):
        own = [replace(person, owner=0) for person in obstacles if person.owner == robot]
        alone = Simulation(recorded.scene, blocked.starts[[robot]], people=own).observe()
        assert (together.laser[robot] == alone.laser[0]).all()
        assert (together.image[robot] == alone.image[0]).all()
    nearer = (together.laser < empty.laser - 1e-9).any(axis=1)
    assert nearer.mean() > 0.8


def corridor_episodes(width, count=10):
    """Episodes along a corridor, 3 m each."""
    recorded = RecordedWorld(
        Scene(make_box(12.0, width)), [make_trajectory([(1.0, width / 2), (11.0, width / 2)])]
    )
    starts = recorded.poses[np.arange(count) * 10]
    targets = np.arange(count) * 10 + 60
    return Episodes(recorded, starts, targets, np.full(count, 3.0), np.full(count, 15.0))


def test_where_no_passage_would_remain_no_obstacle_is_put():
    rng = np.random.default_rng(0)
    blocked, obstacles = with_obstacles(corridor_episodes(0.75), 1, 10, rng)
    assert len(blocked) == 0
    assert obstacles == []
    blocked, obstacles = with_obstacles(corridor_episodes(2.0), 1, 10, rng)
    assert len(blocked) == len(obstacles) == 10


def test_too_near_a_target_leaves_no_room_for_obstacles():
    near = corridor_episodes(2.0)
    near = replace(near, targets=near.targets - 60 + 26)  # 1.3 m away
    assert len(with_obstacles(near, 1, 10, np.random.default_rng(0))[0]) == 0


@pytest.mark.full
def test_obstacles_are_the_same_for_the_same_seed(far, course):
    again = with_obstacles(far, 2, 15, np.random.default_rng(0))[1]
    assert np.array_equal([p.route for p in again], [p.route for p in course[1]])
    other = with_obstacles(far, 2, 15, np.random.default_rng(1))[1]
    assert not np.array_equal([p.route for p in other], [p.route for p in course[1]])
