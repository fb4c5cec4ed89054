"""Wheel odometry: how far it drifts, and whose drift depends on what."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import compose, relative
from tutorial_lib.world.noise import (
    ACTUATION,
    FORWARD,
    LEFT,
    ODOMETRY,
    DiscreteNoise,
    DriftingOdometry,
    NoNoise,
    WheelOdometry,
)
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation

SEEDS = st.lists(st.integers(0, 2**31), min_size=1, max_size=3)
STEP = 0.05
"""Metres in 0.1 s, at 0.5 m/s."""


def estimates(motions, noise):
    """Poses (T, N, 3) by odometry, from motions (T, N, 3)."""
    poses = [np.zeros(motions.shape[1:])]
    for motion in motions:
        poses.append(compose(poses[-1], noise.measure(motion, None)))
    return np.stack(poses)


def bytes_of(motions, *seed):
    return estimates(motions, DriftingOdometry(*seed)).tobytes()


def random_motions(steps, robots, seed):
    rng = np.random.default_rng(seed)
    return rng.normal(0.0, [0.04, 0.002, 0.05], (steps, robots, 3))


def test_the_drift_has_the_documented_variance():
    motions = np.tile([STEP, 0.0, 0.0], (200, 3000, 1))
    ends = estimates(motions, DriftingOdometry(0))
    for metres in (2.5, 10.0):
        _, y, heading = ends[round(metres / STEP)].T
        assert heading.std() == pytest.approx(0.020 * metres**0.5, rel=0.06)
        assert y.std() == pytest.approx(0.012 * metres**1.5, rel=0.08)
        assert abs(heading.mean()) < 0.005
        assert abs(y.mean()) < 0.04
    read = estimates(motions, DriftingOdometry(0, wheels=WheelOdometry(drift=0.0)))[-1]
    assert read[:, 0].std() == pytest.approx(0.011 * 10**0.5, rel=0.06)
    assert read[:, 0].mean() == pytest.approx(10.0, abs=0.01)
    assert np.rad2deg(ends[-1, :, 2].std()) == pytest.approx(3.6, abs=0.2)
    assert ends[-1, :, 1].std() == pytest.approx(0.37, abs=0.03)


def test_a_turn_is_off_in_proportion():
    motions = np.tile([0.0, 0.0, 0.1], (60, 3000, 1))
    ends = estimates(motions, DriftingOdometry(1))[-1]
    assert (ends[:, :2] == 0.0).all()
    assert np.unwrap(ends[:, 2]).std() == pytest.approx(0.05 * 0.1 * 60**0.5, rel=0.06)


@given(SEEDS, st.integers(1, 4), st.integers(1, 250))
@settings(max_examples=20, deadline=None)
def test_a_robot_that_stands_still_does_not_drift(seed, robots, steps):
    assert (estimates(np.zeros((steps, robots, 3)), DriftingOdometry(*seed)) == 0.0).all()


@given(SEEDS, st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_the_same_seed_gives_the_same_drift_and_another_one_another(seed, driven):
    motions = random_motions(130, 3, driven)
    assert bytes_of(motions, *seed) == bytes_of(motions, *seed)
    assert bytes_of(motions, *seed) != bytes_of(motions, *seed, 1)


@given(SEEDS, st.integers(1, 6), st.integers(1, 6), st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_a_robot_drifts_as_it_does_without_the_others(seed, robots, others, driven):
    motions = random_motions(120, robots + others, driven)
    fleet = estimates(motions, DriftingOdometry(*seed))
    fewer = estimates(motions[:, :robots], DriftingOdometry(*seed))
    assert (fleet[:, :robots] == fewer).all()
    elsewhere = motions.copy()
    elsewhere[:, robots:] *= -0.5
    assert (estimates(elsewhere, DriftingOdometry(*seed))[:, :robots] == fewer).all()


def test_every_number_of_a_robot_s_stream_is_used_in_turn():
    """Over more steps than are drawn at a time."""
    motions, streams = random_motions(250, 2, 4), np.random.SeedSequence(8).spawn(2)
    normal = [np.random.default_rng(one).normal(size=(250, 3)) for one in streams]
    noise, wheels = DriftingOdometry(8), WheelOdometry()
    for motion, drawn in zip(motions, np.stack(normal, axis=1), strict=True):
        assert (noise.measure(motion, None) == wheels.read(motion, drawn)).all()


def test_every_discrete_action_has_the_next_noise_of_its_robot():
    noise, streams = DiscreteNoise(2, np.random.default_rng(3)), np.random.default_rng(3).spawn(2)
    blocks = [[(s.random((100, 2)), s.normal(size=(100, 2, 3))) for _ in range(3)] for s in streams]
    luck, normal = (
        np.stack([np.concatenate([block[part] for block in one]) for one in blocks], axis=1)
        for part in (0, 1)
    )
    for step in range(250):
        motions, errors = noise.draw(np.array([FORWARD, LEFT]))
        for robot, action in enumerate((FORWARD, LEFT)):
            chances, drawn = luck[step, robot, :, None], normal[step, robot, :, None]
            wanted = ACTUATION[action].motions(chances[0], drawn[0])
            assert (motions[robot] == wanted).all()
            assert (errors[robot] == ODOMETRY[action].motions(chances[1], drawn[1])).all()


def test_robots_of_a_fleet_do_not_drift_alike():
    ends = estimates(np.tile([STEP, 0.0, 0.0], (40, 50, 1)), DriftingOdometry(3))[-1]
    assert len(np.unique(ends[:, 2])) == 50
    assert abs(np.corrcoef(ends[:-1, 2], ends[1:, 2])[0, 1]) < 0.45


def test_noise_says_whether_it_needs_a_generator():
    box, here = Scene(make_box()), [[5.0, 5.0, 0.0]]
    with pytest.raises(InputError, match="rng: None, and noise needs one"):
        Simulation(box, here, odometry_noise=WheelOdometry())
    for noise in (NoNoise(), DriftingOdometry(0)):
        Simulation(box, here, odometry_noise=noise)


def test_the_drift_of_a_simulated_fleet_leaves_all_else_as_it_is():
    box, starts = Scene(make_box()), np.array([[3.0, 3.0, 0.2], [6.0, 5.0, 1.0]])
    rngs = [np.random.default_rng(5) for _ in range(2)]
    exact = Simulation(box, starts, control_noise=0.33, rng=rngs[0])
    drifting = Simulation(
        box, starts, control_noise=0.33, rng=rngs[1], odometry_noise=DriftingOdometry(2)
    )
    for _ in range(30):
        exact.step([[0.5, 0.2]] * 2)
        drifting.step([[0.5, 0.2]] * 2)
    assert (exact.poses == drifting.poses).all()
    assert (exact.speed == drifting.speed).all()
    error = relative(relative(starts, drifting.poses), drifting.odometry)
    assert (np.abs(error) > 0.0).all()
    assert np.abs(error).max() < 0.2
