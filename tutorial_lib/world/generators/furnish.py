"""Furniture into rooms: along the walls, clear of doors and of one another."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.world.floorplan import Furniture
from tutorial_lib.world.generators.drafts import RoomDraft
from tutorial_lib.world.generators.furniture import (
    CENTRAL,
    FURNISHING,
    GAP,
    GROUPS,
    ROUND,
    SIMPLER,
    Part,
)
from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.rectilinear import Outline, Point, Rect, overlap, sides, tidy

VARIANTS = 3
"""Looks of each kind of furniture within one world."""
TRIES = 14
"""Places tried for a group before it is left out."""
TRIES_FOR_NEEDED = 50
"""Places tried for what the room's use asks for."""
AISLE = 0.58
"""Metres to walk in front of a piece, or around a table."""
FULLEST = 0.42
"""Greatest share of a room's floor that furniture takes."""
CLEAR = 0.02
"""Metres that any two things stay apart."""

Frame = tuple[Point, Point]
"""A place for a group: the point of its origin, and the direction of its x."""


def furnish(rng: np.random.Generator, layout: Layout, rooms: Iterable[int]) -> None:
    """Furnish the rooms with these indices, each in its own way."""
    for number in rooms:
        keep_free = [opening.approach for opening in layout.openings_of(number)]
        layout.place(furnish_room(rng, layout.rooms[number], keep_free))


def furnish_room(
    rng: np.random.Generator, room: RoomDraft, keep_free: Sequence[Rect]
) -> list[Furniture]:
    """Furniture for one room.

    Args:
        rng: draws pieces and places.
        room: its use says what belongs there.
        keep_free: rectangles that stay empty.
    """
    rules, area = FURNISHING[room.use], room.area
    often = rng.integers(len(rules.often), size=int(area / rules.each))
    wishes = [(name, *SIMPLER.get(name, ())) for name in rules.always]
    wishes += [(rules.often[i],) for i in often]
    walls = np.array([(*min(side), *max(side)) for side in sides(room.outline)])
    taken, pieces, filled = list(keep_free), [], 0.0
    for i, options in enumerate(wishes):
        needed = i < len(rules.always)
        for name in options:
            parts = GROUPS[name](rng)
            size = sum(part.width * part.depth for part in parts)
            space = _space(parts, name in CENTRAL)
            tries = TRIES_FOR_NEEDED if needed else TRIES
            frame = _find_place(rng, room.outline, walls, taken, space, name in CENTRAL, tries)
            if frame is None or filled + size > FULLEST * area:
                continue
            outlines = [part_outline(part, frame) for part in parts]
            keep = needed or name in CENTRAL
            taken += [
                box_of(outline) for outline in ([part_outline(space, frame)] if keep else outlines)
            ]
            filled += size
            pieces += [
                Furniture(part.kind, outline, f"{part.kind} {rng.integers(VARIANTS) + 1}")
                for part, outline in zip(parts, outlines, strict=True)
            ]
            break
    return pieces


def _space(parts: Sequence[Part], central: bool) -> Part:
    """The room that a group takes with an aisle: in front, or all around if it stands alone."""
    boxes = [box_of(part_outline(part, ((0.0, 0.0), (1.0, 0.0)))) for part in parts]
    x0, y0 = (min(box[i] for box in boxes) for i in (0, 1))
    x1, y1 = (max(box[i] for box in boxes) for i in (2, 3))
    if central:
        x0, y0, x1 = x0 - AISLE, y0 - AISLE, x1 + AISLE
    y1 += AISLE
    return Part("aisle", (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0)


def _find_place(
    rng: np.random.Generator,
    room: Outline,
    walls: NDArray[np.float64],
    taken: Sequence[Rect],
    space: Part,
    central: bool,
    tries: int,
) -> Frame | None:
    """A place where the space of a group is free, if one of the tries finds any."""
    for _ in range(tries):
        frame = _in_the_middle(rng, walls, space) if central else _at_a_wall(rng, room, space)
        if frame and is_clear(box_of(part_outline(space, frame)), walls, taken):
            return frame
    return None


def _at_a_wall(rng: np.random.Generator, room: Outline, space: Part) -> Frame | None:
    """Somewhere along a wall long enough for the group, half of the time in a corner."""
    half = abs(space.x) + space.width / 2 + GAP
    walls = [(a, b) for a, b in sides(room) if abs(b[0] - a[0]) + abs(b[1] - a[1]) > 2 * half]
    if not walls:
        return None
    lengths = np.array([abs(b[0] - a[0]) + abs(b[1] - a[1]) for a, b in walls])
    number = int(np.searchsorted(np.cumsum(lengths), rng.random() * lengths.sum()))
    (start, end), length = walls[number], lengths[number]
    share = float(rng.integers(2)) if rng.random() < 0.5 else rng.random()
    along = half + share * (length - 2 * half)
    dx, dy = (end[0] - start[0]) / length, (end[1] - start[1]) / length
    return (start[0] + along * dx, start[1] + along * dy), (dx, dy)


def _in_the_middle(rng: np.random.Generator, walls: NDArray[np.float64], space: Part) -> Frame:
    """Somewhere in the room's bounding box, along x or y."""
    direction = (0.0, 1.0) if rng.random() < 0.5 else (1.0, 0.0)
    x0, y0, x1, y1 = box_of(part_outline(space, ((0.0, 0.0), direction)))
    low = walls.min(axis=0)[:2] - (x0, y0) + GAP
    high = walls.max(axis=0)[2:] - (x1, y1) - GAP
    x, y = low + (high - low) * rng.random(2)
    return (x, y), direction


def part_outline(part: Part, frame: Frame) -> Outline:
    """The corners of a part in the world, counter-clockwise."""
    (ox, oy), (ux, uy) = frame
    if part.kind in ROUND:
        angles = np.pi / 8 + np.arange(8) * np.pi / 4
        corners = part.width / 2 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    else:
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * (part.width, part.depth)
    cos, sin = np.cos(part.turn), np.sin(part.turn)
    local = corners @ np.array([[cos, sin], [-sin, cos]]) + (part.x, part.y)
    return tuple(
        (tidy(ox + x * ux - y * uy), tidy(oy + x * uy + y * ux)) for x, y in local.tolist()
    )


def box_of(outline: Outline) -> Rect:
    """The smallest rectangle along x and y around an outline."""
    xs, ys = zip(*outline, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def is_clear(
    box: Rect, walls: NDArray[np.float64], taken: Sequence[Rect], margin: float = CLEAR
) -> bool:
    """Whether a box lies in the room, `margin` metres clear of walls and of what stands there."""
    if any(overlap(box, other, margin) for other in taken):
        return False
    x0, y0, x1, y1 = walls.T
    near = (x0 < box[2] + margin) & (x1 > box[0] - margin)
    if (near & (y0 < box[3] + margin) & (y1 > box[1] - margin)).any():
        return False
    x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    above = (x0 <= x) & (x < x1) & (y0 > y)
    return bool(above.sum() % 2)
