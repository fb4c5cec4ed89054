import os

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.control.oracle import PARKING
from tutorial_lib.driving.data import demonstrations
from tutorial_lib.driving.data.demonstrations import (
    FARTHEST,
    NEAREST,
    SHORTEST,
    demonstrate,
    demonstrate_between,
    demonstrate_on,
    record_demonstrations,
    world_seed,
)
from tutorial_lib.driving.data.trajectories import load_trajectories, save_trajectories
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED, time_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import relative
from tutorial_lib.learning.views import CameraView
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.noise import DriftingOdometry, NoNoise
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import scene_of

WORLD = "office/1/standard"
ARRAYS = ("poses", "odometry", "laser", "speed", "steering", "actions", "timestamps")


@pytest.fixture(scope="module")
def scene():
    return scene_of(WORLD)


@pytest.fixture(scope="module")
def shown(scene):
    return demonstrate(WORLD, scene, 12, 3)


def content(trajectories):
    return [b"".join(getattr(t, name).tobytes() for name in ARRAYS) for t in trajectories]


class Blind:
    """Rollouts straight ahead, whatever is there."""

    def act(self, observations, waypoints):
        return np.tile([0.5, 0.0], (len(observations), 1))


class Noting:
    """The arc controller, which keeps what it was shown."""

    def __init__(self):
        self.seen = []

    def act(self, observations, waypoints):
        self.seen.append(observations)
        return PARKING.act(observations, waypoints)


def test_most_trajectories_arrive_and_name_their_world(shown):
    assert len(shown) >= 10
    assert {(t.world, t.seed) for t in shown} == {(WORLD, 3)}
    for t in shown:
        assert len(t) >= SHORTEST == 31
        assert t.laser.shape == (len(t), 96)
        assert t.timestamps == pytest.approx(np.arange(len(t)) * 0.1)


@pytest.mark.full
def test_the_same_seed_gives_the_same_bytes(scene, shown):
    assert content(demonstrate(WORLD, scene_of(WORLD), 12, 3)) == content(shown)
    assert content(demonstrate(WORLD, scene, 12, 4)) != content(shown)


def test_starts_and_headings_differ(shown):
    starts = np.array([t.poses[0] for t in shown])
    assert len(np.unique(starts.round(3), axis=0)) == len(shown)
    assert np.ptp(starts[:, 2]) > np.pi


def test_goals_are_neither_near_nor_beyond_reach(scene, shown):
    paths = GridPaths(scene.clearance)
    for t in shown:
        far = paths.fields(t.poses[0, :2], shortest=True).distance(t.poses[-1:, :2])[0]
        # The last frame is a step short of REACHED from the goal.
        assert NEAREST - REACHED - 0.15 <= far <= FARTHEST + REACHED + 0.15
        assert len(t) * 0.1 <= time_limit(FARTHEST)


def test_goals_are_no_farther_than_they_may_be(scene, monkeypatch):
    monkeypatch.setattr(demonstrations, "FARTHEST", 6.0)
    paths = GridPaths(scene.clearance)
    found = demonstrate(WORLD, scene, 10, 5)
    assert len(found) >= 5
    for t in found:
        far = paths.fields(t.poses[0, :2], shortest=True).distance(t.poses[-1:, :2])[0]
        assert far <= 6.0 + REACHED + 0.15


def test_nobody_drove_through_a_wall(scene, shown):
    for t in shown:
        assert is_free(scene, BicycleCar(), t.poses).all()
        assert np.diff(t.arc_length).max() < 0.081


def drift(trajectory):
    """Metres by which the odometry is off, at each frame."""
    exact = relative(trajectory.poses[0], trajectory.poses)
    return np.linalg.norm(trajectory.odometry[:, :2] - exact[:, :2], axis=1)


@pytest.mark.full
def test_odometry_is_the_pose_since_the_start_as_wheels_measure_it(scene, shown):
    exact = demonstrate(WORLD, scene, 12, 3, odometry_noise=NoNoise())
    other = demonstrate(WORLD, scene, 12, 3, odometry_noise=DriftingOdometry(4))
    for t, e, o in zip(shown, exact, other, strict=True):
        assert (t.poses == e.poses).all()
        assert (t.actions == e.actions).all()
        assert drift(e).max() < 1e-9
        assert drift(t)[0] == 0.0
        assert 0.0 < drift(t)[-1] < 0.25 * t.arc_length[-1]
        assert (o.odometry[-1] != t.odometry[-1]).all()
        moved = relative(t.poses[:-1], t.poses[1:])
        assert t.speed[1:] == pytest.approx(moved[:, 0] / 0.1, abs=1e-9)


def test_replaying_the_actions_gives_the_trajectory_again(scene, shown):
    for t in shown[:3]:
        simulation = Simulation(scene, t.poses[:1])
        for row in range(len(t)):
            seen = simulation.observe()
            assert (simulation.poses[0] == t.poses[row]).all()
            assert (seen.laser[0].astype(np.float32) == t.laser[row]).all()
            assert (seen.image[0] == CameraView().render(scene, t.poses[row])).all()
            assert seen.steering[0] == t.steering[row]
            simulation.step(t.actions[row : row + 1])
        assert not simulation.collided[0]


def test_a_row_holds_what_was_sensed_before_its_action(scene, shown):
    controller = Noting()
    again = demonstrate(WORLD, scene, 12, 3, controller)
    assert content(again) == content(shown)
    first = controller.seen[0].laser.astype(np.float32)
    for t in again:
        assert (first == t.laser[0]).all(axis=1).any()
    for t in again:
        assert t.speed[0] == t.steering[0] == 0.0
        assert t.actions[0].any()


@pytest.mark.full
def test_trajectories_with_collisions_are_dropped(scene):
    kept = demonstrate(WORLD, scene, 40, 0, Blind())
    assert len(kept) < 10
    for t in kept:
        # To arrive blindly, the goal must have been straight ahead.
        assert is_free(scene, BicycleCar(), t.poses).all()
        assert np.ptp(t.poses[:, 2]) < 1e-6
    box = Scene(make_box(12.0, 12.0))
    assert 0 < len(demonstrate("box", box, 300, 0, Blind())) < 60


def test_a_world_that_is_too_small_is_refused():
    with pytest.raises(InputError, match="larger world"):
        demonstrate("box", Scene(make_box(1.8, 1.8)), 2, 0)


def test_in_a_small_world_the_goals_are_as_far_as_they_can_be():
    for t in demonstrate("box", Scene(make_box(4.0, 4.0)), 6, 0):
        assert np.linalg.norm(t.poses[-1, :2] - t.poses[0, :2]) > 1.4


def test_the_seed_of_a_world_is_the_same_everywhere():
    assert world_seed(0, WORLD, 12) == 2733425390
    others = {world_seed(1, WORLD, 12), world_seed(0, "maze/1/standard", 12)}
    others |= {world_seed(0, WORLD, 13), world_seed(0, WORLD, 12)}
    assert len(others) == 4


WORLDS = ["office/1/standard", "maze/2/standard"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded") / "new"
    return record_demonstrations(WORLDS, 4, 7, folder, jobs=2)


@pytest.mark.full
def test_one_file_for_each_world(recorded):
    assert [path.name for path in recorded] == ["office-1-standard.npz", "maze-2-standard.npz"]
    assert sorted(os.listdir(recorded[0].parent)) == sorted(path.name for path in recorded)
    for world, path in zip(WORLDS, recorded, strict=True):
        trajectories = load_trajectories(path)
        expected = demonstrate(world, scene_of(world), 4, world_seed(7, world, 4))
        assert content(trajectories) == content(expected)
        assert {t.world for t in trajectories} == {world}


@pytest.mark.full
def test_the_number_of_processes_changes_nothing(recorded, tmp_path):
    again = record_demonstrations(WORLDS[::-1], 4, 7, tmp_path, jobs=1)
    assert [path.read_bytes() for path in again[::-1]] == [path.read_bytes() for path in recorded]


@pytest.mark.full
def test_a_recording_goes_on_where_it_stopped(recorded, tmp_path):
    kept, broken = (tmp_path / path.name for path in recorded)
    kept.write_bytes(recorded[0].read_bytes())
    os.utime(kept, (1, 1))
    broken.write_bytes(recorded[1].read_bytes()[:1000])
    assert record_demonstrations(WORLDS, 4, 7, tmp_path, jobs=1) == [kept, broken]
    assert kept.stat().st_mtime == 1
    assert broken.read_bytes() == recorded[1].read_bytes()


@pytest.mark.parametrize(("count", "seed"), [(4, 8), (3, 7)])
@pytest.mark.few(1)
def test_another_recording_is_not_mistaken_for_this_one(recorded, tmp_path, count, seed):
    mine = tmp_path / recorded[0].name
    mine.write_bytes(recorded[0].read_bytes())
    record_demonstrations(WORLDS[:1], count, seed, tmp_path, jobs=1)
    assert mine.read_bytes() != recorded[0].read_bytes()


@pytest.mark.full
def test_a_file_of_another_world_is_not_taken(recorded, tmp_path):
    mine = tmp_path / recorded[0].name
    save_trajectories(mine, load_trajectories(recorded[1]))
    record_demonstrations(WORLDS[:1], 4, 7, tmp_path, jobs=1)
    assert mine.read_bytes() == recorded[0].read_bytes()


def test_a_wrong_name_is_refused_before_anything_is_recorded(tmp_path):
    with pytest.raises(InputError, match="castle"):
        record_demonstrations([WORLDS[0], "castle/1/standard"], 4, 7, tmp_path, jobs=1)
    assert list(tmp_path.iterdir()) == []


# From given poses to given places.


@pytest.fixture(scope="module")
def trials(shown):
    """Starts and goals of recorded trajectories, and one start from which a car cannot arrive."""
    starts = np.array([trajectory.poses[0] for trajectory in shown[:4]])
    goals = np.array([trajectory.poses[-1, :2] for trajectory in shown[:4]])
    return starts, goals


def test_trajectories_lead_from_given_starts_to_given_goals(scene, shown, trials):
    starts, goals = trials
    paths = GridPaths(scene.clearance)
    found = demonstrate_between(WORLD, scene, paths, starts, goals, 77)
    assert len(found) == 4
    for trajectory, start, goal in zip(found, starts, goals, strict=True):
        assert (trajectory.world, trajectory.seed) == (WORLD, 77)
        assert (trajectory.poses[0] == start).all()
        gap = np.linalg.norm(trajectory.poses[-1, :2] - goal)
        assert REACHED <= gap < REACHED + 0.1  # a step before it is reached
        assert is_free(scene, BicycleCar(), trajectory.poses).all()
    assert {trajectory.seed for trajectory in found} == {77}


def test_a_drive_is_that_of_the_body_that_is_given():
    scene = Scene(make_box())
    where = "box", scene, GridPaths(scene.clearance)
    start, goal = np.array([[5.0, 5.0, 0.0]]), np.array([[2.0, 5.5]])  # behind it
    for body, turns_in_place in ((None, False), (DifferentialDrive(), True)):
        (between,) = demonstrate_between(*where, start, goal, 0, NoNoise(), body)
        on = demonstrate_on(*where, start, goal, 0, NoNoise(), body)
        for drive in (between, on):
            motions = relative(drive.poses[:-1], drive.poses[1:])
            tightest = np.abs(motions[:, 2]) - np.hypot(*motions[:, :2].T) / 0.6
            assert (tightest.max() > 0.02) == turns_in_place


@pytest.mark.full
def test_nothing_about_them_is_random_but_the_drift(scene, trials):
    paths = GridPaths(scene.clearance)
    one, two = (
        demonstrate_between(WORLD, scene, paths, *trials, seed, NoNoise()) for seed in (1, 2)
    )
    assert content(one) == content(two)
    one, two = (demonstrate_between(WORLD, scene, paths, *trials, seed) for seed in (1, 2))
    assert content(one) == content(demonstrate_between(WORLD, scene, paths, *trials, 1))
    assert (one[1].poses == two[1].poses).all()
    assert (one[1].odometry[-1] != two[1].odometry[-1]).all()
    for robot in range(2):
        starts, goals = (column[[robot]] for column in trials)
        (alone,) = demonstrate_between(WORLD, scene, paths, starts, goals, 1, NoNoise())
        exact = demonstrate_between(WORLD, scene, paths, *trials, 1, NoNoise())[robot]
        assert content([alone]) == content([exact])
    starts, goals = (column[[0]] for column in trials)
    (alone,) = demonstrate_between(WORLD, scene, paths, starts, goals, 1)
    assert content([alone]) == content([one[0]])


def test_a_robot_that_does_not_arrive_leaves_a_gap(monkeypatch):
    scene = Scene(make_box())
    starts = np.array([[2.0, 2.0, 0.0], [2.0, 8.0, 0.0], [5.0, 5.0, 0.0]])
    goals = np.array([[8.0, 2.0], [8.0, 5.0], [5.1, 5.0]])
    paths = GridPaths(scene.clearance)

    class Half:
        """The usual policy, but robots in the upper half drive straight at a wall."""

        def act(self, observations, waypoints):
            actions = PARKING.act(observations, waypoints)
            upper = observations.laser[:, 72] < 3.0  # to the left
            return np.where(upper[:, None], [0.5, 0.0], actions)

    monkeypatch.setattr("tutorial_lib.driving.control.oracle.PARKING", Half())
    found = demonstrate_between("box", scene, paths, starts, goals, 0)
    assert found[0] is not None
    assert found[1] is None
    # A robot that was there before the first step has not driven.
    assert found[2] is None or len(found[2]) <= 1


def test_a_goal_that_no_path_reaches_is_refused(scene, trials):
    starts, goals = trials
    paths = GridPaths(scene.clearance)
    with pytest.raises(InputError, match="goal"):
        demonstrate_between(WORLD, scene, paths, starts, goals + 1_000.0, 0)
