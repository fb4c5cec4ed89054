"""Offices in which many rooms, and stretches of the corridor, look exactly alike.

A corridor is a chain of equal stretches. The rooms on one side of a stretch are drawn once; those
on the other side are the same turned by half a turn, and every stretch repeats them. Rooms at the
ends and a few odd ones between are different, so that one can still find out where one is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tutorial_lib.world.floorplan import Furniture
from tutorial_lib.world.generators.drafts import Opening, RoomDraft
from tutorial_lib.world.generators.furnish import furnish, furnish_room
from tutorial_lib.world.generators.layout import CORNER, Layout
from tutorial_lib.world.generators.office import add_band
from tutorial_lib.world.generators.rectilinear import Outline, Rect, inset, outline_of, tidy
from tutorial_lib.world.generators.skeletons import Band

ODD = 0.15
"""Chance that a room, from the second stretch on, is unlike its twins."""
ODD_USES = ("meeting", "storage", "lounge", "kitchen")
END = (3.8, 4.8)
"""Metres: depth of the rooms at a corridor's ends."""
BESIDE_CROSS = (4.2, 5.4)
"""Metres: depth of the rooms along a corridor that joins two others."""
AT_ENDS = ("lounge", "meeting")
"""The room that a corridor leads to."""
BEHIND = (("kitchen",), ("bathroom", "storage"), ("storage", "bathroom"), ("office",))
"""The rooms behind that one."""


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


def symmetric_office(rng: np.random.Generator, area: float) -> Layout:
    """Draw a symmetric office of about `area` square metres.

    Raises:
        DoesNotFit: if this draw cannot be built.
    """
    module, wings, stretches = _measures(rng, area)
    layout = Layout(module.wall)
    rooms = _room_models(rng, module)
    corridor = _corridor_model(rng, module, rooms)
    ends = []
    for wing in range(wings):
        places = [(column * module.stretch, wing * module.height) for column in range(stretches)]
        chain = [_add_stretch(rng, layout, module, rooms, corridor, place) for place in places]
        for one, two, (x, y) in zip(chain, chain[1:], places[1:], strict=False):
            _open_end(layout, corridor, (x, y), (one, two))
        length, y = stretches * module.stretch, places[0][1]
        ends += [(chain[0], 0.0, y), (chain[-1], tidy(length), y)]
    _add_ends(rng, layout, module, corridor, ends)
    copied = {model.room.material for model in (*rooms, corridor)}
    furnish(rng, layout, [i for i, r in enumerate(layout.rooms) if r.material not in copied])
    return layout


def _measures(rng: np.random.Generator, area: float) -> tuple[Module, int, int]:
    """The module, the number of parallel corridors, and the number of stretches in each."""
    wings = 2 if area > 230.0 and rng.random() < 0.65 else 1
    wall = tidy(rng.choice([0.10, 0.12, 0.14]))
    hall, pitch = tidy(rng.uniform(1.7, 2.25)), tidy(rng.uniform(2.8, 4.0))
    depth = tidy(rng.uniform(4.0, 5.4))
    height = 2 * depth + hall
    columns = (area / wings - height * sum(END)) / (height * pitch)
    rooms = int(rng.integers(1, min(max(int(columns / 2), 1), 3) + 1))
    return Module(wall, hall, pitch, depth, rooms), wings, max(round(columns / rooms), 2)


def _room_models(rng: np.random.Generator, module: Module) -> list[Model]:
    """The rooms above a stretch of corridor, some of them alike but for their place."""
    kinds: list[Model] = []
    for i in range(int(rng.integers(1, module.rooms + 1))):
        outline = module.faces(0.0, module.hall, module.pitch, module.hall + module.depth)
        room = RoomDraft("office", outline, f"office {'ABC'[i]}")
        width = tidy(rng.uniform(0.9, 1.1))
        free = module.pitch - module.wall - width - 2 * CORNER
        x = tidy(module.wall / 2 + CORNER + rng.beta(0.5, 0.5) * free)
        low, high = module.hall - module.wall / 2, module.hall + module.wall / 2
        hole = tidy(x), tidy(low), tidy(x + width), tidy(high)
        pieces = furnish_room(rng, room, [Opening(hole, True, (0, 0)).approach])
        first = kinds[-1].groups.stop if kinds else 0
        kinds.append(Model(room, hole, pieces, range(first, first + len(pieces))))
    return [kinds[i % len(kinds)] for i in range(module.rooms)]


def _places(module: Module, rooms: Sequence[Model]) -> list[tuple[Model, Move]]:
    """The rooms around the first stretch of corridor, above it and turned below it."""
    above = [(model, Move(False, i * module.pitch, 0.0)) for i, model in enumerate(rooms)]
    return above + [
        (model, Move(True, module.stretch - move.dx, module.hall)) for model, move in above
    ]


def _corridor_model(rng: np.random.Generator, module: Module, rooms: Sequence[Model]) -> Model:
    """The first stretch of corridor; its door is the one at its low end."""
    room = RoomDraft("hallway", module.faces(0.0, 0.0, module.stretch, module.hall), "corridor")
    width = rng.uniform(0.9, 1.1)
    low, high = (tidy((module.hall + sign * width) / 2) for sign in (-1, 1))
    end = (tidy(-module.wall / 2), low, tidy(module.wall / 2), high)
    doors = [Opening(move.rect(model.hole), True, (0, 0)) for model, move in _places(module, rooms)]
    doors += [Opening(Move(False, x, 0.0).rect(end), False, (0, 0)) for x in (0.0, module.stretch)]
    pieces = furnish_room(rng, room, [door.approach for door in doors])
    first = max(model.groups.stop for model in rooms)
    return Model(room, end, pieces, range(first, first + len(pieces)))


def _add_stretch(
    rng: np.random.Generator,
    layout: Layout,
    module: Module,
    rooms: Sequence[Model],
    corridor: Model,
    place: tuple[float, float],
) -> int:
    """Add a stretch of corridor with its rooms; returns the corridor's index."""
    dx, dy = place
    hall = corridor.copy_to(layout, Move(False, dx, dy))
    for model, at_start in _places(module, rooms):
        move = Move(at_start.half_turn, at_start.dx + dx, at_start.dy + dy)
        if dx > 0.0 and rng.random() < ODD:
            use = ODD_USES[rng.integers(len(ODD_USES))]
            outline = move.outline(model.room.outline)
            number = layout.add_faces(use, outline, f"{use} {len(layout.rooms)}")
        else:
            number = model.copy_to(layout, move)
        layout.openings.append(Opening(move.rect(model.hole), True, (number, hall)))
    return hall


def _open_end(
    layout: Layout, corridor: Model, place: tuple[float, float], rooms: tuple[int, int]
) -> None:
    """The door at the low end of a stretch that begins at a place."""
    layout.openings.append(Opening(Move(False, *place).rect(corridor.hole), False, rooms))


def _add_ends(
    rng: np.random.Generator,
    layout: Layout,
    module: Module,
    corridor: Model,
    ends: Sequence[tuple[int, float, float]],
) -> None:
    """What the corridors lead to: a corridor across, or rooms at each end.

    Args:
        rng: draws rooms.
        layout: to add to.
        module: the measures.
        corridor: has the door that all ends have.
        ends: for each end the index of the stretch, and its x and its corridor's y in metres.
    """
    for high_side in (False, True):
        here = [end for end in ends if (end[1] > 0.0) == high_side]
        out = 1.0 if high_side else -1.0
        if len(here) == 2 and (not high_side or rng.random() < 0.7):
            _add_cross(rng, layout, module, corridor, here, out)
        else:
            for end in here:
                _add_suite(rng, layout, module, corridor, end, out)


def _add_cross(
    rng: np.random.Generator,
    layout: Layout,
    module: Module,
    corridor: Model,
    ends: Sequence[tuple[int, float, float]],
    out: float,
) -> None:
    """A corridor that joins two parallel ones, with rooms along it."""
    x, top = ends[0][1], module.height + module.hall
    near, far = sorted((x, tidy(x + out * module.hall)))
    cross = layout.add("hallway", [(near, 0.0, far, top)])
    for number, at, y in ends:
        _open_end(layout, corridor, (at, y), (number, cross))
    wall, back = sorted(
        (x + out * module.hall, x + out * (module.hall + rng.uniform(*BESIDE_CROSS)))
    )
    add_band(rng, layout, Band((tidy(wall), 0.0, tidy(back), top), False, out < 0), [cross])


def _add_suite(
    rng: np.random.Generator,
    layout: Layout,
    module: Module,
    corridor: Model,
    end: tuple[int, float, float],
    out: float,
) -> None:
    """The room that a corridor leads to, and one or two small ones behind it."""
    number, x, y = end
    x0, x1 = sorted((x, tidy(x + out * rng.uniform(*END))))
    upper = rng.random() < 0.5
    low, high = tidy(y - module.depth), tidy(y + module.hall + module.depth)
    split = tidy(y + module.hall) if upper else y
    large, small = ((low, split), (split, high)) if upper else ((split, high), (low, split))
    main = layout.add(AT_ENDS[rng.integers(len(AT_ENDS))], [(x0, large[0], x1, large[1])])
    _open_end(layout, corridor, (x, y), (number, main))
    uses = BEHIND[rng.integers(len(BEHIND))]
    edges = [tidy(value) for value in np.linspace(x0, x1, len(uses) + 1)]
    for use, left, right in zip(uses, edges, edges[1:], strict=False):
        room = layout.add(use, [(left, small[0], right, small[1])])
        layout.join_longest(rng, room, [main])
