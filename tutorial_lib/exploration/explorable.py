"""F_G's labels: which directions of a panorama lead to explorable area (Chaplot et al. 2020, B)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, bearing_of, column_bearings
from tutorial_lib.exploration.grid_kernels import DIAGONAL, KNIGHT, STRAIGHT, spread
from tutorial_lib.geometry import Array
from tutorial_lib.validation import floats, number, whole

DETOUR = 1.05
"""Times the straight line that a path to an explorable point may be long."""
CLEARANCE = 0.2
"""Metres of clearance of what is traversable: the robot's radius and a little more."""
_CELL = 0.1  # metres
_LARGEST = 50.0  # metres of a radius, whose map has to fit in memory


def explorable(
    ranges: NDArray[np.floating], directions: int = DIRECTIONS, radius: float = RADIUS
) -> NDArray[np.bool_]:
    """F_G's labels (N, K): whether the point at `radius` in a direction is easy to get to.

    In a map of the obstacles that the panorama shows within `radius`, the path to the point is at
    most 1.05 times as long as it were without obstacles. A robot needs room: obstacles block what
    is within `CLEARANCE` of them, those just beyond the map too.

    Args:
        ranges: (N, W) depth of the panoramas.
        directions: K.
        radius: metres, up to 50.

    Raises:
        InputError: when an argument is anything else.
    """
    ranges = floats("ranges", ranges, ("N", "W"), least=0.0, infinite=True)
    ranges = np.ascontiguousarray(ranges)
    directions = whole("directions", directions, least=1)
    radius = number("radius", radius, least=0.0, most=_LARGEST)
    bearings = column_bearings(ranges.shape[1])
    found = np.empty((len(ranges), directions), np.bool_)
    _explorable(ranges, bearings, bearing_of(np.arange(directions), directions), radius, found)
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _explorable(
    ranges: Array, bearings: Array, directions: Array, radius: float, found: NDArray[np.bool_]
) -> None:
    """See `explorable`: a map in the source's frame, with its middle cell around the source."""
    half = int(np.ceil(DETOUR * radius / _CELL)) + 1
    side, room = 2 * half + 1, int(CLEARANCE / _CELL) + 1
    cost, ends = np.empty((side, side), np.uint8), np.zeros((side, side), np.uint8)
    length, parent = np.empty(side * side, np.int32), np.empty(side * side, np.int32)
    for n in range(len(ranges)):
        cost[:] = 1
        for ray in range(len(bearings)):
            if ranges[n, ray] >= radius + CLEARANCE:  # nearer ones reach into the map
                continue
            x = ranges[n, ray] * np.cos(bearings[ray]) / _CELL + half
            y = ranges[n, ray] * np.sin(bearings[ray]) / _CELL + half
            for i in range(int(y) - room, int(y) + room + 2):
                for j in range(int(x) - room, int(x) + room + 2):
                    near = (i - y) ** 2 + (j - x) ** 2 < (CLEARANCE / _CELL) ** 2
                    if near and 0 <= i < side and 0 <= j < side:
                        cost[i, j] = 0
        spread(cost, half * side + half, ends, length, parent)
        for k in range(len(directions)):
            right = int(np.rint(radius * np.cos(directions[k]) / _CELL))
            up = int(np.rint(radius * np.sin(directions[k]) / _CELL))
            far = length[(half + up) * side + half + right]
            found[n, k] = 0 <= far <= DETOUR * _unobstructed(right, up)


@njit(cache=True, nogil=True, error_model="numpy")
def _unobstructed(right: int, up: int) -> int:
    """Length of the shortest path by so many cells where nothing is in the way."""
    more, less = max(abs(right), abs(up)), min(abs(right), abs(up))
    if more >= 2 * less:
        return (more - 2 * less) * STRAIGHT + less * KNIGHT
    return (more - less) * KNIGHT + (2 * less - more) * DIAGONAL
