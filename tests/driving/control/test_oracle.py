from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.control.oracle import TURN_ROUND, OraclePolicy, TurnFirst
from tutorial_lib.driving.control.three_point import ThreePointTurn
from tutorial_lib.driving.data.demonstrations import _starts_and_goals
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import time_limit, walls_crossed
from tutorial_lib.driving.rollouts import ReachGoals, geodesic_limit, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.robustness.plans import drive_about
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.floorplan import Room
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import scene_of


def roll_out(scene, starts, goals, people=(), turn_first=False):
    paths = GridPaths(scene.clearance)
    simulation = Simulation(scene, starts, people=people)
    limit = geodesic_limit(paths, starts, goals) + TURN_ROUND * turn_first
    oracle, ends = OraclePolicy(simulation, paths, goals), ReachGoals(goals, limit)
    return rollout(simulation, TurnFirst(oracle) if turn_first else oracle, ends)


@pytest.mark.parametrize(
    "family",
    [
        pytest.param(f, marks=[] if f in ("apartment", "hall") else pytest.mark.full)
        for f in FAMILIES
    ],
)
@pytest.mark.few(2)
def test_it_drives_through_every_family(family):
    scene = Scene(generate(family, 10_100))
    paths = GridPaths(scene.clearance)
    rollouts = drive_about(scene, paths, 20, np.random.default_rng(0))
    # A scan is narrower than its building, and this is a maze; elsewhere 100 of 100 arrived.
    assert rollouts.reached.sum() >= (16 if family == "scanned" else 18)
    assert rollouts.collided.sum() == 0
    assert walls_crossed(scene.caster, rollouts.poses) == 0


def test_it_reverses_to_what_is_just_behind_it(box):
    rollouts = roll_out(box, [[5.0, 5.0, 0.0]], [[4.2, 5.0]])
    assert rollouts.reached[0]
    track = rollouts.poses[:, 0]
    assert np.abs(track[:, 2]).max() < 0.6
    assert track[:, 0].max() < 5.1


def test_it_turns_around_for_what_is_far_behind_it(box):
    rollouts = roll_out(box, [[6.0, 5.0, 0.0]], [[1.0, 5.0]])
    assert rollouts.reached[0]
    assert abs(rollouts.poses[-1, 0, 2]) > 2.0


def test_it_backs_out_of_a_dead_end():
    # A lane 0.9 m wide between two blocks, with the wall ahead: no room to turn.
    scene = Scene(make_box(pillars=[(8.2, 6.95, 1.5), (8.2, 3.05, 1.5)]))
    rollouts = roll_out(scene, [[9.2, 5.0, 0.0]], [[3.0, 5.0]])
    assert rollouts.reached[0]


def test_it_drives_around_a_person_in_its_path(box):
    rollouts = roll_out(box, [[1.5, 5.0, 0.0]], [[8.5, 5.0]], people=[Person([[5.0, 5.0]])])
    assert rollouts.reached[0]
    assert np.linalg.norm(rollouts.poses[:, 0, :2] - [5.0, 5.0], axis=1).min() > 0.18 + 0.12


def test_it_stops_at_the_goal_and_does_not_circle(box):
    simulation = Simulation(box, [[3.0, 5.0, 0.0]])
    oracle = OraclePolicy(simulation, GridPaths(box.clearance), [[6.0, 5.0]])
    for _ in range(100):
        simulation.step(oracle.act(simulation.observe(), np.array([0])))
    assert np.linalg.norm(simulation.poses[0, :2] - [6.0, 5.0]) < 0.2
    assert abs(simulation.speed[0]) < 0.01


def test_the_time_limit_is_that_of_the_paper():
    assert time_limit([0.0, 3.0]).tolist() == [5.0, 15.0]


def test_goals_that_cannot_be_reached_are_refused_at_once(box):
    paths = GridPaths(box.clearance)
    with pytest.raises(InputError, match="give as many"):
        OraclePolicy(Simulation(box, [[3, 3, 0], [6, 6, 0]]), paths, [[5.0, 5.0]])
    one, other = make_box(4.0, 4.0), make_box(6.0, 6.0)
    apart = Scene(
        replace(
            one,
            walls=np.concatenate([one.walls, other.walls + 4.2]),
            wall_materials=one.wall_materials * 2,
            wall_offsets=np.zeros(8),
            rooms=(
                *one.rooms,
                Room("office", ((4.2, 4.2), (10.2, 4.2), (10.2, 10.2), (4.2, 10.2))),
            ),
        )
    )
    with pytest.raises(InputError, match="no path leads"):
        roll_out(apart, [[2.0, 2.0, 0.0]], [[8.0, 8.0]])


@pytest.mark.full
@pytest.mark.parametrize("world", ["apartment/10003/standard/large", "maze/10007/standard/large"])
def test_cars_that_turn_first_get_out_of_narrow_places(world):
    scene = scene_of(world)
    paths, rng = GridPaths(scene.clearance), np.random.default_rng(0)
    starts, goals, _ = _starts_and_goals(scene, paths, 60, rng, BicycleCar())
    oracle = OraclePolicy(Simulation(scene, starts), paths, goals)
    starts[:, 2] += np.arctan2(*oracle.waypoints(np.arange(60)).T[::-1]) + np.pi
    free = is_free(scene, BicycleCar(), starts)
    plain, turned = (roll_out(scene, starts[free], goals[free], turn_first=i) for i in (0, 1))
    assert len(turned.ending) > 50
    assert turned.reached.sum() >= len(turned.ending) - 1
    assert plain.reached.sum() < turned.reached.sum()
    assert turned.collided.sum() == 0


def test_only_robots_whose_first_waypoint_is_behind_turn_first(box):
    starts, goals = [[2.0, 2.0, 1.2], [6.0, 5.0, 0.0]], [[8.0, 2.0], [1.0, 5.0]]
    plain, turned = (roll_out(box, starts, goals, turn_first=turn) for turn in (False, True))
    assert plain.reached.all()
    assert turned.reached.all()
    steps = min(len(plain.poses), len(turned.poses))
    assert (plain.poses[:steps, 0] == turned.poses[:steps, 0]).all()
    aside = [np.abs(one.poses[:, 1, 1] - 5.0).max() for one in (plain, turned)]
    assert aside[1] < 0.7 * aside[0]


def test_a_car_that_cannot_turn_drives_on_in_the_end(box, monkeypatch):
    monkeypatch.setattr(ThreePointTurn, "act", lambda *given: np.zeros((len(given[2]), 2)))
    rollouts = roll_out(box, [[6.0, 5.0, 0.0]], [[1.0, 5.0]], turn_first=True)
    assert rollouts.reached[0]
    assert rollouts.seconds[0] > TURN_ROUND
