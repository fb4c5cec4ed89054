"""Rays against walls: how far, which wall, and where along it.

Two kernels give the same answer. With few walls, every ray of a fan is compared with every wall
that reaches into its wedge, without a branch in the inner loop; with many, a ray walks through a
uniform grid and meets only the walls of the cells it crosses. Moving discs (people, obstacles) come
on top.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import alike, flag, floats, instance, instances, integers, number
from tutorial_lib.world.grid_kernels import cast_grid, see
from tutorial_lib.world.ray_kernels import cast_all, cast_discs

GRID_FROM = 250
"""Number of walls from which the grid is faster (``python -m tutorial_lib bench raycast``)."""
WALLS_PER_CELL = 1.0
"""Target when the grid is laid out."""
_WEDGE = np.deg2rad(170.0)
_WIDEST_BUNDLE = 64


Grid = tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float64], float, int]


@dataclass(frozen=True)
class Discs:
    """Moving round shapes.

    Attributes:
        circles: (K, 3) x, y, radius in metres.
        owners: (K,) int32, index of the robot for which the disc exists, -1 for all robots, or
            -2 - i for all but robot i.
        colours: (K, 3) float32 RGB, 0 to 255.

    Raises:
        InputError: when they have other shapes.
    """

    circles: NDArray[np.float64]
    owners: NDArray[np.int32]
    colours: NDArray[np.float32]

    def __post_init__(self) -> None:
        circles = floats("circles", self.circles, ("K", 3))
        owners = integers("owners", self.owners, ("K",), least=-(2**31), most=2**31 - 1)
        colours = floats("colours", self.colours, ("K", 3), least=0, most=255)
        alike(circles=circles, owners=owners, colours=colours)
        object.__setattr__(self, "circles", np.ascontiguousarray(circles))
        object.__setattr__(self, "owners", np.ascontiguousarray(owners, np.int32))
        object.__setattr__(self, "colours", np.ascontiguousarray(colours, np.float32))

    @classmethod
    def joined(cls, parts: Sequence["Discs"]) -> "Discs":
        """All discs of the parts, in their order."""
        parts = instances("parts", parts, cls, empty=False)
        columns = zip(*((part.circles, part.owners, part.colours) for part in parts), strict=True)
        return cls(*(np.concatenate(column) for column in columns))


class Fan:
    """The rays of a sensor: angles from its heading, counter-clockwise, and their directions."""

    def __init__(self, angles: ArrayLike) -> None:
        """Lay out rays.

        Args:
            angles: (R,) radians, in rising order and within one turn.

        Raises:
            InputError: when they are not.
        """
        angles = floats("angles", angles, ("R",), empty=False).copy()
        if (np.diff(angles) < 0).any() or angles[-1] - angles[0] > 2 * np.pi:
            raise InputError("angles: sort them in rising order, within one turn")
        self.angles = angles
        self.directions = np.stack([np.cos(angles), np.sin(angles)])
        self.bundle = self._bundle()

    def __len__(self) -> int:
        return len(self.angles)

    def _bundle(self) -> int:
        """The most neighbouring rays that always span a wedge well below pi."""
        for size in range(min(_WIDEST_BUNDLE, len(self.angles)), 0, -1):
            first = np.arange(0, len(self.angles), size)
            last = np.minimum(first + size, len(self.angles)) - 1
            if (self.angles[last] - self.angles[first]).max() < _WEDGE:
                return size
        return 1


@dataclass(frozen=True)
class Hits:
    """What the rays met.

    Attributes:
        distance: (N, R) metres; inf where a ray met nothing.
        wall: (N, R) int32 index of the segment; for disc k the number of segments + k; -1 for none.
        along: (N, R) metres from the segment's first end, or around the disc.
    """

    distance: NDArray[np.float64]
    wall: NDArray[np.int32]
    along: NDArray[np.float64]


class Raycaster:
    """Casts fans of rays from poses onto the segments of a world.

    Whether a ray from a pose exactly on a wall meets that wall is undefined.
    """

    def __init__(self, segments: ArrayLike, grid: bool | None = None) -> None:
        """Prepare the walls.

        Args:
            segments: (S, 4) x0, y0, x1, y1 in metres.
            grid: force the grid on or off; by default it is used from `GRID_FROM` walls on.

        Raises:
            InputError: when the segments are malformed.
        """
        self.segments = segments = floats("segments", segments, ("S", 4), empty=False)
        if grid is not None:
            grid = flag("grid", grid)
        self.rows = np.ascontiguousarray(segments.T)
        self._use_grid = len(segments) >= GRID_FROM if grid is None else grid

    @cached_property
    def _grid(self) -> Grid:
        return _lay_grid(self.segments)

    def cast(
        self,
        poses: NDArray[np.float64],
        fan: Fan,
        discs: Discs | None = None,
        viewers: NDArray[np.int32] | None = None,
    ) -> Hits:
        """Cast a fan from every pose.

        Args:
            poses: (N, 3) float64.
            fan: R rays.
            discs: shapes on top of the walls.
            viewers: (N,) int32, which robot looks from each pose; by default pose i is robot i's.

        Returns:
            Hits with arrays (N, R).
        """
        poses = np.ascontiguousarray(floats("poses", poses, ("N", 3)))
        shape = (len(poses), len(instance("fan", fan, Fan)))
        distance = np.empty(shape)
        wall = np.empty(shape, np.int32)
        along = np.empty(shape)
        rays = (poses, fan.directions, fan.bundle, distance, wall, along)
        if self._use_grid:
            cast_grid(self.rows, *self._grid, *rays)
        else:
            cast_all(self.rows, *rays)
        viewers = self._viewers(viewers, poses)
        if discs is not None and len(instance("discs", discs, Discs).circles):
            shapes = (discs.circles, discs.owners, len(self.segments), viewers)
            cast_discs(*shapes, poses, fan.directions, distance, wall, along)
        return Hits(distance, wall, along)

    def _viewers(
        self, viewers: NDArray[np.int32] | None, poses: NDArray[np.float64]
    ) -> NDArray[np.int32]:
        """Which robot looks from each pose."""
        if viewers is None:
            return np.arange(len(poses), dtype=np.int32)
        if type(viewers) is not np.ndarray or viewers.dtype != np.int32 or viewers.ndim != 1:
            viewers = integers("viewers", viewers, ("N",)).astype(np.int32)
        alike(viewers=viewers, poses=poses)
        return viewers

    def sees(self, origins: ArrayLike, points: ArrayLike, slack: float = 1e-9) -> NDArray[np.bool_]:
        """Whether no wall stands between pairs of points.

        Args:
            origins: (N, 2), or one for all points.
            points: (N, 2), or one for all origins.
            slack: metres before each point that do not count, so that points on a wall can be seen.

        Returns:
            (N,) true where the line is clear.
        """
        origins, points = floats("origins", origins, ("N", 2)), floats("points", points, ("N", 2))
        if 1 not in (len(origins), len(points)):
            alike(origins=origins, points=points)
        slack = number("slack", slack, least=0)
        origins, points = (np.ascontiguousarray(e) for e in np.broadcast_arrays(origins, points))
        clear = np.empty(len(points), np.bool_)
        see(self.rows, *self._grid, origins, points, slack, clear)
        return clear


def _lay_grid(segments: NDArray[np.float64]) -> Grid:
    """Sort segments into the cells they may cross.

    Returns:
        starts (C + 1,), members (M,), the lower left corner (2,), the cell's side in metres and the
        number of columns; see `cast_grid`.
    """
    low = np.minimum(segments[:, :2], segments[:, 2:])
    high = np.maximum(segments[:, :2], segments[:, 2:])
    corner = low.min(axis=0) - 1e-6
    size = high.max(axis=0) + 1e-6 - corner
    cell = float(max(np.sqrt(size.prod() * WALLS_PER_CELL / len(segments)), size.max() / 1000))
    columns, lines = (np.floor(size / cell).astype(int) + 1).tolist()
    pairs = []
    for s, (segment, first, last) in enumerate(
        zip(
            segments,
            np.floor((low - corner) / cell).astype(int),
            np.floor((high - corner) / cell).astype(int),
            strict=True,
        )
    ):
        i, j = np.meshgrid(np.arange(first[0], last[0] + 1), np.arange(first[1], last[1] + 1))
        near = _crosses(segment, corner[0] + i * cell, corner[1] + j * cell, cell)
        pairs.append(np.stack([(j * columns + i)[near], np.full(near.sum(), s)]))
    cells, members = np.concatenate(pairs, axis=1)
    order = np.argsort(cells, kind="stable")
    starts = np.searchsorted(cells[order], np.arange(columns * lines + 1))
    members = members[order].astype(np.int32)
    return starts.astype(np.int32), members, corner, cell, columns


def _crosses(
    segment: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64], cell: float
) -> NDArray[np.bool_]:
    """Whether the line through a segment touches each cell with lower left corner (x, y)."""
    x0, y0, x1, y1 = segment
    normal = np.array([y1 - y0, x0 - x1])
    middle = normal[0] * (x + cell / 2 - x0) + normal[1] * (y + cell / 2 - y0)
    return np.abs(middle) <= (np.abs(normal).sum() * cell / 2) * (1 + 1e-9) + 1e-9
