"""A controller drives the body that the robots have, whichever it was made for."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving import (
    ComposedController,
    GridPaths,
    OraclePolicy,
    ReachGoals,
    RMPController,
    demonstrate,
    geodesic_limit,
    rollout,
)
from tutorial_lib.driving.control.three_point import ThreePointTurn
from tutorial_lib.errors import InputError
from tutorial_lib.world import (
    BicycleCar,
    DifferentialDrive,
    Scene,
    Simulation,
    generate,
    random_free_poses,
)

LONG = BicycleCar(wheelbase=0.5, length=0.6)


@dataclass
class Unaware:
    """A controller that is not told which body it drives."""

    controller: RMPController

    def act(self, observations, waypoints):
        return self.controller.act(replace(observations, body=None), waypoints)


@pytest.mark.parametrize(
    "body",
    [
        LONG,
        pytest.param(DifferentialDrive(), marks=pytest.mark.full),
        pytest.param(BicycleCar(wheelbase=0.2), marks=pytest.mark.full),
    ],
)
@pytest.mark.few(1)
def test_cars_of_another_body_reach_their_goals(body):
    scene = Scene(generate("apartment", seed=3))
    paths = GridPaths(scene.clearance)
    places, rng = paths.points[paths.largest], np.random.default_rng(0)
    starts = random_free_poses(scene, body, places, 15, rng)
    goals = places[rng.integers(len(places), size=15)]

    def driven(controller):
        simulation = Simulation(scene, starts, body=body)
        ends = ReachGoals(goals, geodesic_limit(paths, starts, goals))
        return rollout(simulation, OraclePolicy(simulation, paths, goals, controller), ends)

    for controller in (None, RMPController(body=BicycleCar())):
        found = driven(controller)
        assert not found.collided.any()
        assert found.reached.mean() >= 0.8
    if body == LONG:  # what the robots would do that are not recognised
        assert driven(Unaware(RMPController())).collided.mean() > 0.8


def test_the_action_is_that_of_a_controller_of_the_body(pillars):
    simulation = Simulation(pillars, [[2.0, 5.0, 0.0], [8.0, 2.0, 2.0]], body=LONG)
    waypoints, seen = np.array([[1.0, 0.5], [-0.5, 0.3]]), simulation.observe()
    assert seen.body == LONG
    wanted = RMPController(LONG).act(seen, waypoints)
    usual = RMPController()
    assert usual.act(seen, waypoints) == pytest.approx(wanted)
    assert usual.act(seen[1], waypoints[1:]) == pytest.approx(wanted[1:])
    assert usual.act(replace(seen, body=None), waypoints) != pytest.approx(wanted)

    class Straight:
        def predict(self, observations, targets):
            return targets, None

    composed = ComposedController(Straight(), usual)
    assert composed.act(seen, waypoints) == pytest.approx(wanted)
    assert usual.for_robots(seen).body == LONG
    assert usual.for_robots(Simulation(pillars, [[2.0, 5.0, 0.0]]).observe()) is usual


def test_an_unknown_kind_of_body_is_refused(pillars):
    class Tank:
        footprint, __hash__ = BicycleCar().footprint, None

        def respond(self, controls, wanted, seconds):
            return wanted

        def twist(self, controls):
            return np.zeros(len(controls)), 0.0, np.zeros(len(controls))

    simulation = Simulation(pillars, [[2.0, 5.0, 0.0]], body=Tank())
    with pytest.raises(InputError, match="body: a Tank is neither a BicycleCar nor a Differential"):
        RMPController().act(simulation.observe(), [[1.0, 0.0]])


@pytest.mark.parametrize("body", [LONG, DifferentialDrive()])
def test_a_turn_in_place_is_that_of_the_body(body):
    simulation = Simulation(Scene(make_box()), [[5.0, 5.0, 0.3]], body=body)
    turn, robots = ThreePointTurn(1), np.array([0])
    turn.begin(robots, simulation.odometry, np.array([np.pi]))
    turned = []
    for _ in range(160):
        action = turn.act(simulation.observe(), robots)
        assert abs(action[0, 1]) <= (body.max_turn if body != LONG else body.max_steering)
        simulation.step(action)
        turned.append(simulation.odometry[0, 2])
    assert not simulation.collided.any()
    assert np.abs(turned).max() > np.pi - 0.2
    if body != LONG:
        assert simulation.poses[0, :2] == pytest.approx([5.0, 5.0], abs=1e-6)


@pytest.mark.full
def test_demonstrations_are_driven_with_a_body_of_ones_own():
    scene = Scene(generate("apartment", seed=3))
    usual, own = (demonstrate("apartment", scene, 4, 0, body=body) for body in (None, LONG))
    tightest = []
    for drives in (usual, own):
        assert len(drives) >= 2
        turns = np.concatenate([np.diff(np.unwrap(one.poses[:, 2])) for one in drives])
        metres = np.concatenate([np.diff(one.arc_length) for one in drives])
        fast = metres > 0.04
        tightest.append(np.abs(turns[fast] / metres[fast]).max())
    assert tightest[1] < 1.02 / LONG.turning_radius < tightest[0]
