"""A building that changes during a life, and its task: doors close and open, furniture moves."""

from dataclasses import replace

import networkx as nx
import numpy as np

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.geometry import Array, to_world
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.floorplan import Door, FloorPlan, Furniture
from tutorial_lib.world.generators.furnish import box_of
from tutorial_lib.world.generators.rectilinear import overlap
from tutorial_lib.world.scene import Scene

MOVED = 0.2
"""Share of the furniture that is moved within its room, where there is another place for it."""
_DEPTH = 0.4  # metres of the cupboard that closes a door
_FREE = 0.6  # metres around goals and starts in which nothing is put
_AT_DOOR = 0.75  # metres around the middle of a door in which nothing is put
_TRIES = 20  # to find a place for a piece, and pieces that leave all places within reach


def changed(scene: Scene, stops: Array, rng: np.random.Generator) -> tuple[Scene, Scene] | None:
    """A building before and after it changes; none where no two doors have a detour.

    The door that closes is the one without which the robots drive farthest.

    Args:
        scene: with all doors open.
        stops: (V, N, 2) where N robots start, and their goals; they stay free, and within reach.
        rng: chooses the door that opens, and furniture.
    """
    plan, places = scene.plan, stops.reshape(-1, 2)
    closed = [(Scene(_closed(plan, door)), door) for door in _doors_with_detour(plan, places)]
    metres = [_metres(without, stops) for without, _ in closed]
    order = [i for i in np.argsort(metres)[::-1] if np.isfinite(metres[i])]
    if len(order) < 2:
        return None
    last, first = order[0], rng.choice(order[1:])
    return closed[first][0], _rearranged(closed[last][0], stops, rng)


def _doors_with_detour(plan: FloorPlan, places: Array) -> list[Door]:
    """Doors on a circle of rooms, away from places (K, 2)."""
    rooms = nx.MultiGraph([door.rooms for door in plan.doors])
    dead_ends = {frozenset(edge) for edge in nx.bridges(nx.Graph(rooms))}
    found = []
    for door in plan.doors:
        several = rooms.number_of_edges(*door.rooms) > 1
        away = np.linalg.norm(places - _middle(door), axis=1).min() > _AT_DOOR
        if away and (several or frozenset(door.rooms) not in dead_ends):
            found.append(door)
    return found


def _middle(door: Door) -> Array:
    return np.add(door.start, door.end) / 2


def _closed(plan: FloorPlan, door: Door) -> FloorPlan:
    """The plan with a cupboard in a door."""
    ahead = np.subtract(door.end, door.start)
    aside = _DEPTH / 2 * np.array([-ahead[1], ahead[0]]) / door.width
    corners = [door.start - aside, door.end - aside, door.end + aside, door.start + aside]
    material = plan.furniture[0].material if plan.furniture else plan.materials[0].name
    cupboard = Furniture("cupboard", _outline(np.array(corners)), material)
    return replace(plan, furniture=(*plan.furniture, cupboard))


def _rearranged(scene: Scene, stops: Array, rng: np.random.Generator) -> Scene:
    """The building with some furniture moved; as it is where no draw leaves stops in reach."""
    for _ in range(_TRIES):
        moved = Scene(_moved(scene.plan, stops.reshape(-1, 2), rng))
        if np.isfinite(_metres(moved, stops)):
            return moved
    return scene


def _moved(plan: FloorPlan, places: Array, rng: np.random.Generator) -> FloorPlan:
    pieces = [np.array(piece.outline) for piece in plan.furniture]
    doors = np.array([_middle(door) for door in plan.doors])
    count = len(pieces) - 1  # the cupboard in the door stays
    for number in rng.permutation(count)[: round(MOVED * count)].tolist():
        piece = pieces[number]
        room = next((r for r in plan.rooms if r.contains(piece.mean(axis=0))), None)
        if room is None:
            continue
        corners = np.array(room.outline)
        others = [box_of(_outline(one)) for i, one in enumerate(pieces) if i != number]
        for _ in range(_TRIES):
            place = rng.uniform(corners.min(axis=0), corners.max(axis=0))
            pose = np.array([*place, rng.integers(4) * np.pi / 2])
            put = to_world(pose, piece - piece.mean(axis=0))
            if (
                room.contains(put).all()
                and not any(overlap(box_of(_outline(put)), other) for other in others)
                and _apart(put, places) > _FREE
                and _apart(put, doors) > _AT_DOOR
            ):
                pieces[number] = put
                break
    furniture = zip(plan.furniture, pieces, strict=True)
    moved = tuple(replace(piece, outline=_outline(corners)) for piece, corners in furniture)
    return replace(plan, furniture=moved)


def _outline(corners: Array) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in corners)


def _apart(outline: Array, places: Array) -> float:
    """Metres from the box around an outline to the nearest of places (K, 2)."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    gap = np.maximum(np.maximum(low - places, places - high), 0.0)
    return float(np.linalg.norm(gap, axis=1).min(initial=np.inf))


def _metres(scene: Scene, stops: Array) -> float:
    """Metres from stop to stop (V, N, 2), of all robots; infinite where one is out of reach."""
    legs = stops[:-1].reshape(-1, 2), stops[1:].reshape(-1, 2)
    return float(GridPaths(scene.clearance).between(*legs).sum())


class ChangingTask(ExplorationTask):
    """Robots in one building, which may be rebuilt between two goals."""

    def rebuild(self, scene: Scene) -> None:
        """Let the building be another from now on.

        A robot that stands where something is put is pushed to the nearest free place; its odometry
        does not notice.
        """
        (name,) = self.scenes
        self.scenes = {name: scene}
        self._rows = [(scene, np.arange(len(self)))]
        poses = self.poses.copy()
        caught = scene.clearance.at(poses[:, :2]) < DifferentialDrive.radius
        paths = GridPaths(scene.clearance)
        free = paths.points[paths.largest]
        for number in np.flatnonzero(caught):
            nearest = np.linalg.norm(free - poses[number, :2], axis=1).argmin()
            poses[number, :2] = free[nearest]
        self.carry(poses)
