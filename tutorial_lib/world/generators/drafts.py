"""A room and a door in the making."""

from dataclasses import dataclass

from tutorial_lib.world.floorplan import Door, Room
from tutorial_lib.world.generators.rectilinear import Outline, Point, Rect, tidy

APPROACH = 0.9
"""Metres in front of a door that stay free."""
KIND_OF_USE = {
    "meeting": "office",
    "open plan": "office",
    "lounge": "open",
    "passage": "hallway",
    "hall": "open",
}
"""Uses that are not themselves the name of a room's kind."""


@dataclass(frozen=True)
class RoomDraft:
    """A room: its use, its faces as an outline, and the name of the strip on its walls."""

    use: str
    outline: Outline
    material: str

    @property
    def area(self) -> float:
        """Square metres."""
        return Room(self.kind, self.outline).area

    @property
    def kind(self) -> str:
        """The use as one of `ROOM_KINDS`."""
        return KIND_OF_USE.get(self.use, self.use)


@dataclass(frozen=True)
class Opening:
    """A door: the hole in the wall, whether that wall runs along x, and the two rooms' indices."""

    hole: Rect
    along_x: bool
    rooms: tuple[int, int]

    @property
    def approach(self) -> Rect:
        """The door with the floor on both sides that must stay free."""
        x0, y0, x1, y1 = self.hole
        dx, dy = (0.05, APPROACH) if self.along_x else (APPROACH, 0.05)
        return x0 - dx, y0 - dy, x1 + dx, y1 + dy

    def door(self) -> Door:
        """The opening on the wall's middle line."""
        x0, y0, x1, y1 = self.hole
        x, y = tidy((x0 + x1) / 2), tidy((y0 + y1) / 2)
        start, end = ((x0, y), (x1, y)) if self.along_x else ((x, y0), (x, y1))
        return Door(start, end, self.rooms)

    def posts(self) -> list[tuple[Point, Point]]:
        """The two short faces in the opening, with the opening on their left."""
        x0, y0, x1, y1 = self.hole
        if self.along_x:
            return [((x0, y1), (x0, y0)), ((x1, y0), (x1, y1))]
        return [((x0, y0), (x1, y0)), ((x1, y1), (x0, y1))]

    def share_of(self, start: Point, end: Point) -> tuple[float, float] | None:
        """The stretch of a face from `start` to `end` that the opening takes, metres from start."""
        along, across = (0, 1) if self.along_x else (1, 0)
        if start[across] != end[across] or start[across] not in self.hole[across::2]:
            return None
        low, high = self.hole[along], self.hole[along + 2]
        if not min(start[along], end[along]) < low < high < max(start[along], end[along]):
            return None
        one, other = abs(low - start[along]), abs(high - start[along])
        return min(one, other), max(one, other)
