"""Buildings that change: which doors close and open, and what furniture is moved."""

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.race.changes import MOVED, ChangingTask, changed
from tutorial_lib.experiments.race.ten_visits import Settings, draw_lives
from tutorial_lib.exploration.episodes import Episodes, exploration_world
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.noise import FORWARD
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of


def stops_in(scene, seed):
    goals, carries = draw_lives(scene, Settings(lives=2, visits=4), np.random.default_rng(seed))
    return np.concatenate([carries[:1], goals])[..., :2]


@pytest.fixture(scope="module")
def office():
    scene = scene_of(exploration_world(10_007))
    stops = stops_in(scene, 1)
    return scene, stops, *changed(scene, stops, np.random.default_rng(2))


def metres(scene, stops):
    legs = stops[:-1].reshape(-1, 2), stops[1:].reshape(-1, 2)
    return GridPaths(scene.clearance).between(*legs)


def clear_of(scene, door):
    return scene.clearance.at(np.add(door.start, door.end) / 2)


def test_one_door_closes_and_another_opens(office):
    scene, _, before, after = office
    shut = [
        {i for i, door in enumerate(scene.plan.doors) if clear_of(some, door) == 0}
        for some in (scene, before, after)
    ]
    assert shut[0] == set()
    assert len(shut[1]) == len(shut[2]) == 1
    assert shut[1] != shut[2]


def test_all_stops_stay_free_and_in_reach_by_a_detour(office):
    scene, stops, before, after = office
    for some in (before, after):
        assert np.isfinite(metres(some, stops)).all()
        assert (some.clearance.at(stops) > 0.25).all()
    assert metres(after, stops).sum() > metres(scene, stops).sum() + 1.0


def test_a_fifth_of_the_furniture_is_moved_within_its_rooms(office):
    scene, _, before, after = office
    pieces = zip(before.plan.furniture[:-1], after.plan.furniture[:-1], strict=True)
    moved = [(old, new) for old, new in pieces if old.outline != new.outline]
    assert 0.5 * MOVED < len(moved) / len(scene.plan.furniture) <= MOVED + 0.02
    for old, new in moved:
        room = next(r for r in scene.plan.rooms if r.contains(np.mean(old.outline, axis=0)))
        assert room.contains(new.outline).all()


def test_the_same_seed_changes_it_the_same(office):
    scene, stops, before, after = office
    again = changed(scene, stops, np.random.default_rng(2))
    for one, other in zip((before, after), again, strict=True):
        assert one.plan.furniture == other.plan.furniture


def test_a_building_without_a_detour_does_not_change():
    scene = scene_of(exploration_world(10_004))
    assert changed(scene, stops_in(scene, 1), np.random.default_rng(0)) is None


def test_a_robot_in_the_way_is_pushed_aside_unnoticed_and_the_others_see_the_change():
    scene = Scene(make_box(40.0, 40.0))
    starts = np.array([[20.0, 20.0, 0.3], [10.0, 20.0, 0.0]])
    goals, far = np.tile([30.0, 20.0, 0.0], (2, 1)), np.array([10.0, 20.0])
    episodes = Episodes(("hall",) * 2, starts, goals, far, ("",) * 2)
    task = ChangingTask({"hall": scene}, episodes, np.random.default_rng(0), noise=False)
    seen = task.observe()
    task.rebuild(Scene(make_box(40.0, 40.0, pillars=[(20.0, 20.0, 1.0)])))
    moved = np.linalg.norm(task.poses[:, :2] - starts[:, :2], axis=1)
    assert 1.0 + DifferentialDrive.radius - 0.1 < moved[0] < 1.6
    assert moved[1] == 0.0
    now = task.observe()
    assert np.array_equal(now.odometry, seen.odometry)
    assert not np.array_equal(now.depth[1], seen.depth[1])
    for _ in range(60):
        task.step([FORWARD, FORWARD])
    assert task.poses[1, 0] < 19.0 - DifferentialDrive.radius + 0.02  # stopped by the pillar
