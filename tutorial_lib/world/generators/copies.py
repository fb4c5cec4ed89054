"""Rooms drawn once and copied, with all that is in them, to other places."""

from __future__ import annotations

from dataclasses import dataclass

from tutorial_lib.world.floorplan import Furniture
from tutorial_lib.world.generators.drafts import RoomDraft
from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.rectilinear import Outline, Rect, inset, outline_of, tidy


@dataclass(frozen=True)
class Module:
    """The measures that all stretches of corridor share, in metres up to the middle of walls.

    Attributes:
        wall: thickness.
        hall: the corridor's width.
        pitch: a room's width along the corridor.
        depth: a room's depth.
        rooms: how many rooms a stretch has on either side.
    """

    wall: float
    hall: float
    pitch: float
    depth: float
    rooms: int

    @property
    def stretch(self) -> float:
        """Metres of corridor that repeat."""
        return tidy(self.rooms * self.pitch)

    @property
    def height(self) -> float:
        """Metres from the back of the rooms on one side to the back of those on the other."""
        return tidy(2 * self.depth + self.hall)

    def faces(self, x0: float, y0: float, x1: float, y1: float) -> Outline:
        """The faces of a room that reaches to the middle of its walls."""
        return inset(outline_of([(x0, y0, x1, y1)]), self.wall / 2)


@dataclass(frozen=True)
class Move:
    """Half a turn about the origin, or none, and then a shift in metres."""

    half_turn: bool
    dx: float
    dy: float

    def outline(self, outline: Outline) -> Outline:
        """The outline after the move, its first corner still first."""
        sign = -1.0 if self.half_turn else 1.0
        return tuple((tidy(sign * x + self.dx), tidy(sign * y + self.dy)) for x, y in outline)

    def rect(self, rect: Rect) -> Rect:
        """The rectangle after the move."""
        xs, ys = zip(*self.outline((rect[:2], rect[2:])), strict=True)
        return min(xs), min(ys), max(xs), max(ys)


@dataclass(frozen=True)
class Model:
    """A room drawn once for all its copies: the hole of its door, its furniture, their groups."""

    room: RoomDraft
    hole: Rect
    pieces: list[Furniture]
    groups: range

    def copy_to(self, layout: Layout, move: Move) -> int:
        """Add a copy with its furniture, without its door; returns the room's index."""
        layout.place(
            [Furniture(p.kind, move.outline(p.outline), p.material) for p in self.pieces],
            self.groups,
        )
        outline = move.outline(self.room.outline)
        return layout.add_faces(self.room.use, outline, self.room.material)
