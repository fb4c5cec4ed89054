"""A car turns where it stands, whichever way it looks, and touches nothing."""

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.control.three_point import Stillness, ThreePointTurn
from tutorial_lib.geometry import wrap
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Sensors, Simulation


def turned(scene, starts, angles, steps, back=False):
    """Headings turned (T, N) and metres from the start (T, N) of cars that turn by `angles`.

    With `back` they turn to the other side where they are stuck.
    """
    simulation = Simulation(scene, starts, sensors=Sensors(camera=None))
    robots, before = np.arange(len(simulation)), simulation.poses
    turn = ThreePointTurn(len(simulation))
    turn.begin(robots, simulation.odometry, np.asarray(angles, dtype=float))
    total, found, off = np.zeros(len(simulation)), [], []
    stillness = Stillness(len(simulation))
    for _ in range(steps):
        last = simulation.poses
        if back:
            stuck = stillness.stuck(robots, simulation.odometry)
            turn.turn_back(robots[stuck], simulation.odometry[stuck])
        simulation.step(turn.act(simulation.observe(), robots))
        total = total + wrap(simulation.poses[:, 2] - last[:, 2])
        found.append(total)
        off.append(np.linalg.norm(simulation.poses[:, :2] - before[:, :2], axis=1))
    assert not simulation.collided.any()
    return np.array(found), np.array(off), turn


@pytest.mark.parametrize("side", [1, -1])
def test_it_turns_round_within_a_car_s_length_or_two(side):
    scene = Scene(make_box())
    total, off, turn = turned(scene, [[5.0, 5.0, 0.3]], [side * np.pi], 80)
    there = np.flatnonzero(side * total[:, 0] > np.pi - 0.2)
    assert there.size
    assert there[0] < 70
    # A circle would end 1.24 m beside the place.
    assert off[: there[0], 0].max() < 0.75
    assert turn.seconds[0] == pytest.approx(8.0)


def test_it_turns_in_a_corner_too():
    scene = Scene(make_box())
    starts = [[0.5, 0.5, heading] for heading in (0.8, 2.4, -1.0)]
    total, _, _ = turned(scene, starts, [np.pi] * 3, 150)
    assert (total.max(axis=0) > np.pi - 0.2).all()


def test_beyond_the_heading_it_turns_back():
    scene = Scene(make_box())
    total, _, _ = turned(scene, [[5.0, 5.0, 0.0]], [1.5], 160)
    assert 1.9 < total.max() < 3.0
    last = total[100:, 0]
    assert last.min() < 1.2


def test_a_car_that_is_wedged_gets_out_to_the_other_side():
    scene, starts = Scene(make_box()), [[0.271, 0.381, 1.35], [0.285, 0.312, 1.955]]
    wedged, _, _ = turned(scene, starts, [np.pi] * 2, 150)
    assert np.abs(wedged).max() < 1.0
    total, _, turn = turned(scene, starts, [np.pi] * 2, 150, back=True)
    assert (total.min(axis=0) < 0.2 - np.pi).all()
    assert turn.seconds == pytest.approx([15.0, 15.0])


@pytest.mark.parametrize(("side", "angle"), [(1.0, np.pi), (-1.0, np.pi), (1.0, 1.5), (-1.0, 0.4)])
@pytest.mark.parametrize("beyond", [-0.05, 0.6])
def test_to_the_other_side_is_to_the_same_heading_and_no_further(side, angle, beyond):
    """A car that rolled back a little, and one that was wedged beyond the heading."""
    turn, robots = ThreePointTurn(1), np.zeros(1, int)
    turn.begin(robots, np.zeros((1, 3)), np.array([side * angle]))
    turned_ = beyond if beyond < 0 else angle + beyond
    turn._sides(np.array([[0.0, 0.0, side * turned_]]), robots)
    turn.turn_back(robots, np.array([[0.0, 0.0, side * turned_]]))
    left = side * float(turn._angle[0])
    assert -2 * np.pi < left <= 0
    assert wrap(turned_ + left - angle) == pytest.approx(0, abs=1e-9)
    assert turn._side[0] == -side


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_car_that_is_stuck_on_its_way_back_turns_on_instead(side):
    turn, robots = ThreePointTurn(1), np.zeros(1, int)
    turn.begin(robots, np.zeros((1, 3)), np.array([side * 1.5]))
    for turned_ in np.arange(0.5, 3.0, 0.5):  # beyond the heading, until it is to turn back
        turn._sides(np.array([[0.0, 0.0, side * turned_]]), robots)
    assert turn._side[0] == -side
    turn.turn_back(robots, np.array([[0.0, 0.0, side * 2.5]]))
    assert turn._side[0] == side
    assert side * turn._angle[0] == pytest.approx(2 * np.pi - 1.0)


def test_a_car_that_turns_all_round_does_so_to_the_other_side():
    turn, robots = ThreePointTurn(1), np.zeros(1, int)
    turn.begin(robots, np.zeros((1, 3)), np.array([4 * np.pi]))
    turn._sides(np.array([[0.0, 0.0, 0.5]]), robots)
    turn.turn_back(robots, np.array([[0.0, 0.0, 0.5]]))
    assert turn._angle[0] == pytest.approx(-4 * np.pi)


def test_a_robot_is_stuck_once_it_has_stood_still_for_a_second_and_a_robot_that_moves_never():
    stillness, robots = Stillness(2), np.arange(2)
    stuck = [stillness.stuck(robots, np.array([[1.0, 1.0, 0.0], [t, 0.0, 0.0]])) for t in range(30)]
    assert np.flatnonzero([one[0] for one in stuck]).tolist() == [11, 22]
    assert not any(one[1] for one in stuck)


def test_the_count_of_stillness_begins_anew_where_it_is_asked_to():
    stillness, robots = Stillness(2), np.arange(2)
    for _ in range(8):
        stillness.stuck(robots, np.zeros((2, 3)))
    stillness.begin(robots[:1])
    stuck = np.array([stillness.stuck(robots, np.zeros((2, 3))) for _ in range(12)])
    assert np.flatnonzero(stuck[:, 0]).tolist() == [10]
    assert np.flatnonzero(stuck[:, 1]).tolist() == [3]


def test_only_the_given_robots_turn():
    simulation = Simulation(Scene(make_box()), [[3.0, 3.0, 0.0], [6.0, 6.0, 0.0]])
    turn = ThreePointTurn(2)
    turn.begin(np.array([1]), simulation.odometry[[1]], np.array([-2.0]))
    actions = turn.act(simulation.observe(np.array([1])), np.array([1]))
    assert actions.shape == (1, 2)
    assert actions[0, 1] < 0
    assert turn.seconds.tolist() == [0.0, pytest.approx(0.1)]
