"""What stands in a hall: rows of racks, a grid of pillars, pallets and machines here and there."""

from collections.abc import Iterator, Sequence

import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.world.floorplan import Furniture
from tutorial_lib.world.generators.drafts import RoomDraft
from tutorial_lib.world.generators.furnish import box_of, is_clear, part_outline
from tutorial_lib.world.generators.furniture import Part
from tutorial_lib.world.generators.rectilinear import Rect, sides

Range = tuple[float, float]
LOOSE: dict[str, tuple[Range, Range]] = {
    "pallet": ((1.1, 1.3), (0.75, 1.3)),
    "crate": ((0.5, 1.1), (0.4, 0.9)),
    "machine": ((1.4, 3.5), (0.9, 2.2)),
    "bench": ((1.2, 2.4), (0.4, 0.6)),
    "plant": ((0.4, 0.7), (0.4, 0.7)),
    "desk": ((1.2, 2.2), (0.65, 0.9)),
}
"""Width and depth in metres of what stands about."""
MIXES = (
    ("pallet", "pallet", "crate", "machine"),
    ("machine", "machine", "crate", "pallet"),
    ("bench", "plant", "desk", "bench"),
)
"""What stands about in one hall: that of a warehouse, a workshop or a lobby."""
PASSAGE = 0.6
"""Metres that stay free between any two things, at least."""
_LOOKS = 6  # of each kind that stands about, in one hall


def stock(rng: np.random.Generator, room: RoomDraft, keep_free: Sequence[Rect]) -> list[Furniture]:
    """Racks, pillars and things that stand about, for one hall.

    Every rack looks different; pillars look alike.

    Args:
        rng: draws what stands where.
        room: the hall.
        keep_free: rectangles that stay empty.
    """
    walls = np.array([(*min(side), *max(side)) for side in sides(room.outline)])
    low, high = walls[:, :2].min(axis=0), walls[:, 2:].max(axis=0)
    wanted = list(_racks(rng, low, high)) if rng.random() < 0.6 else []
    if rng.random() < 0.5:
        wanted += _pillars(rng, low, high)
    wanted += _loose(rng, low, high, int(room.area / rng.uniform(14.0, 70.0)))
    taken, pieces = list(keep_free), []
    for part, material in wanted:
        outline = part_outline(part, ((0.0, 0.0), (1.0, 0.0)))
        box = box_of(outline)
        if is_clear(box, walls, taken, PASSAGE):
            taken.append(box)
            pieces.append(Furniture(part.kind, outline, material))
    return pieces


def _racks(rng: np.random.Generator, low: Array, high: Array) -> Iterator[tuple[Part, str]]:
    """Rows of racks over a part of the hall, in sections with cross aisles between them."""
    along = int(rng.integers(2))  # the axis along which they run
    margin, aisle, depth = rng.uniform(1.2, 4.0), rng.uniform(1.5, 3.5), rng.uniform(0.6, 1.4)
    start, end = low + margin, high - margin
    used = rng.uniform(0.4, 1.0)  # share of the hall's breadth with racks in it
    section, gap = rng.uniform(3.0, 10.0), rng.uniform(1.4, 3.0)
    number, across = 0, start[1 - along]
    while across + depth < start[1 - along] + used * (end - start)[1 - along]:
        at = start[along]
        while at + 1.5 < end[along]:
            length = min(section, end[along] - at)
            number += 1
            if rng.random() > 0.12:  # here and there one is missing
                middle = (at + length / 2, across + depth / 2)
                x, y = middle if along == 0 else middle[::-1]
                turn = 0.0 if along == 0 else np.pi / 2
                yield Part("rack", x, y, length, depth, turn), f"rack {number}"
            at += length + gap
        across += depth + aisle


def _pillars(rng: np.random.Generator, low: Array, high: Array) -> Iterator[tuple[Part, str]]:
    """A regular grid of pillars."""
    pitch, size = rng.uniform(4.0, 8.0, 2), rng.uniform(0.3, 0.7)
    for x in np.arange(low[0] + pitch[0] / 2, high[0], pitch[0]):
        for y in np.arange(low[1] + pitch[1] / 2, high[1], pitch[1]):
            yield Part("pillar", x, y, size, size), f"pillar {rng.integers(2) + 1}"


def _loose(
    rng: np.random.Generator, low: Array, high: Array, count: int
) -> Iterator[tuple[Part, str]]:
    """Things that stand about, most of them square to the walls."""
    mix = MIXES[rng.integers(len(MIXES))]
    for kind in rng.choice(mix, size=count):
        (x, y), (width, depth) = rng.uniform(low, high), (rng.uniform(*r) for r in LOOSE[kind])
        square = np.pi / 2 * rng.integers(2)
        turn = square if rng.random() < 0.6 else rng.uniform(0.0, np.pi)
        part = Part(str(kind), float(x), float(y), width, depth, float(turn))
        yield part, f"{kind} {rng.integers(_LOOKS) + 1}"
