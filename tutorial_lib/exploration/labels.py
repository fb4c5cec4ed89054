"""Labels of panoramas and of pairs of them, from geometry (Chaplot et al. 2020, appendix B)."""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.bearings import (
    DIRECTIONS,
    RADIUS,
    column_of,
)
from tutorial_lib.exploration.explorable import CLEARANCE, explorable
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.validation import alike, floats, instance, integers, number, whole
from tutorial_lib.world.floorplan import ROOM_KINDS, FloorPlan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera

MAX_DISTANCE = 20.0
"""Geodesic metres at which a semantic score is 0, d_max of the paper."""
NO_ROOM = len(ROOM_KINDS)
"""Number of the kind of a place in no room, such as a doorway."""
_STEP = 0.1  # metres between the points of a direction that are tested
_MOST, _FAR = 10_000, 100.0  # directions, and metres of a node
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
        self.scene = instance("scene", scene, Scene)
        self.poses = np.atleast_2d(floats("poses", poses, (..., 3))).reshape(-1, 3)
        if ranges is not None:
            rows = floats("ranges", ranges, ("N", "W"), least=0.0, infinite=True)
            alike(poses=self.poses, ranges=rows)
        whole("directions", directions, least=1, most=_MOST)
        number("radius", radius, least=_STEP, most=_FAR)
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
        sources, goals = self._pairs(sources, goals)
        bearing, metres = self.relative(sources, goals).T
        return connected(self.ranges[sources], bearing, metres, self._radius)

    def relative(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> Array:
        """(P, 2) of F_R: bearing in the source's frame in rad, and metres in a straight line."""
        sources, goals = self._pairs(sources, goals)
        return relative_polar(self.poses[sources], self.poses[goals, :2])

    def scores(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> Array:
        """(P, K) labels of F_S: max(1 - d / 20 m, 0), d from each direction's end to the goal."""
        return np.maximum(1 - self.metres(sources, goals)[:, :-1] / MAX_DISTANCE, 0.0)

    def metres(self, sources: NDArray[np.intp], goals: NDArray[np.intp]) -> Array:
        """(P, K + 1) geodesic metres to the goal, from each direction's end and from the source.

        A shortest path needs a distance field of the goal, which is computed once for each goal:
        pairs that share goals are cheap.
        """
        sources, goals = self._pairs(sources, goals)
        places, which = np.unique(goals, return_inverse=True)
        if not len(places):
            return np.empty((0, self._directions + 1))
        self._measure(places)
        return np.stack([self._metres[goal] for goal in places.tolist()])[which, sources]

    def _pairs(
        self, sources: NDArray[np.intp], goals: NDArray[np.intp]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        sources = integers("sources", sources, ("P",), least=0, most=len(self.poses) - 1)
        goals = integers("goals", goals, ("P",), least=0, most=len(self.poses) - 1)
        alike(sources=sources, goals=goals)
        return sources, goals

    @cached_property
    def _paths(self) -> GridPaths:
        return GridPaths(self.scene.clearance)

    def _measure(self, goals: NDArray[np.intp]) -> None:
        """Compute the distances to those goals that are not known yet."""
        missing = [goal for goal in goals.tolist() if goal not in self._metres]
        places = np.concatenate([self.ends, self.poses[:, None, :2]], axis=1)
        for first in range(0, len(missing), _AT_ONCE):
            chunk = missing[first : first + _AT_ONCE]
            fields = self._paths.fields(self.poses[chunk, :2], shortest=True)
            for row, goal in enumerate(chunk):
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
    floats("ranges", ranges, ("P", "W"), least=0.0, infinite=True)
    bearings = floats("bearings", bearings, ("P",))
    metres = floats("metres", metres, ("P",), least=0.0)
    number("radius", radius, least=0.0)
    alike(ranges=ranges, bearings=bearings, metres=metres)
    count = ranges.shape[-1]
    half = int(np.deg2rad(2.5) / (2 * np.pi / count))
    columns = column_of(bearings, count)[:, None] + np.arange(-half, half + 1)
    farthest = np.take_along_axis(ranges, columns % count, axis=1).max(axis=1)
    return (farthest > metres) & (metres <= radius)


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
    instance("scene", scene, Scene)
    poses = floats("poses", poses, ("P", 3))
    whole("directions", directions, least=1, most=_MOST)
    number("radius", radius, least=_STEP, most=_FAR)
    headings = poses[:, 2:] + np.arange(directions) * 2 * np.pi / directions
    ahead = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    steps = np.arange(_STEP, radius + _STEP / 2, _STEP)
    points = poses[:, None, None, :2] + steps[:, None] * ahead[:, :, None]
    free = np.logical_and.accumulate(scene.clearance.at(points) >= CLEARANCE, axis=2)
    metres = _STEP * free.sum(axis=2)
    return poses[:, None, :2] + metres[..., None] * ahead, metres


def room_kinds(plan: FloorPlan, points: Array) -> NDArray[np.intp]:
    """(N,) the kind of the room in which each point (N, 2) lies, as index in `ROOM_KINDS`."""
    instance("plan", plan, FloorPlan)
    points = floats("points", points, ("N", 2))
    kinds = np.full(len(points), NO_ROOM)
    for room in plan.rooms:
        kinds[room.contains(points)] = ROOM_KINDS.index(room.kind)
    return kinds
