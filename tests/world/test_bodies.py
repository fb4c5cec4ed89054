import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import compose, inverse, to_local
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive, advance

control = st.tuples(st.floats(-2, 2), st.floats(-2, 2))


def test_the_tightest_circle_has_the_textbook_radius():
    car = BicycleCar()
    speed, seconds = 0.5, 40.0
    twist = car.twist(np.array([[speed, car.max_steering]]))[0]
    poses = advance(np.zeros(3), np.tile(twist, (400, 1)), np.linspace(0, seconds, 400))
    radii = np.linalg.norm(poses[:, :2] - [0, car.turning_radius], axis=1)
    assert np.allclose(radii, 0.30 / np.tan(0.45))


def test_advance_agrees_with_small_steps():
    pose, twist = np.array([1.0, 2.0, 0.3]), np.array([0.7, 1.1])
    small = pose.copy()
    for _ in range(20_000):
        small += 1e-4 * np.array([0.7 * np.cos(small[2]), 0.7 * np.sin(small[2]), 1.1])
    assert np.allclose(advance(pose, twist, 2.0), small, atol=1e-3)


@given(control, st.floats(0.01, 2), st.floats(0.01, 2))
def test_advance_in_two_parts_is_advance_in_one(twist, first, second):
    start, twist = np.array([0.5, -1.0, 0.2]), np.array(twist)
    parts = advance(advance(start, twist, first), twist, second)
    whole = advance(start, twist, first + second)
    assert np.allclose(to_local(parts, whole[:2]), 0, atol=1e-9)


@given(control, st.floats(0.01, 2))
def test_reversing_undoes_driving(twist, seconds):
    there = advance(np.zeros(3), np.array(twist), seconds)
    back = advance(there, -np.array(twist), seconds)
    assert np.allclose(compose(inverse(back), np.zeros(3))[:2], 0, atol=1e-9)


@pytest.mark.parametrize("body", [BicycleCar(), DifferentialDrive()])
@given(controls=control, actions=control)
def test_respond_keeps_limits_and_rates(body, controls, actions):
    low, high, rates = {
        BicycleCar: ([-0.3, -0.45], [0.8, 0.45], [2.0, 3.2]),
        DifferentialDrive: ([-0.5, -1.5], [0.5, 1.5], [2.0, 10.0]),
    }[type(body)]
    before = np.clip([controls], low, high)
    after = body.respond(before, np.array([actions]), 0.1)
    assert (after >= np.array(low) - 1e-12).all()
    assert (after <= np.array(high) + 1e-12).all()
    assert (np.abs(after - before) <= np.array(rates) * 0.1 + 1e-12).all()
    # Given time, it reaches what was commanded.
    for _ in range(50):
        after = body.respond(after, np.array([actions]), 0.1)
    assert np.allclose(after, np.clip([actions], low, high))


def test_footprints_have_the_stated_sizes():
    corners = BicycleCar().footprint
    assert np.allclose(np.ptp(corners, axis=0), [0.42, 0.24])
    assert np.isclose(corners[:, 0].min(), -0.06)
    assert np.isclose(np.linalg.norm(DifferentialDrive().footprint, axis=1).min(), 0.18, atol=0.01)


def test_the_differential_drive_turns_in_place_and_the_car_does_not():
    assert DifferentialDrive().twist(np.array([[0.0, 1.0]])).tolist() == [[0.0, 1.0]]
    assert BicycleCar().twist(np.array([[0.0, 0.45]])).tolist() == [[0.0, 0.0]]


def test_a_round_robot_s_footprint_lies_just_around_its_circle():
    robot = DifferentialDrive()
    corners = robot.footprint
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    assert np.linalg.norm(middles, axis=1) == pytest.approx(np.full(12, robot.radius))
    assert np.linalg.norm(corners, axis=1).max() < 1.04 * robot.radius


def test_the_axles_are_within_the_car():
    assert BicycleCar(wheelbase=0.42, length=0.42).footprint[0, 0] == 0.0
    with pytest.raises(InputError, match=r"wheelbase: 0\.6; give at most the length, 0\.42 m"):
        BicycleCar(wheelbase=0.6)
