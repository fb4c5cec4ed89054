"""Labels of panoramas and of pairs of them, from geometry (Chaplot et al. 2020, appendix B)."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.bearings import (
    DIRECTIONS,
    RADIUS,
    bearing_of,
    bin_of,
    column_bearings,
    column_of,
)
from tutorial_lib.exploration.grid_kernels import DIAGONAL, KNIGHT, STRAIGHT, spread
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.world.floorplan import ROOM_KINDS, FloorPlan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera

MAX_DISTANCE = 20.0
"""Geodesic metres at which a semantic score is 0, d_max of the paper."""
DETOUR = 1.05
"""Times the straight line that a path to an explorable point may be long."""
CLEARANCE = 0.2
"""Metres of clearance of what is traversable: the robot's radius and a little more."""
NO_ROOM = len(ROOM_KINDS)
"""Number of the kind of a place in no room, such as a doorway."""
_STEP = 0.1  # metres between the points of a direction that are tested
_CELL = 0.1
_AT_ONCE = 64  # distance fields are held in memory


class PanoramaLabels:
    """Labels of N panoramas of one world; pairs are given as indices of sources and of goals.

    Attributes:
        scene: the world.
        poses: (N, 3) where they were taken.
        ranges: (N, W) metres to the wall in each column, as `PanoramicCamera` returns depth.
    """

    def __init__(
        self,
        scene: Scene,
        poses: ArrayLike,
        ranges: NDArray[np.floating] | None = None,
        *,
        directions: int = DIRECTIONS,
        radius: float = RADIUS,
    ) -> None:
        """Label panoramas.

        Args:
            scene: the world.
            poses: (N, 3).
            ranges: (N, W); cast by the usual camera unless given.
            directions: of each panorama; 12 in the paper.
            radius: metres of a node; 3 in the paper.
        """
        self.scene, self.poses = scene, np.asarray(poses, dtype=float).reshape(-1, 3)
        self.ranges = panorama_ranges(scene, self.poses) if ranges is None else ranges
        self._directions, self._radius = directions, radius
        self._metres: dict[int, Array] = {}

    @cached_property
    def explorable(self) -> NDArray[np.bool_]:
        """(N, K) labels of F_G, see `explorable`."""
        return explorable(self.ranges, self._directions, self._radius)

    @cached_property
    def _ends(self) -> tuple[Array, Array]:
        return direction_ends(self.scene, self.poses, self._directions, self._radius)

    @property
    def ends(self) -> Array:
        """(N, K, 2) the farthest traversable point of each direction within the local map."""
        return self._ends[0]

    @property
    def lengths(self) -> Array:
        """(N, K) metres up to these points."""
        return self._ends[1]

    @cached_property
    def rooms(self) -> NDArray[np.intp]:
        """(N,) the kind of room of each place, see `room_kinds`."""
        return room_kinds(self.scene.plan, self.poses[:, :2])

    @cached_property
    def end_rooms(self) -> NDArray[np.intp]:
        """(N, K) the kind of room at each direction's end."""
        points = self.ends.reshape(-1, 2)
        return room_kinds(self.scene.plan, points).reshape(self.lengths.shape)

    def connected(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(P,) labels of F_L, see `connected`."""
        bearing, metres = self.relative(sources, goals).T
        return connected(self.ranges[sources], bearing, metres, self._radius)

    def relative(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> Array:
        """(P, 2) of F_R: bearing in the source's frame in rad, and metres in a straight line."""
        return relative_polar(self.poses[sources], self.poses[goals, :2])

    def intra_node(
        self, sources: NDArray[np.intp], goals: NDArray[np.intp]
    ) -> tuple[NDArray[np.intp], Array]:
        """(P,) bins of the goal's bearing, and (P,) scores max(1 - d / r, 0) of its distance."""
        bearing, metres = self.relative(sources, goals).T
        return bin_of(bearing, self._directions), np.maximum(1 - metres / self._radius, 0.0)

    def scores(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> Array:
        """(P, K) labels of F_S: max(1 - d / 20 m, 0), d from each direction's end to the goal."""
        return np.maximum(1 - self.metres(sources, goals)[:, :-1] / MAX_DISTANCE, 0.0)

    def metres(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> Array:
        """(P, K + 1) geodesic metres to the goal, from each direction's end and from the source.

        A shortest path needs a distance field of the goal, which is computed once for each goal:
        pairs that share goals are cheap.
        """
        self._measure(np.unique(goals))
        rows = [self._metres[goal][source] for source, goal in zip(sources, goals, strict=True)]
        return np.array(rows).reshape(len(rows), self._directions + 1)

    @cached_property
    def _paths(self) -> GridPaths:
        return GridPaths(self.scene.clearance)

    def _measure(self, goals: NDArray[np.intp]) -> None:
        """Compute the distances to those goals that are not known yet."""
        missing = [goal for goal in goals.tolist() if goal not in self._metres]
        places = np.concatenate([self.ends, self.poses[:, None, :2]], axis=1)
        for first in range(0, len(missing), _AT_ONCE):
            some = missing[first : first + _AT_ONCE]
            fields = self._paths.fields(self.poses[some, :2], shortest=True)
            for row, goal in enumerate(some):
                far = fields.distance(places.reshape(-1, 2), row).reshape(places.shape[:2])
                self._metres[goal] = far


def panorama_ranges(scene: Scene, poses: Array) -> Array:
    """Metres (N, W) to the wall in each column of the usual panorama."""
    fan = PanoramicCamera().fan
    return np.ascontiguousarray(scene.caster.cast(poses, fan).distance[:, ::-1])


def relative_polar(poses: ArrayLike, points: ArrayLike) -> Array:
    """Bearing in rad and distance in metres (..., 2) of points (..., 2) in the frames of poses."""
    local = to_local(poses, points)
    bearing = np.arctan2(local[..., 1], local[..., 0])
    return np.stack([bearing, np.linalg.norm(local, axis=-1)], axis=-1)


def connected(
    ranges: NDArray[np.floating], bearings: Array, metres: Array, radius: float = RADIUS
) -> NDArray[np.bool_]:
    """Whether a goal belongs to a source's node: within `radius`, and visible from there.

    It is visible where the largest depth within 5 degrees about its direction exceeds its distance.

    Args:
        ranges: (P, W) depth of the sources.
        bearings: (P,) of the goals in the sources' frames.
        metres: (P,) to the goals.
        radius: metres.
    """
    count = ranges.shape[-1]
    half = int(np.deg2rad(2.5) / (2 * np.pi / count))
    columns = column_of(bearings, count)[:, None] + np.arange(-half, half + 1)
    farthest = np.take_along_axis(ranges, columns % count, axis=1).max(axis=1)
    return (farthest > metres) & (metres <= radius)


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
        radius: metres.
    """
    ranges = np.ascontiguousarray(ranges, dtype=np.float64)
    bearings = column_bearings(ranges.shape[1])
    found = np.empty((len(ranges), directions), np.bool_)
    _explorable(ranges, bearings, bearing_of(np.arange(directions), directions), radius, found)
    return found


def direction_ends(
    scene: Scene, poses: Array, directions: int = DIRECTIONS, radius: float = RADIUS
) -> tuple[Array, Array]:
    """The farthest traversable point of each direction, in a straight line within `radius`.

    Args:
        scene: the world.
        poses: (P, 3).
        directions: K.
        radius: metres.

    Returns:
        ends (P, K, 2), and metres (P, K) up to them; 0 where the first step is blocked.
    """
    headings = poses[:, 2:] + np.arange(directions) * 2 * np.pi / directions
    ahead = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    steps = np.arange(_STEP, radius + _STEP / 2, _STEP)
    points = poses[:, None, None, :2] + steps[:, None] * ahead[:, :, None]
    free = np.logical_and.accumulate(scene.clearance.at(points) >= CLEARANCE, axis=2)
    metres = _STEP * free.sum(axis=2)
    return poses[:, None, :2] + metres[..., None] * ahead, metres


def room_kinds(plan: FloorPlan, points: Array) -> NDArray[np.intp]:
    """(N,) the kind of the room in which each point (N, 2) lies, as index in `ROOM_KINDS`."""
    kinds = np.full(len(points), NO_ROOM)
    for room in plan.rooms:
        kinds[room.contains(points)] = ROOM_KINDS.index(room.kind)
    return kinds


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
