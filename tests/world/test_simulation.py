import copy
import pickle
from functools import cache

import joblib
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import relative, to_world
from tutorial_lib.interfaces import Observation
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive, advance
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.interaction import robot_discs
from tutorial_lib.world.noise import (
    DriftingOdometry,
    WheelOdometry,
)
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.raycast import Fan, Raycaster
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Laser, full_circle
from tutorial_lib.world.simulation import Sensors, Simulation


def act_for(simulation, action, steps):
    actions = np.tile(action, (len(simulation), 1))
    for _ in range(steps):
        simulation.step(actions)
    return simulation


def free_poses(scene, count, seed):
    rng, poses = np.random.default_rng(seed), np.empty((0, 3))
    x0, y0, x1, y1 = scene.plan.bounds
    while len(poses) < count:
        tries = rng.uniform([x0, y0, -np.pi], [x1, y1, np.pi], (500, 3))
        poses = np.concatenate([poses, tries[is_free(scene, BicycleCar(), tries)]])
    return poses[:count]


def test_a_free_car_follows_its_model(box):
    car = BicycleCar()
    simulation = act_for(Simulation(box, [[5.0, 3.0, 0.3]]), [0.6, 0.2], 60)
    before, start = simulation.poses[0], simulation.seconds
    act_for(simulation, [0.6, 0.2], 40)
    twist = car.twist(np.array([[0.6, 0.2]]))[0]
    expected = advance(before, twist, simulation.seconds - start)
    assert np.allclose(relative(expected, simulation.poses[0]), 0, atol=2e-3)
    assert simulation.speed[0] == pytest.approx(0.6, abs=1e-3)
    assert not simulation.collided[0]


@pytest.mark.parametrize("action", [[0.8, 0.0], [0.8, 0.1], [0.8, 0.45], [-0.3, 0.0], [-0.3, -0.4]])
def test_walls_stop_the_car_in_either_direction(pillars, action):
    poses = free_poses(pillars, 40, seed=0)
    simulation = Simulation(pillars, poses)
    deepest = 0.0
    for _ in range(150):
        before = simulation.poses
        simulation.step(np.tile(action, (40, 1)))
        corners = to_world(simulation.poses[:, None], simulation.body.footprint).reshape(-1, 2)
        beyond = np.maximum(-corners, corners - 10.0).max()
        deepest = max(deepest, beyond)
        assert pillars.caster.sees(before[:, :2], simulation.poses[:, :2]).all()
    assert deepest < 0.02
    assert simulation.collided.sum() > 10
    assert np.isfinite(simulation.poses).all()


def test_a_car_against_the_wall_touches_stands_and_can_leave(box):
    simulation = act_for(Simulation(box, [[8.5, 5.0, 0.0]]), [0.8, 0.0], 60)
    assert simulation.touching[0]
    assert simulation.collided[0]
    assert abs(simulation.speed[0]) < 0.02
    assert simulation.poses[0, 0] == pytest.approx(10 - 0.36, abs=0.01)
    act_for(simulation, [-0.3, 0.0], 30)
    assert not simulation.touching[0]
    assert simulation.collided[0]


def test_a_fleet_drives_as_each_car_alone(pillars):
    poses = free_poses(pillars, 12, seed=1)
    rng = np.random.default_rng(2)
    actions = np.column_stack([rng.uniform(-0.3, 0.8, 12), rng.uniform(-0.45, 0.45, 12)])
    fleet = Simulation(pillars, poses)
    alone = [Simulation(pillars, pose) for pose in poses]
    for _ in range(80):
        fleet.step(actions)
        for single, action in zip(alone, actions, strict=True):
            single.step(action[None])
    assert np.abs(fleet.poses - np.concatenate([s.poses for s in alone])).max() < 1e-9
    assert (fleet.collided == np.concatenate([s.collided for s in alone])).all()


def test_an_obstacle_of_one_robot_does_not_exist_for_the_others(box):
    starts = np.tile([4.0, 5.0, 0.0], (2, 1))
    obstacle = Person([[6.0, 5.0]], owner=1)
    simulation = Simulation(box, starts, people=[obstacle])
    depth = box.caster.cast(simulation.poses, simulation.sensors.camera.fan, simulation.discs)
    assert depth.distance[0, 32] > 5.0
    assert depth.distance[1, 32] < 2.0
    act_for(simulation, [0.8, 0.0], 40)
    assert simulation.collided.tolist() == [False, True]
    assert simulation.poses[0, 0] > 6.5
    assert simulation.poses[1, 0] < 5.6


def test_people_walk_to_and_fro_and_wait_for_robots(box):
    person = Person([[2.0, 2.0], [2.0, 6.0]], speed=0.5)
    simulation = Simulation(box, [[8.0, 8.0, 0.0]], people=[person])
    seen = []
    for _ in range(170):
        simulation.step([[0.0, 0.0]])
        seen.append(simulation.crowd.positions[0, 1])
    assert max(seen) == pytest.approx(6.0, abs=0.1)
    assert min(seen[120:]) == pytest.approx(2.0, abs=0.3)
    blocked = Simulation(box, [[2.0, 4.0, 0.0]], people=[person])
    for _ in range(100):
        blocked.step([[0.0, 0.0]])
        assert blocked.crowd.positions[0, 1] < 3.0
    assert not blocked.collided[0]


@pytest.mark.full
def test_noise_scales_the_controls_and_repeats_with_its_seed(box):
    starts = np.tile([2.0, 5.0, 0.0], (300, 1))

    def ends(seed, sigma):
        rng = np.random.default_rng(seed)
        simulation = Simulation(box, starts, control_noise=sigma, rng=rng)
        return act_for(simulation, [0.4, 0.1], 50).poses

    assert (ends(1, 0.33) == ends(1, 0.33)).all()
    assert not (ends(1, 0.33) == ends(2, 0.33)).all()
    assert ends(1, 0.0).std(axis=0).max() < 1e-12
    noisy, exact = ends(1, 0.33), ends(1, 0.0)
    assert noisy[:, :2].std(axis=0).min() > 0.01
    assert np.allclose(noisy[:, 0].mean(), exact[0, 0], atol=0.05)


def test_odometry_is_exact_without_noise_and_drifts_with_it(box):
    starts = np.tile([5.0, 5.0, 1.0], (200, 1))
    exact = act_for(Simulation(box, starts), [0.5, 0.3], 60)
    assert np.allclose(exact.odometry, relative(starts, exact.poses), atol=1e-9)
    rng = np.random.default_rng(0)
    noisy = Simulation(box, starts, odometry_noise=WheelOdometry(), rng=rng)
    act_for(noisy, [0.5, 0.3], 20)
    early = np.abs(noisy.odometry - relative(starts, noisy.poses))[:, :2].mean()
    act_for(noisy, [0.5, 0.3], 60)
    late = np.abs(noisy.odometry - relative(starts, noisy.poses))[:, :2].mean()
    assert 0 < early < late < 0.5


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
def test_the_same_seed_gives_the_same_episode(family):
    def episode():
        scene = Scene(generate(family, 7))
        poses = free_poses(scene, 3, seed=5)
        rng = np.random.default_rng(9)
        people = [Person([poses[0, :2] + 1.5, poses[0, :2] + 2.5])]
        simulation = Simulation(
            scene,
            poses,
            people=people,
            control_noise=0.33,
            odometry_noise=WheelOdometry(),
            rng=rng,
        )
        seen = [act_for(simulation, [0.5, 0.2], 10).observe() for _ in range(4)]
        return b"".join(o.image.tobytes() + o.laser.tobytes() + o.odometry.tobytes() for o in seen)

    assert episode() == episode()


def test_an_observation_holds_nothing_that_reveals_the_pose(box):
    observation = Simulation(box, [[3.0, 4.0, 0.5], [5.0, 5.0, 0.0]]).observe()
    names = {"image", "depth", "laser", "odometry", "speed", "steering"}
    sensed = {name: value for name, value in vars(observation).items() if name in names}
    assert set(vars(observation)) - set(sensed) == {"body", "camera"}
    assert (observation.body, observation.camera) == (BicycleCar(), Camera())  # and no simulation
    assert all(value is None or type(value) is np.ndarray for value in sensed.values())
    assert (observation.odometry == 0).all()
    # A view of a larger array would get around that.
    for value in sensed.values():
        assert value is None or value.base is None or value.base.size == value.size


def test_observations_select_robots(box):
    observation = Simulation(box, [[3.0, 4.0, 0.5], [5.0, 5.0, 0.0], [6.0, 5.0, 0.0]]).observe()
    some = observation[np.array([True, False, True])]
    assert isinstance(some, Observation)
    assert len(observation) == 3
    assert len(some) == 2
    assert (some.image == observation.image[[0, 2]]).all()
    assert (some.body, some.camera) == (observation.body, observation.camera)
    other = Simulation(box, [[3.0, 4.0, 0.0]], body=DifferentialDrive()).observe()
    mixed = Observation.joined([some, other])
    assert len(mixed) == 3
    assert mixed.body is None
    assert mixed.camera == Observation.joined([some, some]).camera == Camera()
    assert Observation.joined([some, observation]).body == BicycleCar()
    assert some.pictures().body is None
    assert some.pictures().camera == Camera()
    assert (some.laser == observation.laser[[0, 2]]).all()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda s: Simulation(s, [[0.05, 5.0, 0.0]]), "inside a wall"),
        (lambda s: Simulation(s, [[5.0, 5.0, 0.0], [50.0, 5.0, 0.0]]), r"\(50.00, 5.00\)"),
        (lambda s: Simulation(s, [[np.nan, 5.0, 0.0]]), "poses: nan; give finite"),
        (
            lambda s: Simulation(s, [[5.0, 5.0, 0.0]], control_noise=0.3),
            "rng: None, and noise needs one",
        ),
        (lambda s: Simulation(s, [[5.0, 5.0, 0.0]]).step([[np.inf, 0.0]]), "finite"),
        (lambda s: Simulation(s, [[5.0, 5.0, 0.0]]).step([0.0, 0.0]), r"actions: shape \(2,\)"),
        (lambda s: Simulation(s, [[5.0, 5.0]]), r"poses: shape \(1, 2\)"),
        (
            lambda s: Simulation(s, [[5.0, 5.0, 0.0]], control_noise=-1.0),
            "control_noise: -1.0; give one real number from 0 on",
        ),
        (lambda s: Simulation(s, [[5, 5, 0]], people=[Person([[5.1, 5.0]])]), "a robot starts"),
        (lambda s: Simulation(s, [[5, 5, 0]], people=[Person([[1, 1]], owner=3)]), "last robot"),
        (lambda s: Sensors(laser=Laser(64, 4.0)), "full circle"),
        (lambda s: Person(np.zeros((0, 2))), "route: empty"),
        (lambda s: Person([[0.0, np.nan]]), "route: nan; give finite"),
        (lambda s: Person([[0.0, 0.0]], radius=0.0), "radius"),
    ],
)
def test_bad_input_is_named(box, make, words):
    with pytest.raises(InputError, match=words):
        make(box)


def test_a_start_between_furniture_is_refused():
    scene = Scene(make_box(pillars=[(5.0, 5.0, 1.0)]))
    for pose in ([5.0, 5.0, 0.0], [3.8, 5.0, 0.0], [4.1, 5.5, 2.0]):
        with pytest.raises(InputError, match="choose another start"):
            Simulation(scene, pose)


def test_a_post_under_the_car_is_no_place_to_start():
    scene = Scene(make_box(pillars=[(5.2, 5.0, 0.05)]))
    with pytest.raises(InputError, match="choose another start"):
        Simulation(scene, [5.0, 5.0, 0.0])


def test_poses_are_read_only(box):
    simulation = Simulation(box, [[5.0, 5.0, 0.0]])
    with pytest.raises(ValueError, match="read-only"):
        simulation.poses[0] = 1.0


def test_one_robot_of_a_batch_is_a_batch_of_one(box):
    observation = Simulation(box, [[3.0, 4.0, 0.5], [5.0, 5.0, 0.0]]).observe()
    assert len(observation[1]) == 1
    assert observation[1].image.shape == (1, 16, 64, 3)


# Teleporting a robot.


def test_a_teleported_robot_is_at_rest(box):
    starts = [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [2.0, 6.0, 0.0]]
    simulation = act_for(Simulation(box, starts), [0.6, 0.2], 20)
    before = simulation.poses
    there = np.array([[8.0, 8.0, 1.0], [5.0, 5.0, 4.0]])
    simulation.place([2, 0], there)
    assert np.allclose(simulation.poses[[2, 0]], [[8.0, 8.0, 1.0], [5.0, 5.0, 4.0 - 2 * np.pi]])
    assert (simulation.poses[1] == before[1]).all()
    seen = simulation.observe()
    assert seen.speed[[2, 0]].tolist() == seen.steering[[2, 0]].tolist() == [0.0, 0.0]
    assert seen.speed[1] > 0.5
    image = Simulation(box, there).observe().image
    assert (seen.image[[2, 0]] == image).all()
    placed = simulation.poses
    simulation.step(np.zeros((3, 2)))
    assert np.allclose(simulation.poses[[2, 0]], placed[[2, 0]], atol=1e-9)
    assert np.linalg.norm(simulation.poses[1, :2] - placed[1, :2]) > 0.02


def test_odometry_is_unaffected_by_teleporting(box):
    simulation = act_for(Simulation(box, [[2.0, 2.0, 0.0]]), [0.5, 0.0], 20)
    odometry = simulation.odometry.copy()
    simulation.place([0], [8.0, 2.0, np.pi / 2])
    assert (simulation.odometry == odometry).all()
    act_for(simulation, [0.5, 0.0], 20)
    gone = np.linalg.norm(simulation.poses[0, :2] - [8.0, 2.0])
    assert gone > 0.8
    assert simulation.odometry[0, 0] - odometry[0, 0] == pytest.approx(gone)


def test_a_teleported_robot_drives_on_as_if_it_had_started_there(box):
    carried = act_for(Simulation(box, [[2.0, 2.0, 0.0]]), [0.5, 0.3], 10)
    carried.place([0], [6.0, 6.0, 2.0])
    fresh = Simulation(box, [[6.0, 6.0, 2.0]])
    for simulation in (carried, fresh):
        act_for(simulation, [0.4, -0.2], 30)
    assert np.allclose(carried.poses, fresh.poses, atol=1e-9)
    assert not carried.collided[0]


def test_teleported_off_a_wall_a_robot_touches_nothing(box):
    simulation = act_for(Simulation(box, [[9.0, 5.0, 0.0]]), [0.8, 0.0], 20)
    assert simulation.touching[0]
    simulation.place([0], [5.0, 5.0, 0.0])
    act_for(simulation, [0.0, 0.0], 1)
    assert not simulation.touching[0]
    assert simulation.collided[0]  # it did, once
    assert np.allclose(simulation.poses[0], [5.0, 5.0, 0.0], atol=2e-3)
    act_for(simulation, [0.8, 0.0], 80)
    assert simulation.touching[0]


@pytest.mark.parametrize(
    ("robots", "poses", "words"),
    [
        ([0, 1], [[5.0, 5.0, 0.0], [9.95, 5.0, 0.0]], r"\(9.95, 5.00\).* inside a wall"),
        ([0], [[np.nan, 5.0, 0.0]], "poses: nan; give finite"),
        ([0], [[50.0, 5.0, 0.0]], "inside a wall"),
        ([0], [[5.0, 5.0]], r"poses: shape \(1, 2\)"),
        ([0, 1], [[5.0, 5.0, 0.0]], "robots: 2, poses: 1; give as many"),
        ([0, 0], [[5.0, 5.0, 0.0], [6.0, 5.0, 0.0]], r"robots: \[0, 0\]; give .* each once"),
        ([2], [[5.0, 5.0, 0.0]], "robots: 2; give whole numbers from 0 to 1"),
        ([-1], [[5.0, 5.0, 0.0]], "robots: -1; give whole numbers from 0 to 1"),
        ([0.5], [[5.0, 5.0, 0.0]], "whole numbers"),
        ([1], [[7.1, 7.0, 0.0]], "people: .* stands where"),
    ],
)
def test_no_robot_is_teleported_to_where_none_can_stand(box, robots, poses, words):
    starts = np.array([[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    people = [Person([[7.0, 7.0]], owner=1), Person([[5.0, 2.0]])]
    simulation = Simulation(box, starts, people=people)
    with pytest.raises(InputError, match=words):
        simulation.place(robots, poses)
    assert (simulation.poses == starts).all()


def test_one_robot_s_obstacle_does_not_block_another(box):
    starts = np.array([[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    simulation = Simulation(box, starts, people=[Person([[7.0, 7.0]], owner=1)])
    simulation.place([0], [[7.0, 7.0, 0.0]])
    assert simulation.poses[0, 0] == 7.0


def test_the_heading_drifts_with_the_square_root_of_the_distance():
    wheels, rng = WheelOdometry(distance=0.0, turn=0.0, drift=0.02), np.random.default_rng(4)
    for length in (0.01, 0.25, 4.0):
        motions = np.tile([0.6 * length, -0.8 * length, 0.3], (20_000, 1))
        read = wheels.measure(motions, rng)
        assert (read[:, :2] == motions[:, :2]).all()
        assert read[:, 2].mean() == pytest.approx(0.3, abs=0.001)
        assert read[:, 2].std() == pytest.approx(0.02 * np.sqrt(length), rel=0.03)


def test_speed_is_negative_in_reverse(box):
    simulation = Simulation(box, [[5.0, 5.0, 2.0]])
    act_for(simulation, [-0.3, 0.2], 10)
    assert simulation.speed[0] == pytest.approx(-0.3, abs=0.01)
    assert simulation.observe().speed[0] == simulation.speed[0]


def test_a_robot_that_leaves_one_of_two_obstacles_still_touches_the_other(box):
    # A person walks against the side of a car that pushes against the wall, and away again.
    person = Person([[9.55, 3.0], [9.55, 4.8]], speed=0.5, keep_off=0.0)
    simulation = Simulation(box, [[9.6, 5.0, 0.0]], people=[person])
    act_for(simulation, [0.5, 0.0], 5)
    counts = []
    for _ in range(60):
        simulation.step([[0.5, 0.0]])
        counts.append(int(simulation._fleet.contacts[0]))
        assert simulation.touching[0]
    assert counts[0] == counts[-1] == 1
    assert max(counts) == 2


@pytest.mark.parametrize(
    ("robot", "stops"),
    [((4.2, 5.65), True), ((3.9, 5.65), True), ((3.3, 5.2), False), ((4.0, 5.9), False)],
)
def test_a_person_does_not_walk_on_beside_a_robot_that_is_near(box, robot, stops):
    person = Person([[2.0, 5.0], [8.0, 5.0]], speed=0.5, distance=2.0)  # now at x = 4
    simulation = Simulation(box, [[*robot, 0.0]], people=[person])
    act_for(simulation, [0.0, 0.0], 10)
    walked = simulation.crowd.positions[0, 0] - 4.0
    assert walked == pytest.approx(0.0 if stops else 0.45, abs=0.06)


# Copies.


@cache
def apartment(seed):
    return Scene(generate("apartment", seed))


def cornered(seed, steps):
    """Robots of which many push into walls and corners, people, and noise; and their actions."""
    rng = np.random.default_rng(seed)
    scene = apartment(seed % 3)
    starts = free_poses(scene, 14, seed)
    people = [Person([place, np.add(place, [1.5, 0.2])]) for place in starts[:2, :2]]
    simulation = Simulation(
        scene,
        starts[2:],
        people=people if seed % 2 else (),
        interacting=seed % 4 == 0,
        control_noise=0.2,
        odometry_noise=DriftingOdometry(seed),
        rng=np.random.default_rng(seed),
    )
    for step in range(steps):
        if step % 30 == 0:
            action = np.column_stack([rng.uniform(-0.3, 0.8, 12), rng.uniform(-0.45, 0.45, 12)])
        simulation.step(action)
    if seed % 4:
        simulation.place([3], starts[[5]])
    return simulation, rng


def rest_of(simulation, rng, steps):
    """All that is to be seen of a simulation that goes on."""
    seen = []
    for step in range(steps):
        if step % 15 == 0:
            action = np.column_stack([rng.uniform(-0.3, 0.8, 12), rng.uniform(-0.45, 0.45, 12)])
        simulation.step(action)
        seen += [simulation.poses, simulation.odometry, simulation.collided, simulation.touching]
    last = simulation.observe()
    seen += [simulation.crowd.positions, last.image, last.laser, last.odometry]
    return b"".join(array.tobytes() for array in seen)


@pytest.mark.parametrize(("seed", "steps"), [(0, 70), (1, 45), (3, 80), (6, 0), (4, 33)])
@pytest.mark.few(2)
def test_a_copy_goes_on_as_the_original_does(seed, steps):
    original, rng = cornered(seed, steps)
    alone, _ = cornered(seed, steps)
    copies = [copy.copy(original), copy.deepcopy(original), pickle.loads(pickle.dumps(original))]
    for simulation in (*copies, copy.deepcopy(copies[2])):
        assert simulation.poses.tobytes() == original.poses.tobytes()
        assert (simulation.touching == original.touching).all()
    wanted = rest_of(alone, copy.deepcopy(rng), 60)
    # In turn: none of them draws another one's noise or moves another one's robots.
    for simulation in (*copies, original):
        assert rest_of(simulation, copy.deepcopy(rng), 60) == wanted


def test_a_copy_goes_on_alike_in_another_process():
    original, rng = cornered(3, 40)
    work = joblib.Parallel(n_jobs=2)
    for found in work(joblib.delayed(rest_of)(original, copy.deepcopy(rng), 20) for _ in range(2)):
        assert found == rest_of(copy.copy(original), copy.deepcopy(rng), 20)


def test_a_copy_shares_the_scene_and_cannot_be_written_to(box):
    simulation = act_for(Simulation(box, [[5.0, 5.0, 0.0]]), [0.5, 0.1], 3)
    for copied in (copy.copy(simulation), copy.deepcopy(simulation)):
        assert copied.scene is box
        with pytest.raises(ValueError, match="read-only"):
            copied.poses[0] = 1.0
    stored = pickle.loads(pickle.dumps(simulation))
    with pytest.raises(ValueError, match="read-only"):
        stored.scene.plan.walls[0] = 1.0
    assert (stored.observe().image == simulation.observe().image).all()


# Robots that see and touch each other.


def facing(apart=3.0):
    return np.array([[4.0, 5.0, 0.0], [4.0 + apart, 5.0, np.pi]])


@pytest.mark.parametrize("body", [BicycleCar(), DifferentialDrive()])
def test_two_robots_that_interact_stop_each_other_head_on(box, body):
    simulation = Simulation(box, facing(), body=body, interacting=True)
    act_for(simulation, [0.5, 0.0], 20)
    assert not simulation.collided.any()
    act_for(simulation, [0.5, 0.0], 60)
    assert simulation.touching.tolist() == simulation.collided.tolist() == [True, True]
    assert np.abs(simulation.speed).max() < 0.02
    front = body.footprint[:, 0].max()
    assert simulation.poses[1, 0] - simulation.poses[0, 0] == pytest.approx(2 * front, abs=0.02)
    act_for(simulation, [-0.3, 0.0], 20)
    assert simulation.touching.tolist() == [False, False]
    assert simulation.collided.all()
    # Others pass through each other.
    ghosts = act_for(Simulation(box, facing(), body=body), [0.5, 0.0], 80)
    assert not ghosts.collided.any()
    assert ghosts.poses[0, 0] > ghosts.poses[1, 0]


def test_a_robot_pushes_one_that_stands(box):
    simulation = Simulation(box, [[4.0, 5.0, 0.0], [5.0, 5.0, 0.0]], interacting=True)
    for _ in range(60):
        simulation.step([[0.5, 0.0], [0.0, 0.0]])
    assert simulation.poses[1, 0] > 5.1
    assert simulation.odometry[1, 0] > 0.1


def test_each_robot_appears_in_the_other_s_image_and_scan_but_not_in_its_own(box):
    alone = Simulation(box, facing(1.5)).observe()
    both = Simulation(box, facing(1.5), interacting=True).observe()
    changed = (both.image != alone.image).any(axis=(1, 3))  # (N, W)
    assert changed[:, 31:33].all()
    assert 3 <= changed[0].sum() <= 6  # 0.24 m wide, 1.1 m away
    ahead = np.abs(full_circle(96)).argmin()
    assert both.laser[:, ahead] == pytest.approx(1.5 - 0.36, abs=0.01)
    nearer = both.laser < alone.laser - 1e-9
    assert nearer.sum(axis=1).tolist() == [2, 2]
    # From behind, a car that looks the other way sees nothing of it.
    away = np.array([[4.0, 5.0, np.pi], [7.0, 5.0, 0.0]])
    images = [Simulation(box, away, interacting=i).observe().image for i in (False, True)]
    assert (images[0] == images[1]).all()
    some = Simulation(box, facing(1.5), interacting=True).observe(np.array([1]))
    assert (some.image == both.image[[1]]).all()


def test_a_robot_looks_like_its_outline(box):
    """From all around, a car is seen where its sides are; its corners are round."""
    car = np.array([5.0, 5.0, 0.7])
    discs = robot_discs(BicycleCar(), car[None])
    sides = to_world(car, BicycleCar().footprint)
    walls = np.hstack([sides, np.roll(sides, -1, axis=0)])
    angles = np.linspace(-np.pi, np.pi, 40, endpoint=False)
    rays = np.column_stack([5 + 1.5 * np.cos(angles), 5 + 1.5 * np.sin(angles), angles + np.pi])
    fan = Fan(np.linspace(-0.06, 0.06, 9))
    outline = Raycaster(walls).cast(rays, fan).distance
    seen = box.caster.cast(rays, fan, discs, np.ones(len(rays), np.int32)).distance
    hit = np.isfinite(outline)
    assert (seen >= outline - 1e-9)[hit].all()
    assert np.median((seen - outline)[hit]) < 0.02
    assert ((seen - outline)[hit] < 0.06).mean() > 0.9
    own = box.caster.cast(rays, fan, discs, np.zeros(len(rays), np.int32)).distance
    assert (own > 3.0).all()


def test_robots_that_interact_start_beside_each_other():
    box = Scene(make_box())
    crossed = [[5.0, 5.0, 0.0], [2.0, 2.0, 0.0], [5.1, 5.2, 0.8]]
    Simulation(box, crossed)
    with pytest.raises(InputError, match="robots 0 and 2 would stand in each other"):
        Simulation(box, crossed, interacting=True)
    beside = [[5.0, 5.0, 0.0], [5.0, 5.25, 0.0], [5.46, 5.0, 0.0]]
    simulation = Simulation(box, beside, interacting=True)
    with pytest.raises(InputError, match="robots 0 and 1 would stand"):
        simulation.place([1], [[5.0, 5.2, 0.0]])
    assert (simulation.poses == beside).all()
    simulation.place([1], [[5.0, 6.0, 0.0]])
    assert simulation.poses[1, 1] == 6.0
