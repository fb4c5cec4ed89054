"""Motion of round robots among walls: each discrete action in one straight piece, until contact.

Cars drive in pymunk (`world.simulation`). Discrete actions have kernels of their own, which are
some twenty times as fast; a test compares them with pymunk over 10,000 motions, a third of them
into walls. Both stop at the same places but for the centimetre between two tests of contact. Then a
robot of pymunk's would slide along its wall; this one has a bumper that stops its wheels.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.se2 import Array, to_local, to_world, wrap
from tutorial_lib.validation import fit_together, floats
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT, STOP

ACTIONS = (STOP, FORWARD, LEFT, RIGHT)
"""The discrete actions; their motion with noise is `world.noise.ACTUATION`."""
FORWARD_METRES = 0.25
TURN = float(np.deg2rad(10.0))
"""What the actions do without noise (Chaplot et al. 2020, 5)."""
EXACT = np.array([(0.0, 0.0, 0.0), (FORWARD_METRES, 0.0, 0.0), (0.0, 0.0, TURN), (0.0, 0.0, -TURN)])
"""Motions (4, 3) without noise, by action, in the robot's frame."""
_STEP = 0.01  # metres between the places at which contact is tested


def actions_towards(poses: Array, points: Array, aim: float) -> NDArray[np.intp]:
    """FORWARD, LEFT or RIGHT (N,) of robots at poses (N, 3) on the way to points (N, 2).

    A robot turns while its heading is off by `aim` (rad) or more, which has to be more than half of
    one action's angle.
    """
    bearing = np.arctan2(*np.moveaxis(to_local(poses, points), -1, 0)[::-1])
    return np.where(np.abs(bearing) < aim, FORWARD, np.where(bearing > 0, LEFT, RIGHT))


def move(
    poses: Array, motions: Array, segments: Array, radius: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Move round robots by `motions` in their frames, each until it touches a wall.

    A robot moves in a straight line and then turns; one that touches a wall can move away from it,
    or along it.

    Args:
        poses: (N, 3).
        motions: (N, 3) metres ahead, metres to the left, rad.
        segments: (S, 4) walls and furniture.
        radius: of the robots, metres.

    Returns:
        The poses (N, 3) after it, and whether each robot (N,) was stopped.

    Raises:
        InputError: when an argument is no such array, or one is shorter than another.
    """
    poses, motions = floats("poses", poses, ("N", 3)), floats("motions", motions, ("N", 3))
    segments = floats("segments", segments, ("S", 4))
    fit_together(poses=(poses, ("N", 3)), motions=(motions, ("N", 3)))
    walls = [(np.ascontiguousarray(segments), np.arange(len(poses)))]
    return move_among(poses, motions, walls, radius)


def move_among(
    poses: Array, motions: Array, walls: Sequence[tuple[Array, NDArray[np.intp]]], radius: float
) -> tuple[Array, NDArray[np.bool_]]:
    """`move` for arrays that are right already, of robots in several worlds.

    Args:
        poses: (N, 3).
        motions: (N, 3).
        walls: of each world (S, 4), in one piece, with the rows (M,) of its robots.
        radius: of the robots, metres.
    """
    wanted, starts = to_world(poses, motions[:, :2]), np.ascontiguousarray(poses[:, :2])
    places, stopped = np.empty((len(poses), 2)), np.empty(len(poses), np.bool_)
    for segments, rows in walls:
        _advance_until_contact(starts, wanted, rows, segments, radius, places, stopped)
    return np.column_stack([places, wrap(poses[:, 2] + motions[:, 2])]), stopped


@njit(cache=True, nogil=True, error_model="numpy")
def _advance_until_contact(
    starts: Array,
    wanted: Array,
    rows: NDArray[np.intp],
    segments: Array,
    radius: float,
    places: Array,
    stopped: NDArray[np.bool_],
) -> None:
    """Advance in small steps while no wall comes nearer than `radius`, or none comes nearer."""
    near = np.empty_like(segments)
    for n in rows:
        x, y = starts[n, 0], starts[n, 1]
        dx, dy = wanted[n, 0] - x, wanted[n, 1] - y
        metres = np.sqrt(dx * dx + dy * dy)
        count = int(np.ceil(metres / _STEP))
        reach, found = radius + metres + 2 * _STEP, 0  # walls that are in reach
        for s in range(len(segments)):
            x0, y0, x1, y1 = segments[s]
            # Most are far away along x or y already.
            if max(min(x0, x1) - x, x - max(x0, x1), min(y0, y1) - y, y - max(y0, y1)) >= reach:
                continue
            if _gap(x, y, segments[s : s + 1]) < reach:
                near[found] = segments[s]
                found += 1
        before = _gap(x, y, near[:found])
        places[n, 0], places[n, 1], stopped[n] = x, y, False
        for k in range(1, count + 1):
            px, py = x + dx * k / count, y + dy * k / count
            gap = _gap(px, py, near[:found])
            if gap < radius and gap < before - 1e-9:
                stopped[n] = True
                break
            places[n, 0], places[n, 1], before = px, py, gap


@njit(cache=True, nogil=True, error_model="numpy")
def _gap(x: float, y: float, segments: Array) -> float:
    """Metres from a point to the nearest segment."""
    best = np.inf
    for s in range(len(segments)):
        ax, ay = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
        bx, by = x - segments[s, 0], y - segments[s, 1]
        share = (ax * bx + ay * by) / (ax * ax + ay * ay)
        share = min(max(share, 0.0), 1.0)
        cx, cy = bx - share * ax, by - share * ay
        best = min(best, cx * cx + cy * cy)
    return np.sqrt(best)
