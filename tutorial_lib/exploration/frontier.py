"""Frontiers of a metric map: where what is known to be free ends (Yamauchi 1997)."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.exploration.grid_kernels import (
    FREE,
    UNKNOWN,
    Bytes,
    costs_of,
    path_length,
    spread,
)
from tutorial_lib.exploration.local_map import RESOLUTION, LocalMaps
from tutorial_lib.exploration.local_policy import BODY, COMFORT, NEAR
from tutorial_lib.geometry import Array
from tutorial_lib.validation import fit_together, floats, integers

SIDE = 24.0
"""Metres of a metric map; a robot that leaves its middle forgets what is far behind it."""
CROP = 96
"""Cells along a side of the part of the map that a scorer gets."""
SMALLEST = 9
"""Cells of a frontier about each of its cells, itself included: through fewer no robot fits."""
_ABOUT = 4  # cells to either side among which they are counted
_BLOCK = 10  # cells along a side of the squares of which each gives one frontier, at most


@dataclass(frozen=True)
class Frontiers:
    """F frontiers of the maps of several robots.

    Paths keep off the walls where they can, so that the nearest frontier need not have the shortest
    of them.

    Attributes:
        robots: (F,) whose map, an index in the arrays that were given.
        places: (F, 2) in the frame of the robot's odometry.
        metres: (F,) length of the path there.
    """

    robots: NDArray[np.intp]
    places: Array
    metres: Array


def nearest_frontiers(maps: LocalMaps, robots: NDArray[np.intp], odometry: Array) -> Frontiers:
    """The frontier that each robot can reach soonest; robots without one are left out.

    Args:
        maps: of N robots.
        robots: (M,) indices.
        odometry: (M, 3) their poses.

    Raises:
        InputError: when an argument is no such array, or one is shorter than the other.
    """
    return _frontiers(maps, robots, odometry, nearest=True)


def all_frontiers(maps: LocalMaps, robots: NDArray[np.intp], odometry: Array) -> Frontiers:
    """The frontiers that robots can reach, one in every square metre; as `nearest_frontiers`."""
    return _frontiers(maps, robots, odometry, nearest=False)


def is_frontier(maps: LocalMaps, robots: NDArray[np.intp], places: Array) -> NDArray[np.bool_]:
    """(M,) whether a place (M, 2) is a frontier of its robot's map still.

    Raises:
        InputError: when an argument is no such array, or one is shorter than the other.
    """
    places = floats("places", places, ("M", 2))
    robots = integers("robots", robots, ("M",), least=0, most=len(maps.grids) - 1)
    fit_together(robots=(robots, ("M",)), places=(places, ("M", 2)))
    return _are_frontiers(maps.grids, robots, maps.cells(robots, places))


def crops(maps: LocalMaps, robots: NDArray[np.intp], odometry: Array, side: int) -> Bytes:
    """Maps (M, side, side) around robots, in their own frames: x along columns, y along rows."""
    axis = (np.arange(side) - (side - 1) / 2) * RESOLUTION
    x, y = np.meshgrid(axis, axis)
    cos, sin = np.cos(odometry[:, 2])[:, None, None], np.sin(odometry[:, 2])[:, None, None]
    east = odometry[:, 0, None, None] + cos * x - sin * y
    north = odometry[:, 1, None, None] + sin * x + cos * y
    points = np.stack([east, north], axis=-1) - maps.corners[robots][:, None, None]
    cells = np.floor(points / RESOLUTION).astype(np.intp)
    count = maps.grids.shape[1]
    inside = ((cells >= 0) & (cells < count)).all(axis=-1)
    cells = np.clip(cells, 0, count - 1)
    found = maps.grids[robots[:, None, None], cells[..., 1], cells[..., 0]]
    return np.where(inside, found, np.uint8(UNKNOWN))


def _frontiers(
    maps: LocalMaps, robots: NDArray[np.intp], odometry: Array, *, nearest: bool
) -> Frontiers:
    robots, odometry = maps.checked(robots, odometry)
    blocks = 1 if nearest else (maps.grids.shape[1] // _BLOCK + 1) ** 2
    found = np.full((len(robots), blocks), -1)
    metres = np.zeros(found.shape)
    _search(maps.grids, robots, maps.cells(robots, odometry[:, :2]), nearest, found, metres)
    rows, columns = np.nonzero(found >= 0)
    places = maps.centres(robots[rows], found[rows, columns])
    return Frontiers(rows, places, metres[rows, columns])


@njit(cache=True, nogil=True, error_model="numpy")
def _edge(grid: Bytes, row: int, column: int) -> bool:
    """Whether a cell is free, and one beside it unknown."""
    side = len(grid)
    if grid[row, column] != FREE or not (0 < row < side - 1 and 0 < column < side - 1):
        return False
    return (
        grid[row - 1, column] == UNKNOWN
        or grid[row + 1, column] == UNKNOWN
        or grid[row, column - 1] == UNKNOWN
        or grid[row, column + 1] == UNKNOWN
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _is_frontier(grid: Bytes, row: int, column: int) -> bool:
    """Whether a cell belongs to a frontier that is no gap between rays."""
    if not _edge(grid, row, column):
        return False
    side, count = len(grid), 0
    for i in range(max(row - _ABOUT, 0), min(row + _ABOUT + 1, side)):
        for j in range(max(column - _ABOUT, 0), min(column + _ABOUT + 1, side)):
            count += _edge(grid, i, j)
    return count >= SMALLEST


@njit(cache=True, nogil=True, error_model="numpy")
def _are_frontiers(
    grids: Bytes, robots: NDArray[np.intp], cells: NDArray[np.intp]
) -> NDArray[np.bool_]:
    side = grids.shape[1]
    found = np.zeros(len(robots), np.bool_)
    for m in range(len(robots)):
        found[m] = _is_frontier(grids[robots[m]], cells[m] // side, cells[m] % side)
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _search(
    grids: Bytes,
    robots: NDArray[np.intp],
    starts: NDArray[np.intp],
    nearest: bool,
    found: NDArray[np.intp],
    metres: Array,
) -> None:
    """Write cells of frontiers (M, F): the nearest one, or the nearest one of each square."""
    side = grids.shape[1]
    cost, ends = np.empty((side, side), np.uint8), np.empty((side, side), np.uint8)
    none = np.zeros((side, side), np.uint8)
    length, parent = np.empty(side * side, np.int32), np.empty(side * side, np.int32)
    for m in range(len(robots)):
        grid = grids[robots[m]]
        costs_of(grid, BODY, COMFORT, NEAR, 0, starts[m], cost)
        for row in range(side):
            for column in range(side):
                ends[row, column] = cost[row, column] > 0 and _is_frontier(grid, row, column)
        cell = spread(cost, starts[m], ends if nearest else none, length, parent)
        if nearest:
            found[m, 0] = cell
            metres[m, 0] = RESOLUTION * path_length(parent, cell, side) if cell >= 0 else 0.0
            continue
        for cell in range(side * side):
            row, column = cell // side, cell % side
            if ends[row, column] and length[cell] >= 0:
                block = row // _BLOCK * (side // _BLOCK + 1) + column // _BLOCK
                if found[m, block] < 0 or length[cell] < length[found[m, block]]:
                    found[m, block] = cell
        for block in range(found.shape[1]):
            if found[m, block] >= 0:
                metres[m, block] = RESOLUTION * path_length(parent, found[m, block], side)
