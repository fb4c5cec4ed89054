"""Halls: depots, warehouses, lobbies: much open space, few walls, sparse colour."""

from itertools import pairwise

import numpy as np

from tutorial_lib.world.generators.furnish import furnish
from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.programme import Size, fill, starts
from tutorial_lib.world.generators.rectilinear import DoesNotFit, Rect, tidy
from tutorial_lib.world.generators.skeletons import Band
from tutorial_lib.world.generators.stock import stock

SIZES = {
    "office": Size(9.0, 24.0),
    "storage": Size(8.0, 30.0, 2.6),
    "bathroom": Size(6.0, 14.0, 2.6),
    "lounge": Size(12.0, 30.0),
    "gap": Size(5.0, 60.0, 6.0),
}
WISHES = {"office": 1.5, "storage": 1.5, "bathroom": 0.5, "lounge": 0.5, "gap": 3.0}
"""Rooms along a hall's side; a gap stays outside the building."""
DEPTH = (3.4, 5.5)


def hall(rng: np.random.Generator, area: float) -> Layout:
    """Draw a building of about `area` square metres: one or two halls, and rooms along one side.

    Raises:
        DoesNotFit: if this draw cannot be built.
    """
    layout = Layout(tidy(rng.choice([0.12, 0.16, 0.20])))
    depth = tidy(rng.uniform(*DEPTH)) if rng.random() < 0.6 else 0.0
    width, height = _sides(rng, area, depth)
    halls = [layout.add("hall", rects) for rects in _halls(rng, width, height)]
    for one, two in pairwise(halls):
        if not layout.join(rng, one, two):
            raise DoesNotFit("two halls without a door between them")
        layout.join(rng, one, two)  # another door, if there is room for it
    rooms = _rooms(rng, layout, width, depth, halls) if depth else []
    furnish(rng, layout, rooms)
    for number in halls:
        keep_free = [opening.approach for opening in layout.openings_of(number)]
        layout.place(stock(rng, layout.rooms[number], keep_free))
    return layout


def _sides(rng: np.random.Generator, area: float, depth: float) -> tuple[float, float]:
    """Width and height of the halls together, in metres, with rooms `depth` deep below them."""
    aspect = rng.uniform(1.0, 2.6)
    height = np.sqrt(area / aspect)
    width = aspect * height
    return tidy(width), tidy(height - 0.5 * depth)


def _halls(rng: np.random.Generator, width: float, height: float) -> list[list[Rect]]:
    """Rectangles of each hall: one plain hall, one with a corner cut off, or two side by side."""
    form = rng.choice(["plain", "corner", "two"], p=[0.4, 0.35, 0.25])
    if form == "two":
        cut = tidy(width * rng.uniform(0.3, 0.7))
        return [[(0.0, 0.0, cut, height)], [(cut, 0.0, width, tidy(height * rng.uniform(0.5, 1)))]]
    if form == "corner":
        x, y = tidy(width * rng.uniform(0.4, 0.75)), tidy(height * rng.uniform(0.4, 0.75))
        return [[(0.0, 0.0, width, y), (0.0, y, x, height)]]
    return [[(0.0, 0.0, width, height)]]


def _rooms(
    rng: np.random.Generator, layout: Layout, width: float, depth: float, halls: list[int]
) -> list[int]:
    """Add a row of rooms below the halls, each with a door to one; returns their indices."""
    band = Band((0.0, -depth, width, 0.0), along_x=True, front_high=True)
    row = fill(rng, band.length, band.depth, layout.thickness, SIZES, WISHES)
    rooms = []
    for (use, length), start in zip(row, starts(row), strict=False):
        if use != "gap":
            rooms.append(layout.add(use, [band.part(start, length)]))
            layout.join_longest(rng, rooms[-1], halls)
    return rooms
