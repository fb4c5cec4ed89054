"""What stands in the way, how long a robot waits for it, and what it avoids afterwards."""

import networkx as nx
import numpy as np
import pytest

from tests.conftest import make_box
from tests.made_up_maps import table_map
from tutorial_lib.agents.blockades import (
    MEMORY,
    WAIT,
    Blockades,
    Waiting,
    in_the_way,
)
from tutorial_lib.geometry import to_local
from tutorial_lib.interfaces import HERE
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Laser
from tutorial_lib.world.simulation import STEP, Sensors, Simulation

PLACE = np.array([1.0, 2.0, 0.5])


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
def test_what_stands_before_a_waypoint_is_in_the_way(heading):
    scene, start = Scene(make_box()), np.array([5.0, 5.0, heading])
    person = Person(np.array([[6.0, 5.0]]), speed=0.0)
    points = np.array([[7.0, 5.0], [6.1, 5.0], [5.0, 7.0], [3.0, 5.0], [7.0, 6.2]])
    waypoints = to_local(start, points)
    sensors = Sensors(camera=None)
    seen = Simulation(scene, [start], people=[person], sensors=sensors).observe()
    lasers = np.repeat(seen.laser, len(points), axis=0)
    # The second waypoint is where the person stands: only what is well before it counts.
    assert in_the_way(lasers, waypoints).tolist() == [True, False, False, False, False]
    free = Laser().scan(scene, start[None])
    assert not in_the_way(np.repeat(free, len(points), axis=0), waypoints).any()


def waited(blocked, odometry):
    """After how many steps a robot has waited long enough; None if it never does."""
    waiting, robot = Waiting(2), np.array([1])
    for step, (one, pose) in enumerate(zip(blocked, odometry, strict=True), start=1):
        if waiting.step(robot, np.asarray(pose, dtype=float)[None], np.array([one]))[0]:
            return step
    return None


def test_a_robot_waits_for_a_moment():
    still = [[0.0, 0.0, 0.0]] * 200
    assert waited([True] * 200, still) == pytest.approx(WAIT / STEP, abs=1)
    assert waited([False] * 200, still) is None
    assert waited([True, False] * 100, still) is None


def test_a_person_who_moves_on_is_forgotten():
    still = [[0.0, 0.0, 0.0]] * 200
    assert waited([True] * 30 + [False] * 30 + [True] * 30 + [False] * 110, still) is None


def test_a_robot_that_gets_on_does_not_wait():
    moving = [[0.02 * step, 0.0, 0.0] for step in range(400)]
    assert waited([True] * 400, [[4 * x, y, z] for x, y, z in moving]) is None
    waiting, robot = Waiting(1), np.array([0])
    for _ in range(60):
        due = waiting.step(robot, np.zeros((1, 3)), np.array([True]))
    assert due[0]
    waiting.stop(0)
    assert not waiting.step(robot, np.zeros((1, 3)), np.array([True]))[0]


def test_a_robot_waits_where_it_began_to_not_where_it_stood_before():
    went = [[0.02 * step, 0.0, 0.0] for step in range(25)]
    creeps = [[0.5 + 0.005 * step, 0.0, 0.0] for step in range(60)]
    steps = waited([False] * 25 + [True] * 60, went + creeps)
    assert steps == pytest.approx(25 + WAIT / STEP, abs=1)
    # Blocked while it got on, it waits where it stands in the end.
    gets_on = [[0.04 * step, 0.0, 0.0] for step in range(30)]
    steps = waited([True] * 90, gets_on + [gets_on[-1]] * 60)
    assert 45 < steps < 30 + WAIT / STEP + 1


def grid():
    """Two rows of vertices along a corridor, 0 to 4 and 5 to 9, joined to each other."""
    topomap = table_map(np.zeros((10, 10)), 10)
    for row in (0, 5):
        for v in range(row, row + 4):
            topomap.connect(v, v + 1, 0.99, driven=1)
    for v in range(5):
        topomap.connect(v, v + 5, 0.99)
        topomap.connect(v + 5, v, 0.99)
    for v in range(4):
        topomap.connect(v, v + 6, 0.99)
    return topomap


def test_a_stretch_is_excluded_with_what_runs_beside_it_but_nothing_else():
    topomap = grid()
    blockades = Blockades(2, topomap)
    blockades.add(0, [1], [2], PLACE, 10.0)
    excluded = blockades.excluded(0, PLACE, 10.0)
    assert {e for e in excluded if e[0] != HERE} == {(1, 2), (1, 7), (6, 7)}
    assert {v for u, v in excluded if u == HERE} == {2, 7}
    left = topomap.graph.copy()
    left.remove_edges_from(excluded)
    assert not nx.has_path(left, 0, 3)
    assert nx.has_path(left, 2, 4)
    assert blockades.excluded(1, PLACE, 10.0) == set()


def test_a_stretch_with_an_edge_back_is_excluded_all_the_same():
    topomap = grid()
    topomap.connect(2, 1, 0.99)
    blockades = Blockades(1, topomap)
    blockades.add(0, [1], [2], PLACE, 10.0)
    wanted = {(1, 2), (1, 7), (6, 7), (HERE, 2), (HERE, 7)}
    assert blockades.excluded(0, PLACE, 10.0) == wanted


def test_it_forgets_after_a_time_and_first_steps_once_it_is_elsewhere():
    blockades = Blockades(1, grid())
    blockades.add(0, [1], [2], PLACE, 10.0)
    elsewhere = np.add(PLACE, [3.0, 0.0, 0.0])
    assert all(u != HERE for u, _ in blockades.excluded(0, elsewhere, 11.0))
    assert blockades.excluded(0, elsewhere, 10.0 + MEMORY - 1.0)
    assert blockades.excluded(0, PLACE, 10.0 + MEMORY + 1.0) == set()


def test_a_robot_that_passed_nothing_excludes_only_first_steps():
    blockades = Blockades(1, grid())
    blockades.add(0, [], [2], PLACE, 0.0)
    assert blockades.excluded(0, PLACE, 0.0) == {(HERE, 2), (HERE, 7)}
