"""Offices in which many rooms look exactly alike, and trials that start in such rooms (Fig. 12)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    recorded_between,
)
from tutorial_lib.experiments.protocols.odometry import Odometry
from tutorial_lib.geometry import Array, distance_to_segments
from tutorial_lib.se2 import to_local
from tutorial_lib.validation import flag, whole
from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of, world_name

TWINS, UNIQUE = 6, 4
"""Places in rooms that have a twin, and in rooms that have none."""
FAMILY = "symmetric_office"
_ROUNDING = 0.005  # metres, in plans whose corners are whole millimetres
_Look = dict[tuple[str | int, ...], list[Array]]
"""Walls and furniture of a room: their coordinates, by what they are made of."""


@dataclass(frozen=True, eq=False)
class Office:
    """An office with look-alike rooms.

    Attributes:
        building: with places in both kinds of rooms.
        group: (R,) for each room of the plan the number of its group; rooms of one group are
            exactly alike.
        rooms: (P,) the room of each place.
    """

    building: Building
    group: NDArray[np.intp]
    rooms: NDArray[np.intp]

    @property
    def twin(self) -> NDArray[np.bool_]:
        """(P,) whether the room of each place has a twin."""
        return (np.bincount(self.group)[self.group] > 1)[self.rooms]


def make_office(
    world: int, seed: int, twins: int = TWINS, unique: int = UNIQUE, *, drifts: bool = True
) -> Office:
    """Choose places in rooms of a symmetric office, and record trajectories between them.

    Args:
        world: seed of the office.
        seed: of everything else that is random.
        twins: places in rooms that have a twin.
        unique: places in rooms that have none.
        drifts: whether the robots' odometry does.

    Raises:
        InputError: when no trajectory joins any two places.
    """
    world, seed = whole("world", world, least=0), whole("seed", seed, least=0)
    twins, unique = whole("twins", twins, least=0), whole("unique", unique, least=0)
    drifts = flag("drifts", drifts)
    name = world_name(FAMILY, world, size="large")
    scene = scene_of(name)
    paths, group = GridPaths(scene.clearance), alike_rooms(scene.plan)
    twin = np.bincount(group)[group] > 1
    places, rooms = _middles(scene, paths)
    rng = np.random.default_rng((seed, world, 7))
    chosen = np.concatenate(
        [
            _spread(paths, places, np.flatnonzero(kind[rooms]), count, rng)
            for kind, count in ((twin, twins), (~twin, unique))
        ]
    )
    odometry = Odometry(drifts, (seed, world))
    building = recorded_between(name, scene, paths, places[chosen], odometry)
    return Office(building, group, rooms[chosen])


def draw_ambiguous_trials(office: Office, count: int, rng: np.random.Generator) -> Trials:
    """Draw trials from rooms that have a twin, to pictures of rooms that have none."""
    starts, goals = office.building.pairs.T
    among = np.flatnonzero(office.twin[starts] & ~office.twin[goals])
    return draw_trials(office.building, count, rng, among)


def alike_rooms(plan: FloorPlan) -> NDArray[np.intp]:
    """(R,) the group of each room: rooms of one group have the same walls, colours and furniture.

    A room is looked at from its first corner, along its first wall, as it was drawn. Copies may
    differ by a rounding, which no camera sees.
    """
    looks = [_look(plan, room) for room in plan.rooms]
    group = np.arange(len(looks))
    for room, look in enumerate(looks):
        twins = [other for other in range(room) if _alike(look, looks[other])]
        group[room] = group[twins[0]] if twins else room
    return np.unique(group, return_inverse=True)[1]


def _look(plan: FloorPlan, room: Room) -> _Look:
    """Walls and furniture of a room in the frame of its first corner."""
    corners = np.asarray(room.outline)
    ahead = corners[1] - corners[0]
    frame = np.array([*corners[0], np.arctan2(ahead[1], ahead[0])])
    look: _Look = {}

    def add(what: tuple[str, ...], points: Array, *more: float) -> None:
        shape = np.append(to_local(frame, points).ravel(), more)
        look.setdefault((*what, len(shape)), []).append(shape)

    for i, (x0, y0, x1, y1) in enumerate(plan.walls[:, :4]):
        ends = np.array([[x0, y0], [x1, y1]])
        if plan.wall_materials[i] != "door frame" and _on_outline(corners, ends.mean(axis=0)):
            add(("wall", plan.wall_materials[i]), ends, float(plan.wall_offsets[i]))
    for piece in plan.furniture:
        outline = np.asarray(piece.outline)
        if room.contains(outline.mean(axis=0)):
            add((piece.kind, piece.material), outline)
    return look


def _alike(one: _Look, other: _Look) -> bool:
    """Whether each wall and piece of either room has its like in the other."""
    if {what: len(shapes) for what, shapes in one.items()} != {
        what: len(shapes) for what, shapes in other.items()
    }:
        return False
    for what, shapes in one.items():
        gaps = np.abs(np.array(shapes)[:, None] - np.array(other[what])).max(axis=2)
        if gaps.min(axis=0).max() > _ROUNDING or gaps.min(axis=1).max() > _ROUNDING:
            return False
    return True


def _on_outline(corners: Array, point: Array) -> bool:
    """Whether a point lies on a wall of a room."""
    outline = np.hstack([corners, np.roll(corners, -1, axis=0)])
    return bool(distance_to_segments(point[None], outline).min() < 1e-6)


def _middles(scene: Scene, paths: GridPaths) -> tuple[Array, NDArray[np.intp]]:
    """The roomiest point (P, 2) of each room that can be driven to, and the rooms (P,)."""
    points, rooms = [], []
    for number, room in enumerate(scene.plan.rooms):
        inside = np.flatnonzero(paths.largest & room.contains(paths.points))
        if room.kind != "hallway" and inside.size:
            points.append(paths.points[inside[paths.clearance[inside].argmax()]])
            rooms.append(number)
    return np.array(points), np.array(rooms)


def _spread(
    paths: GridPaths, places: Array, kept: NDArray[np.intp], count: int, rng: np.random.Generator
) -> NDArray[np.intp]:
    """At most `count` of the places `kept`, each as far from the others as possible."""
    if not len(kept):
        return kept
    chosen = [int(rng.integers(len(kept)))]
    nearest = np.full(len(kept), np.inf)
    while len(chosen) < min(count, len(kept)):
        here = np.tile(places[kept[chosen[-1]]], (len(kept), 1))
        nearest = np.minimum(nearest, paths.between(here, places[kept]))
        chosen.append(int(nearest.argmax()))
    return kept[chosen]
