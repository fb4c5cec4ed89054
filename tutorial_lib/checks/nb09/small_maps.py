"""Small local maps and the lengths of paths over them, for notebook 09."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.grid_kernels import STRAIGHT, spread
from tutorial_lib.geometry import Array

CELL = 0.1
"""Metres of a cell."""


def path_lengths(free: NDArray[np.bool_]) -> Array:
    """Metres (S, S) of the shortest path from the middle of a map to each cell; inf for none.

    Args:
        free: (S, S) where a robot can be; S is odd.
    """
    side = len(free)
    cost = np.ascontiguousarray(free, dtype=np.uint8)
    length, before = np.empty((2, side * side), np.int32)
    spread(cost, side * side // 2, np.zeros_like(cost), length, before)
    metres = length.reshape(side, side) * (CELL / STRAIGHT)
    return np.where(metres >= 0, metres, np.inf)


def small_map(*walls: tuple[float, float, float, float], radius: float = 3.0) -> NDArray[np.bool_]:
    """A local map that is free but for walls: each from x, y to x, y, in metres."""
    half = round(radius / CELL) + 5
    metres = (np.arange(2 * half + 1) - half) * CELL
    x, y = np.meshgrid(metres, metres)
    free = np.ones(x.shape, bool)
    for x0, y0, x1, y1 in walls:
        inside = (x >= x0 - 1e-9) & (x <= x1 + 1e-9) & (y >= y0 - 1e-9) & (y <= y1 + 1e-9)
        free &= ~inside
    return free
