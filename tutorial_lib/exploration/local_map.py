"""Occupancy grids around robots, from ranges and odometry."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import RADIUS, column_bearings
from tutorial_lib.exploration.grid_kernels import OCCUPIED, UNKNOWN, draw_rays
from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, floats, integers, number, whole

RESOLUTION = 0.1
"""Metres of a cell."""
REACH = RADIUS + 1.0
"""Metres up to which ranges are entered into maps."""
_MOST_ROBOTS, _MOST_SIDE = 100_000, 1_000.0  # and metres
_ABOUT = 3  # cells around a place that is closed


class LocalMaps:
    """An occupancy grid around each of N robots, in the frame of its odometry.

    What is seen now replaces what was seen before. A grid moves with its robot, and forgets what it
    leaves behind.

    Attributes:
        grids: (N, S, S) uint8 of UNKNOWN, FREE, OCCUPIED; rows run along y, columns along x.
        corners: (N, 2) x and y of each grid's first cell, metres.
    """

    def __init__(self, robots: int, side: float = 9.0, reach: float = REACH) -> None:
        """Begin with empty maps.

        Args:
            robots: N.
            side: metres of each grid.
            reach: metres up to which ranges are entered.
        """
        whole("robots", robots, least=0, most=_MOST_ROBOTS)
        number("side", side, least=RESOLUTION, most=_MOST_SIDE)
        number("reach", reach, least=0.0)
        cells = round(side / RESOLUTION)
        self._reach = reach
        self.grids = np.full((robots, cells, cells), UNKNOWN, np.uint8)
        self.corners = np.full((robots, 2), -(cells // 2) * RESOLUTION)

    def observe(
        self, robots: NDArray[np.intp], odometry: Array, ranges: NDArray[np.floating]
    ) -> None:
        """Enter what robots see.

        Args:
            robots: (M,) indices.
            odometry: (M, 3) their poses.
            ranges: (M, W) metres in each column of the panorama, at least two.

        Raises:
            InputError: when an argument is no such array, or one is shorter than another.
        """
        robots, odometry = self._checked(robots, "odometry", odometry, 3)
        ranges = np.ascontiguousarray(floats("ranges", ranges, ("M", "W"), infinite=True))
        alike(robots=robots, ranges=ranges)
        if ranges.shape[1] < 2:
            raise InputError(f"ranges: {ranges.shape[1]} columns; give two at least")
        self._follow(robots, odometry)
        rays = (ranges, column_bearings(ranges.shape[1]), self._reach)
        draw_rays(self.grids, self.corners, RESOLUTION, robots, odometry, *rays)

    def forget(self, robot: int) -> None:
        """Empty the grid of a robot."""
        self.grids[whole("robot", robot, least=0, most=len(self.grids) - 1)] = UNKNOWN

    def checked(self, robots: NDArray[np.intp], odometry: Array) -> tuple[NDArray[np.intp], Array]:
        """Indices (M,) of robots that have a grid, and their poses (M, 3).

        Raises:
            InputError: when an argument is no such array, or one is shorter than the other.
        """
        return self._checked(robots, "odometry", odometry, 3)

    def cells(self, robots: NDArray[np.intp], points: Array) -> NDArray[np.intp]:
        """Flat indices (M,) of the cells with points (M, 2), clipped to the grids."""
        side = self.grids.shape[1]
        robots, points = self._checked(robots, "points", points, 2)
        found = np.floor((points - self.corners[robots]) / RESOLUTION).astype(np.intp)
        found = np.clip(found, 0, side - 1)
        return found[:, 1] * side + found[:, 0]

    def centres(self, robots: NDArray[np.intp], cells: NDArray[np.integer]) -> Array:
        """The middles (M, 2) of cells (M,), each in its robot's grid."""
        side = self.grids.shape[1]
        robots = integers("robots", robots, ("M",), least=0, most=len(self.grids) - 1)
        cells = integers("cells", cells, ("M",), least=0, most=side * side - 1)
        alike(robots=robots, cells=cells)
        row, column = np.divmod(cells, side)
        return self.corners[robots] + (np.stack([column, row], axis=1) + 0.5) * RESOLUTION

    def close(self, robots: NDArray[np.intp], points: Array) -> None:
        """Take what is not seen about points (M, 2) for occupied, until it is seen.

        A robot that stands there and does not see it never will.
        """
        side = self.grids.shape[1]
        robots, points = self._checked(robots, "points", points, 2)
        for robot, cell in zip(robots, self.cells(robots, points), strict=True):
            row, column = divmod(int(cell), side)
            rows = slice(max(row - _ABOUT, 0), row + _ABOUT + 1)
            columns = slice(max(column - _ABOUT, 0), column + _ABOUT + 1)
            part = self.grids[robot, rows, columns]
            part[part == UNKNOWN] = OCCUPIED

    def _checked(
        self, robots: NDArray[np.intp], name: str, values: Array, columns: int
    ) -> tuple[NDArray[np.intp], Array]:
        """Robots (M,) and what belongs to each, (M, columns)."""
        robots = integers("robots", robots, ("M",), least=0, most=len(self.grids) - 1)
        values = np.ascontiguousarray(floats(name, values, ("M", columns)))
        alike(robots=robots, **{name: values})
        return robots, values

    def _follow(self, robots: NDArray[np.intp], odometry: Array) -> None:
        """Move the grids whose robots left the middle, by whole cells."""
        side = self.grids.shape[1]
        middle = self.corners[robots] + side / 2 * RESOLUTION
        shift = np.rint((odometry[:, :2] - middle) / RESOLUTION).astype(int)
        for robot, (right, up) in zip(robots, shift, strict=True):
            if max(abs(right), abs(up)) <= side // 8:
                continue
            moved = np.full((side, side), UNKNOWN, np.uint8)
            rows, columns = _overlap(up, side), _overlap(right, side)
            moved[rows[1], columns[1]] = self.grids[robot][rows[0], columns[0]]
            self.grids[robot] = moved
            self.corners[robot] += np.array([right, up]) * RESOLUTION


def _overlap(shift: int, side: int) -> tuple[slice, slice]:
    """Which cells along an axis stay, before and after a shift."""
    stay = max(side - abs(shift), 0)
    before = min(max(shift, 0), side)
    after = min(max(-shift, 0), side)
    return slice(before, before + stay), slice(after, after + stay)
