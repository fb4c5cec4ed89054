from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box
from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.control.rmp import (
    RMPController,
    control_jacobian,
    goal_policy,
    heading_policy,
    obstacle_policy,
    point_jacobian,
    pull_back,
    resolve,
)
from tutorial_lib.driving.control.rmp_arcs import choose_moves, free_travel, safe_speeds
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import ReachGoals, geodesic_limit, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import relative, to_world
from tutorial_lib.interfaces import Controller
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive, advance
from tutorial_lib.world.generators import generate
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import full_circle
from tutorial_lib.world.simulation import Simulation

BODIES = [BicycleCar(), DifferentialDrive()]
OBSTACLE = {"push": 0.1, "brake": 0.2, "weight": 0.3, "fade": 0.1}
each_body = pytest.mark.parametrize("body", BODIES, ids=lambda body: type(body).__name__)


def roll_out(scene, starts, goals, body=None, people=()):
    body = BicycleCar() if body is None else body
    paths, simulation = (
        GridPaths(scene.clearance),
        Simulation(scene, starts, body=body, people=people),
    )
    oracle = OraclePolicy(simulation, paths, goals, RMPController(body=body))
    return rollout(simulation, oracle, ReachGoals(goals, geodesic_limit(paths, starts, goals)))


def observe(scene, count, rng, body=None):
    """Observations of robots anywhere, under way, and waypoints."""
    body = BicycleCar() if body is None else body
    places = np.argwhere(np.ones((9, 9))) + 0.5
    poses = random_free_poses(scene, body, places, count, rng)
    observations = Simulation(scene, poses, body=body).observe()
    moving = {"speed": rng.uniform(-0.3, 0.6, count), "steering": rng.uniform(-0.4, 0.4, count)}
    return replace(observations, **moving), rng.uniform(-2, 2, (count, 2))


@given(seed=st.integers(0, 10**6), policies=st.integers(2, 6))
@settings(max_examples=50, deadline=None)
def test_resolve_is_weighted_least_squares(seed, policies):
    rng = np.random.default_rng(seed)
    jacobians, roots = rng.normal(size=(2, policies, 2, 2))
    accelerations = rng.normal(size=(policies, 2))
    metrics = np.swapaxes(roots, 1, 2) @ roots
    forces, pulled = pull_back(jacobians, accelerations, metrics)
    found = resolve(forces.sum(0), pulled.sum(0), damping=0.04)
    rows = [*(roots @ jacobians).reshape(-1, 2), [0.2, 0.0], [0.0, 0.2]]
    wanted = [*(roots @ accelerations[..., None]).ravel(), 0.0, 0.0]
    np.testing.assert_allclose(found, np.linalg.lstsq(rows, wanted)[0], atol=1e-8)


@each_body
def test_jacobians_are_those_of_the_motion(body):
    rng = np.random.default_rng(1)
    controls, point, tiny = rng.uniform(-0.4, 0.4, (20, 2)), np.array([0.3, -0.2]), 1e-6
    found = point_jacobian(point) @ control_jacobian(body, controls)

    def velocity(controls):
        later = advance(np.zeros((20, 3)), body.twist(controls), tiny)
        return (to_world(later, point) - point) / tiny

    for column, step in enumerate(1e-3 * np.eye(2)):
        rate = (velocity(controls + step) - velocity(controls - step)) / 2e-3
        np.testing.assert_allclose(found[..., column], rate, atol=1e-4)


def test_at_rest_the_goal_pulls_straight_and_motion_is_damped():
    offsets = np.array([[3.0, 4.0], [-0.03, 0.0]])
    accelerations, metrics = goal_policy(offsets, np.zeros((2, 2)), 2.0, 4.0, 0.3)
    np.testing.assert_allclose(accelerations, [[1.2, 1.6], [-0.2, 0.0]])
    np.testing.assert_allclose(metrics, [np.eye(2)] * 2)
    np.testing.assert_allclose(goal_policy([3.0, 4.0], [0.3, 0.4], 2.0, 4.0, 0.3)[0], 0.0)


def test_obstacles_push_more_when_near_or_approaching_and_never_pull():
    push, weight = obstacle_policy([0.0, 0.1, 0.5, 2.0], 0.0, **OBSTACLE)
    assert (np.diff(push) < 0).all()
    assert (np.diff(weight) < 0).all()
    assert push[-1] > 0
    assert weight[-1] < 1e-6
    towards, still, away = obstacle_policy(0.3, np.array([0.5, 0.0, -0.5]), **OBSTACLE)[0]
    assert towards > still == away


def test_the_heading_policy_turns_to_what_is_wanted():
    rates, metrics = heading_policy([0.1, -0.2], [0.3, -0.2], 5.0, 0.7)
    np.testing.assert_allclose(rates, [1.0, 0.0])
    np.testing.assert_allclose(metrics, 0.7)


def test_free_travel_ends_where_a_small_step_more_would_touch():
    rng, angles = np.random.default_rng(3), full_circle(96)
    discs, lasers = RMPController().discs, rng.uniform(0.5, 1.5, (60, 96))
    arcs = np.stack([rng.uniform(-1.6, 1.6, 60), rng.choice([-1.0, 1.0], 60)], axis=1)
    found = free_travel(lasers, angles, arcs, discs, 0.02)[:, 0]
    for laser, (curvature, gear), free in zip(lasers, arcs, found, strict=True):
        points = laser[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        steps = np.arange(0.0, free + 0.05, 0.002)
        poses = advance(np.zeros((len(steps), 3)), [gear, gear * curvature], steps)
        local = relative(poses[:, None], np.pad(points, ((0, 0), (0, 1))))[..., None, :2]
        centres = np.stack([discs[:, 0], np.zeros(len(discs))], axis=1)
        gaps = (np.linalg.norm(local - centres, axis=-1) - discs[:, 1]).min((1, 2))
        assert gaps[steps <= free].min() > 0.02 - 1e-3
        assert gaps.min() < 0.02


@each_body
def test_a_mirrored_world_mirrors_the_steering(pillars, body):
    observations, waypoints = observe(pillars, 40, np.random.default_rng(5), body)
    controller = RMPController(body=body)
    actions = controller.act(observations, waypoints)
    flipped = replace(
        observations, laser=observations.laser[:, ::-1], steering=-observations.steering
    )
    mirrored = controller.act(flipped, waypoints * [1, -1])
    np.testing.assert_allclose(mirrored, actions * [1, -1], atol=1e-6)


@each_body
def test_a_batch_acts_as_each_robot_alone(pillars, body):
    observations, waypoints = observe(pillars, 12, np.random.default_rng(6), body)
    controller = RMPController(body=body)
    together = controller.act(observations, waypoints)
    alone = [controller.act(observations[i], waypoints[i : i + 1])[0] for i in range(12)]
    np.testing.assert_allclose(together, alone, atol=1e-9)


def test_the_car_reverses_to_what_is_just_behind_it(box):
    assert isinstance(RMPController(), Controller)
    observation = Simulation(box, [[5.0, 5.0, 0.0]]).observe()
    assert RMPController().act(observation, [[-0.5, 0.0]])[0, 0] < -0.05
    rollouts = roll_out(box, [[5.0, 5.0, 0.0]], [[4.5, 5.0]])
    assert rollouts.reached[0]
    assert np.abs(rollouts.poses[:, 0, 2]).max() < 0.2


@each_body
def test_it_reaches_what_lies_all_around_it(box, body):
    angles = np.arange(24) * np.pi / 12
    goals = [5.0, 5.0] + np.repeat([0.5, 1.0], 12)[:, None] * np.column_stack(
        [np.cos(angles), np.sin(angles)]
    )
    assert roll_out(box, np.tile([5.0, 5.0, 0.0], (24, 1)), goals, body).reached.all()


def test_it_stops_before_a_wall_and_when_boxed_in(box):
    observation = Simulation(box, [[5.0, 5.0, 0.0]]).observe()
    fast = replace(observation, speed=np.array([0.6]), laser=np.full((1, 96), 0.45))
    assert RMPController().act(fast, [[2.0, 0.0]])[0, 0] < 0.4
    shut = replace(observation, laser=np.full((1, 96), 0.15))
    assert RMPController().act(shut, [[2.0, 0.0]])[0, 0] == 0.0


@each_body
def test_it_drives_around_a_person_in_its_path(body):
    scene = Scene(make_box())
    rollouts = roll_out(scene, [[2.0, 5.0, 0.0]], [[8.0, 5.0]], body, [Person([[5.0, 5.0]])])
    assert rollouts.reached[0]


@each_body
@pytest.mark.parametrize("family", ["apartment", pytest.param("maze", marks=pytest.mark.full)])
@pytest.mark.few(2)
def test_it_drives_through_a_plan(family, body):
    scene, rng = Scene(generate(family, 10_050)), np.random.default_rng(0)
    paths = GridPaths(scene.clearance)
    places = paths.points[paths.largest]
    starts = random_free_poses(scene, body, places, 20, rng)
    rollouts = roll_out(scene, starts, places[rng.integers(len(places), size=20)], body)
    assert rollouts.reached.mean() >= 0.95
    assert rollouts.collided.sum() == 0


def test_no_action_follows_from_a_speed_that_is_none(box):
    seen = Simulation(box, [[3, 3, 0]]).observe()
    with pytest.raises(InputError, match="observations: nan; give finite"):
        RMPController().act(replace(seen, speed=np.array([np.nan])), [[1.0, 0.0]])


@pytest.mark.parametrize("waypoints", [[[1.0, 0.0]], [[np.nan, 0.0], [1.0, 1.0]]])
def test_waypoints_that_are_none_are_refused(box, waypoints):
    observations = Simulation(box, [[3, 3, 0], [6, 6, 0]]).observe()
    with pytest.raises(InputError, match=r"waypoints: .*give (finite|.*for 2 robots)"):
        RMPController().act(observations, waypoints)


def test_a_car_slows_down_while_its_wheels_turn(box):
    controller, beside = RMPController(), [[0.6, 0.6]]
    still = Simulation(box, [[5.0, 5.0, 0.0]]).observe()
    before = controller.act(still, beside)[0]
    assert before[0] == 0.0
    assert before[1] > 0.12
    moving, slowed = replace(still, speed=np.array([0.5])), []
    for aside in np.linspace(-0.7, 0.7, 36):
        speed, steering = controller.act(moving, [[1.0, aside]])[0]
        slowed.append(abs(steering) > 0.12)
        assert (speed == pytest.approx(0.7 * 0.5)) == slowed[-1]
    assert 0 < np.mean(slowed) < 1
    # With its wheels turned it sets off.
    turned = replace(still, steering=np.array([0.45]))
    assert controller.act(turned, beside)[0, 0] > 0.1


def test_the_safe_speed_is_that_from_which_it_can_stop_where_it_should():
    lasers, left = np.full((4, 96), 10.0), np.array([0.05, 0.2, 0.5, 1.0])
    arcs = np.tile([0.0, 1.0], (4, 1))
    taste = {"braking": 0.7, "reserve": 0.02, "crawl": 0.2, "hurry": 3.0}
    speeds = safe_speeds(lasers, arcs, RMPController().discs, 0.03, left, **taste)
    assert speeds**2 / (2 * 0.7) == pytest.approx(left)
    # A wall 1 m ahead: it stops `reserve` before it would be too near.
    lasers = 1.0 / np.maximum(np.cos(full_circle(96)), 1e-3)[None]
    free = free_travel(lasers, full_circle(96), arcs[:1], RMPController().discs, 0.03)[0, 0]
    speed = safe_speeds(lasers, arcs[:1], RMPController().discs, 0.03, left[3:] + 9, **taste)[0]
    assert speed**2 / (2 * 0.7) == pytest.approx(free - 0.02)


def test_a_car_that_backs_up_goes_on_until_the_waypoint_is_well_within_its_arc():
    controller, radius = RMPController(), BicycleCar().turning_radius
    taste = (controller.reverse_cost, controller.turn_cost, controller.go_on, controller.begin)
    limits = np.array([radius, *taste, 0.2])
    for miss, gears in ((0.25, [-1, -1]), (0.15, [1, -1]), (0.05, [1, 1])):
        # So far inside of its tightest circle, at rest and in reverse.
        waypoint = [(radius - miss) * np.sin(1.2), radius - (radius - miss) * np.cos(1.2)]
        lasers, speeds = np.full((2, 96), 10.0), np.array([0.0, -0.2])
        room = (controller.discs, controller.margin)
        waypoints = np.array([waypoint, waypoint])
        arcs = choose_moves(lasers, full_circle(96), waypoints, speeds, *room, limits)
        assert arcs[:, 1].tolist() == gears


def test_a_car_at_rest_beside_a_wall_steers_away_from_it(box):
    observations = Simulation(box, [[5.0, 9.72, 0.0], [5.0, 5.0, 0.0], [5.0, 0.28, 0.0]]).observe()
    steerings = RMPController().act(observations, [[2.0, 0.0]] * 3)[:, 1]
    assert steerings[0] < -0.01
    assert steerings[1] == pytest.approx(0.0, abs=1e-6)
    assert steerings[2] == pytest.approx(-steerings[0], abs=1e-6)
