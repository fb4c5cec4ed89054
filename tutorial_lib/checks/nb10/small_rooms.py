"""Made-up rooms, and what a robot sees in them, for the checks of notebook 10."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import column_bearings
from tutorial_lib.geometry import Array

BEAMS = 192


def walls_of(*outlines: list[tuple[float, float]]) -> Array:
    """Segments (S, 4) of open lines through corners."""
    pairs = [(a, b) for line in outlines for a, b in pairwise(line)]
    return np.array([(*a, *b) for a, b in pairs], float)


def box(x: float, y: float, wide: float, high: float) -> list[tuple[float, float]]:
    """The closed outline of a box, from its lower left corner."""
    ends = [(x, y), (x + wide, y), (x + wide, y + high), (x, y + high)]
    return [*ends, ends[0]]


ROOMS = {
    "a room with a cupboard": walls_of(
        [(3.2, 0.0), (0.0, 0.0), (0.0, 4.0), (5.0, 4.0), (5.0, 0.0), (4.2, 0.0)],
        box(0.0, 2.6, 0.5, 1.4),
        [(3.2, 0.0), (3.2, -2.0), (4.2, -2.0), (4.2, 0.0)],
    ),
    "a room with a corner": walls_of(
        [(0.0, 0.0), (6.0, 0.0), (6.0, 2.4), (3.0, 2.4), (3.0, 5.0), (0.0, 5.0), (0.0, 0.0)],
        box(4.6, 0.0, 0.6, 0.6),
    ),
    "a corridor with doors": walls_of(
        [
            (-4.0, 1.6),
            (-4.0, 0.0),
            (0.5, 0.0),
            (0.5, -2.5),
            (1.4, -2.5),
            (1.4, 0.0),
            (4.5, 0.0),
            (4.5, 1.6),
        ],
        [(-4.0, 1.6), (-1.9, 1.6), (-1.9, 4.0), (-1.0, 4.0), (-1.0, 1.6), (4.5, 1.6)],
    ),
    "a small room": walls_of(
        box(0.0, 0.0, 3.0, 2.4), box(2.3, 0.0, 0.7, 0.9), box(0.8, 2.1, 0.9, 0.3)
    ),
    "a bare corridor": walls_of([(-30.0, 0.0), (30.0, 0.0)], [(-30.0, 1.6), (30.0, 1.6)]),
    "a wide hall": walls_of(box(0.0, 0.0, 6.5, 5.5), box(2.0, 4.9, 2.5, 0.6)),
    "a square room": walls_of(box(0.0, 0.0, 4.0, 4.0)),
}
"""Segments (S, 4) by name."""


def scan(room: str, pose: Array) -> NDArray[np.float64]:
    """Metres (B,) in each direction, from left to right, at a pose (3,) in a room; at most 50."""
    walls = ROOMS[room]
    bearings = pose[2] + column_bearings(BEAMS)[:, None]
    dx, dy = np.cos(bearings), np.sin(bearings)
    ax, ay, bx, by = (walls[:, k] for k in range(4))
    ex, ey, ox, oy = bx - ax, by - ay, ax - pose[0], ay - pose[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        across = dx * ey - dy * ex
        far = (ox * ey - oy * ex) / across
        along = (ox * dy - oy * dx) / across
    hit = (far > 0) & (along >= 0) & (along <= 1)
    return np.where(hit, far, 50.0).min(axis=1)
