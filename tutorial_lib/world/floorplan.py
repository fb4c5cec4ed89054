"""A floor plan: walls with materials, rooms, doors and furniture."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_PIXELS
from tutorial_lib.validation import floats, instance, instances, integers, whole
from tutorial_lib.world.materials import Look, Material, texture_atlas

ROOM_KINDS = ("hallway", "living", "kitchen", "bedroom", "bathroom", "office", "storage", "open")
"""What a room can be; "open" is a space of unknown use, as an imported map has."""
MAX_EXTENT = 1000.0
"""Metres that a plan may measure along x or y: more is a mistake in the unit."""
MAX_AREA = MAX_PIXELS * 0.05**2
"""Square metres of the box around all walls: its grid has to fit in memory, with cells of 5 cm."""
FARTHEST = 2e7
"""Metres of a coordinate, at most: more than any that a map in UTM has. Beyond, numbers would
become too coarse."""
_OUTSIDE = 10.0  # metres that rooms, furniture and doors may reach beyond the box around the walls


@dataclass(frozen=True)
class Room:
    """A room: what it is for, and its outline as a tuple of corners (x, y)."""

    kind: str
    outline: tuple[tuple[float, float], ...]

    @property
    def area(self) -> float:
        """Square metres inside the outline."""
        x, y = np.asarray(self.outline).T
        return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point (..., 2) lies inside the outline."""
        x, y = np.moveaxis(floats("points", points, (..., 2))[..., None, :], -1, 0)
        x0, y0 = np.asarray(self.outline).T
        x1, y1 = np.roll(x0, -1), np.roll(y0, -1)
        # A ray to the right crosses the outline an odd number of times.
        straddles = (y0 > y) != (y1 > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            right = x < x0 + (y - y0) * (x1 - x0) / (y1 - y0)
        return (straddles & right).sum(axis=-1) % 2 == 1


@dataclass(frozen=True)
class Door:
    """An opening from `start` to `end`, on the wall's middle line, between two rooms (indices)."""

    start: tuple[float, float]
    end: tuple[float, float]
    rooms: tuple[int, int]

    @property
    def width(self) -> float:
        """Metres between the door posts."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))


@dataclass(frozen=True)
class Furniture:
    """A piece of furniture: a full-height polygon of one material."""

    kind: str
    outline: tuple[tuple[float, float], ...]
    material: str


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """Everything that stands still in a world.

    A wall is one face: a wall between two rooms has a face on either side and short pieces at the
    door posts, so each room has its own materials. Faces and furniture together are `segments`,
    which rays meet and robots collide with. Loading a plan checks that its rooms are closed; code
    that builds one calls `occupancy.check_closed`.

    Attributes:
        family: the generator's or importer's name.
        seed: the generator's, or 0.
        walls: (W, 4) x0, y0, x1, y1 in metres.
        wall_materials: W names of materials.
        wall_offsets: (W,) metres along the material at the wall's first end.
        materials, rooms, doors, furniture, look: see their classes.

    Raises:
        InputError: when a field is malformed; it names the field.
    """

    family: str
    seed: int
    walls: NDArray[np.float64]
    wall_materials: tuple[str, ...]
    wall_offsets: NDArray[np.float64]
    materials: tuple[Material, ...]
    rooms: tuple[Room, ...]
    doors: tuple[Door, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    look: Look = field(default_factory=Look)

    def __post_init__(self) -> None:
        instance("family", self.family, str)
        whole("seed", self.seed, least=0)
        for name, kind in _PARTS.items():
            instances(name, getattr(self, name), kind)
        instance("look", self.look, Look)
        for name, shape in (("walls", ("W", 4)), ("wall_offsets", ("W",))):
            array = floats(name, getattr(self, name), shape, infinite=True, nan=True).copy()
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        _check_walls(self)
        names = {material.name for material in self.materials}
        if len(names) != len(self.materials):
            raise InputError("materials: two have the same name; give each its own")
        for i, name in enumerate(self.wall_materials):
            _check_material(f"walls[{i}].material", name, names)
        bounds = self.bounds
        for i, piece in enumerate(self.furniture):
            _check_outline(f"furniture[{i}].outline", piece.outline, bounds)
            _check_material(f"furniture[{i}].material", piece.material, names)
        for i, room in enumerate(self.rooms):
            _check_outline(f"rooms[{i}].outline", room.outline, bounds)
            if room.kind not in ROOM_KINDS:
                raise InputError(f"rooms[{i}].kind: {room.kind!r}; use one of {ROOM_KINDS}")
        if not len(self.rooms):
            raise InputError("rooms: there are none; a plan needs at least one room to be in")
        for i, door in enumerate(self.doors):
            _check_door(f"doors[{i}]", door, len(self.rooms), bounds)

    def __reduce__(self) -> tuple[type[FloorPlan], tuple[Any, ...]]:
        # A copy is checked, and cannot be written to either.
        return type(self), tuple(getattr(self, part.name) for part in fields(self))

    @cached_property
    def segments(self) -> NDArray[np.float64]:
        """(S, 4) all that rays meet: the walls first, then the furniture's sides."""
        pieces = [_sides(piece.outline) for piece in self.furniture]
        return np.concatenate([self.walls, *pieces]) if pieces else self.walls

    @cached_property
    def segment_materials(self) -> NDArray[np.int32]:
        """(S,) the index of each segment's material in `materials`."""
        number = {material.name: i for i, material in enumerate(self.materials)}
        walls = [number[name] for name in self.wall_materials]
        pieces = [number[p.material] for p in self.furniture for _ in p.outline]
        return np.array(walls + pieces, dtype=np.int32)

    @cached_property
    def segment_offsets(self) -> NDArray[np.float64]:
        """(S,) metres along the material at each segment's first end."""
        offsets = [self.wall_offsets]
        for piece in self.furniture:
            lengths = np.linalg.norm(
                np.diff(_sides(piece.outline).reshape(-1, 2, 2), axis=1), axis=2
            )
            offsets.append(np.cumsum(lengths.ravel()) - lengths.ravel())
        return np.concatenate(offsets)

    @cached_property
    def atlas(self) -> NDArray[np.float32]:
        """(M, TEXELS, 3) the materials' strips as the camera sees them."""
        return texture_atlas(self.materials, self.look, self.seed)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x0, y0, x1, y1 of the box around all walls, in metres."""
        ends = self.walls.reshape(-1, 2)
        (x0, y0), (x1, y1) = ends.min(axis=0), ends.max(axis=0)
        return float(x0), float(y0), float(x1), float(y1)

    @property
    def area(self) -> float:
        """Square metres of all rooms together."""
        return sum(room.area for room in self.rooms)


_PARTS: dict[str, type] = {
    "wall_materials": str,
    "materials": Material,
    "rooms": Room,
    "doors": Door,
    "furniture": Furniture,
}


def _sides(outline: tuple[tuple[float, float], ...]) -> NDArray[np.float64]:
    """The sides (K, 4) of a polygon of K corners."""
    corners = np.asarray(outline, dtype=float)
    return np.concatenate([corners, np.roll(corners, -1, axis=0)], axis=1)


Bounds = tuple[float, float, float, float]


def too_far(bounds: Bounds) -> str:
    """What is wrong with the box x0, y0, x1, y1 around all walls; empty where nothing is."""
    x0, y0, x1, y1 = bounds
    farthest = max(map(abs, bounds))
    if not farthest <= FARTHEST:
        return f"lies {farthest:g} m from the origin, more than {FARTHEST:g} m"
    if max(x1 - x0, y1 - y0) > MAX_EXTENT:
        return f"spans {x1 - x0:,.0f} m x {y1 - y0:,.0f} m, more than {MAX_EXTENT:,.0f} m"
    area = (x1 - x0) * (y1 - y0)
    if area > MAX_AREA:
        return (
            f"spans {x1 - x0:,.0f} m x {y1 - y0:,.0f} m, {area:,.0f} m² and more than the "
            f"{MAX_AREA:,.0f} m² that fit in memory"
        )
    return ""


def _check_walls(plan: FloorPlan) -> None:
    walls, count = plan.walls, len(plan.walls)
    if walls.ndim != 2 or walls.shape[1] != 4 or count < 3:
        raise InputError(f"walls: shape {walls.shape}; give at least three rows x0, y0, x1, y1")
    if len(plan.wall_materials) != count or plan.wall_offsets.shape != (count,):
        raise InputError(
            f"walls: {count}, wall_materials: {len(plan.wall_materials)}, wall_offsets: "
            f"{len(plan.wall_offsets)}; give as many of each"
        )
    for name, array in (("walls", walls), ("wall_offsets", plan.wall_offsets)):
        bad = np.flatnonzero(~np.isfinite(array.reshape(count, -1)).all(axis=1))
        if bad.size:
            raise InputError(f"{name}[{bad[0]}]: {array[bad[0]].tolist()} is not finite")
        far = np.flatnonzero(np.abs(array.reshape(count, -1)).max(axis=1) > FARTHEST)
        if far.size:
            raise InputError(
                f"{name}[{far[0]}]: {array[far[0]].tolist()}; give metres, {FARTHEST:g} at most"
            )
    problem = too_far(plan.bounds)
    if problem:
        raise InputError(f"walls: the box around them {problem}; give metres")
    short = np.flatnonzero(np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]) < 1e-6)
    if short.size:
        raise InputError(f"walls[{short[0]}]: has no length; give two different ends")


def _check_near(where: str, points: ArrayLike, bounds: Bounds, whole: bool = True) -> None:
    """Check that points (N, 2) are finite, near the box around the walls, not `whole` beside it."""
    points = np.asarray(points, dtype=float)
    low, high = np.array(bounds[:2]), np.array(bounds[2:])
    near = (points >= low - _OUTSIDE) & (points <= high + _OUTSIDE)
    beside = (points < low).all(axis=0) | (points > high).all(axis=0)
    if not near.all() or (whole and beside.any()):
        raise InputError(
            f"{where}: it is not finite, or lies off the walls, which reach from "
            f"({low[0]:g}, {low[1]:g}) to ({high[0]:g}, {high[1]:g}); give numbers in metres"
        )


def _check_outline(where: str, outline: tuple[tuple[float, float], ...], bounds: Bounds) -> None:
    corners = floats(where, outline, infinite=True, nan=True)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise InputError(f"{where}: give at least three corners [x, y]")
    _check_near(where, corners, bounds)
    if (np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1) < 1e-6).any():
        raise InputError(f"{where}: a corner is given twice in a row; leave one out")


def _check_material(where: str, name: str, known: set[str]) -> None:
    if name not in known:
        raise InputError(f"{where}: {name!r} is not among the plan's materials; add it or rename")


def _check_door(where: str, door: Door, rooms: int, bounds: Bounds) -> None:
    ends = floats(where, [door.start, door.end], (2, 2), infinite=True, nan=True)
    _check_near(where, ends, bounds, whole=False)
    if door.width < 0.3:
        raise InputError(f"{where}: runs from {door.start} to {door.end}; give an opening >= 0.3 m")
    integers(f"{where}.rooms", door.rooms, (2,))
    if not all(0 <= room < rooms for room in door.rooms):
        raise InputError(f"{where}.rooms: {door.rooms}; the plan has rooms 0 to {rooms - 1}")
