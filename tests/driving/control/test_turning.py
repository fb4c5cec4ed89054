"""Driving to waypoints with three-point turns: what is behind, and narrow places."""

import numpy as np
import pytest

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.turning import TurningController
from tutorial_lib.se2 import to_local
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import scene_of

CAR = np.array([0])


def driven(simulation, place, seconds, control=None):
    """Poses (T, 3) of a car that is sent to a place, until it is within 0.3 m of it."""
    control, poses = TurningController(1) if control is None else control, []
    for _ in range(round(seconds * 10)):
        seen = simulation.observe()
        waypoints = to_local(seen.odometry, np.array([place]))
        simulation.step(control.act(seen, CAR, waypoints))
        poses.append(simulation.poses[0])
        if np.linalg.norm(waypoints) < 0.3:
            break
    return np.array(poses)


def test_it_drives_as_rmp_does_to_what_is_ahead(box):
    simulation = Simulation(box, [[3.0, 5.0, 0.0]])
    seen, waypoints = simulation.observe(), np.array([[2.0, 0.5]])
    assert (
        TurningController(1).act(seen, CAR, waypoints) == RMPController().act(seen, waypoints)
    ).all()


def test_it_turns_in_place_to_what_is_behind(box):
    simulation = Simulation(box, [[5.0, 5.0, 0.0]])
    poses = driven(simulation, [-3.0, 0.5], 30.0)
    ahead = np.cos(poses[:, 2]) * -1.0 > 0.87  # within 30 degrees of where it goes
    turned = int(ahead.argmax())
    assert ahead[turned]
    assert np.abs(poses[: turned + 1, :2] - [5.0, 5.0]).max() < 0.9
    assert np.linalg.norm(poses[-1, :2] - [2.0, 5.5]) < 0.4
    assert not simulation.collided[0]


def test_it_does_not_turn_for_what_is_beside_its_axle(box):
    simulation = Simulation(box, [[5.0, 5.0, 0.0]])
    control = TurningController(1)
    seen, waypoints = simulation.observe(), np.array([[-0.15, 0.05]])
    assert (control.act(seen, CAR, waypoints) == RMPController().act(seen, waypoints)).all()


@pytest.mark.full
def test_cars_that_came_to_a_stand_get_to_what_is_near():
    # In narrow rooms; without a turn each of them stands there for ever.
    scene = scene_of("office/10101/standard")
    starts = np.array(
        [
            [4.757, -16.06, -0.118],
            [-2.243, -0.66, -0.865],
            [-2.843, -7.26, 0.405],
            [-2.343, -11.16, 0.467],
            [2.957, -12.46, 0.556],
        ]
    )
    places = [[4.157, -16.96], [-3.243, -0.36], [-3.443, -7.76], [-2.943, -11.26], [2.557, -12.96]]
    for start, place in zip(starts, np.array(places), strict=True):
        simulation = Simulation(scene, start)
        poses = driven(simulation, to_local(start, place), 40.0)
        assert np.linalg.norm(poses[-1, :2] - place) < 0.31
        assert not simulation.collided[0]


def test_cars_of_a_fleet_turn_each_for_itself(box):
    poses = np.array([[3.0, 5.0, 0.0], [7.0, 5.0, 0.0], [5.0, 3.0, 1.0]])
    places, both = np.array([[-2.0, 0.5], [2.0, 0.0], [-1.5, -1.0]]), []
    for robots in (np.arange(3), np.array([0, 2])):
        simulation, control = Simulation(box, poses[robots]), TurningController(len(robots))
        for _ in range(80):
            seen = simulation.observe()
            waypoints = to_local(seen.odometry, places[robots])
            simulation.step(control.act(seen, np.arange(len(robots)), waypoints))
        both.append(simulation.poses)
    assert np.allclose(both[0][[0, 2]], both[1], atol=1e-12)
