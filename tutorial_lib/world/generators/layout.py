"""Rooms and doors, and the walls that follow from them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tutorial_lib.world.floorplan import FloorPlan, Furniture, Room
from tutorial_lib.world.generators.drafts import Opening, RoomDraft
from tutorial_lib.world.generators.rectilinear import (
    DoesNotFit,
    Outline,
    Point,
    Rect,
    common_walls,
    inset,
    outline_of,
    overlap,
    sides,
    tidy,
)
from tutorial_lib.world.materials import PERIOD, Material

CORNER = 0.12
"""Least distance in metres from a door to a corner."""
FRAME = "door frame"
"""Name of the material of door posts."""


@dataclass
class Layout:
    """A floor plan in the making.

    Attributes:
        thickness: of every wall, in metres.
        rooms, openings: so far.
        furniture: so far, with `twins[i]` the group of piece i: pieces of a group stand for one
            another in rooms that look alike, and go together when one has to go.
    """

    thickness: float
    rooms: list[RoomDraft] = field(default_factory=list)
    openings: list[Opening] = field(default_factory=list)
    furniture: list[Furniture] = field(default_factory=list)
    twins: list[int] = field(default_factory=list)

    def add(self, use: str, rects: Sequence[Rect]) -> int:
        """Add a room that reaches to the middle of its walls; returns its index."""
        outline = inset(outline_of(rects), self.thickness / 2)
        return self.add_faces(use, outline, f"{use} {len(self.rooms)}")

    def add_faces(self, use: str, outline: Outline, material: str) -> int:
        """Add a room whose faces are given; returns its index."""
        self.rooms.append(RoomDraft(use, outline, material))
        return len(self.rooms) - 1

    def add_corridors(
        self, rng: np.random.Generator, groups: Sequence[Sequence[Rect]]
    ) -> list[int]:
        """Add hallways, with a door wherever two of them meet; returns their indices.

        Raises:
            DoesNotFit: if a hallway is too narrow for a door.
        """
        halls = [self.add("hallway", rects) for rects in groups]
        for i, one in enumerate(halls):
            for two in halls[:i]:
                outlines = self.rooms[one].outline, self.rooms[two].outline
                for wall in common_walls(*outlines, self.thickness):
                    if not self._carve(rng, *wall, (one, two)):
                        raise DoesNotFit("a hallway that does not go on")
        return halls

    def join(self, rng: np.random.Generator, a: int, b: int) -> bool:
        """Put a door, 0.9 to 1.1 m wide, into the longest wall between two rooms, if one fits."""
        walls = common_walls(self.rooms[a].outline, self.rooms[b].outline, self.thickness)
        if not walls:
            return False
        return self._carve(rng, *max(walls, key=lambda entry: _length(*entry)), (a, b))

    def _carve(
        self, rng: np.random.Generator, wall: Rect, along_x: bool, rooms: tuple[int, int]
    ) -> bool:
        """Put a door into a wall, mostly near a corner, if there is room for one."""
        width = tidy(min(rng.uniform(0.9, 1.1), _length(wall, along_x) - 2 * CORNER))
        if width < 0.9:
            return False
        slack = _length(wall, along_x) - 2 * CORNER - width
        for share in (rng.beta(0.5, 0.5), *rng.random(5)):
            hole = _part(wall, along_x, tidy(CORNER + share * slack), width)
            if not any(overlap(hole, other.hole, 0.4) for other in self.openings):
                self.openings.append(Opening(hole, along_x, rooms))
                return True
        return False

    def join_longest(self, rng: np.random.Generator, room: int, others: Sequence[int]) -> int:
        """Put a door between a room and that of `others` with the longest common wall.

        Returns:
            The index of the room it was joined with.

        Raises:
            DoesNotFit: if no wall between them has room for a door.
        """

        def common(other: int) -> float:
            outlines = self.rooms[room].outline, self.rooms[other].outline
            walls = common_walls(*outlines, self.thickness)
            return max((_length(*wall) for wall in walls), default=0.0)

        best = max(others, key=common)
        if not self.join(rng, room, best):
            raise DoesNotFit(f"no place for a door of a {self.rooms[room].use}")
        return best

    def openings_of(self, room: int) -> list[Opening]:
        """The doors of a room."""
        return [opening for opening in self.openings if room in opening.rooms]

    def place(self, pieces: Sequence[Furniture], groups: Sequence[int] | None = None) -> None:
        """Add furniture, each piece a group of its own unless given."""
        first = max(self.twins, default=-1) + 1
        self.furniture += pieces
        self.twins += range(first, first + len(pieces)) if groups is None else groups

    def plan(self, family: str, seed: int) -> FloorPlan:
        """The floor plan, all in one plain colour."""
        rows = [row for number in range(len(self.rooms)) for row in self._walls(number)]
        rows += [(*post, FRAME, 0.0) for door in self.openings for post in door.posts()]
        names = [name for *_, name, _ in rows] + [piece.material for piece in self.furniture]
        return FloorPlan(
            family=family,
            seed=seed,
            walls=np.array([(*start, *end) for start, end, _, _ in rows]),
            wall_materials=tuple(name for *_, name, _ in rows),
            wall_offsets=np.array([offset for *_, offset in rows]),
            materials=tuple(Material(name, (128, 128, 128)) for name in dict.fromkeys(names)),
            rooms=tuple(Room(room.kind, room.outline) for room in self.rooms),
            doors=tuple(opening.door() for opening in self.openings),
            furniture=tuple(self.furniture),
        )

    def _walls(self, number: int) -> list[tuple[Point, Point, str, float]]:
        """A room's faces: start, end, material, metres along the material at the start.

        The strip runs on behind doors. Where the room's perimeter is longer than one strip, the
        next lap gets a strip of its own, so that no two places in the room look alike.
        """
        room, doors = self.rooms[number], self.openings_of(number)
        walls, run = [], 0.0
        for start, end in sides(room.outline):
            length = abs(end[0] - start[0]) + abs(end[1] - start[1])
            holes = sorted(hole for door in doors if (hole := door.share_of(start, end)))
            edges = [0.0, *(edge for hole in holes for edge in hole), length]
            for low, high in zip(edges[0::2], edges[1::2], strict=True):
                for a, b in _laps(run + low, run + high):
                    lap = int((a + 1e-6) / PERIOD)
                    name = room.material if lap == 0 else f"{room.material}, lap {lap + 1}"
                    ends = _at(start, end, a - run), _at(start, end, b - run)
                    walls.append((*ends, name, tidy(max(a - lap * PERIOD, 0.0))))
            run += length
        return walls


def _laps(low: float, high: float) -> list[tuple[float, float]]:
    """A stretch of a room's perimeter, cut where one strip ends and the next begins."""
    cut = PERIOD * np.ceil((low + 1e-3) / PERIOD)
    if cut > high - 1e-3:
        return [(low, high)]
    return [(low, cut), *_laps(cut, high)]


def _at(start: Point, end: Point, distance: float) -> Point:
    """The point `distance` metres from start towards end, along x or y."""
    dx, dy = np.sign(np.subtract(end, start))
    return tidy(start[0] + distance * dx), tidy(start[1] + distance * dy)


def _length(wall: Rect, along_x: bool) -> float:
    return wall[2] - wall[0] if along_x else wall[3] - wall[1]


def _part(wall: Rect, along_x: bool, start: float, length: float) -> Rect:
    """The part of a wall that begins `start` metres from its low end."""
    x0, y0, x1, y1 = wall
    if along_x:
        return tidy(x0 + start), y0, tidy(x0 + start + length), y1
    return x0, tidy(y0 + start), x1, tidy(y0 + start + length)
