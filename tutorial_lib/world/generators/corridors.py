"""Loop corridors: a ring or a figure eight, with a few rooms inside and outside."""

from collections.abc import Sequence

import numpy as np

from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.programme import Size, fill, starts
from tutorial_lib.world.generators.rectilinear import DoesNotFit, tidy
from tutorial_lib.world.generators.skeletons import Band, Skeleton, ring

NOTHING = "gap"
"""The use of a slot that stays outside the building."""
SIZES = {
    "office": Size(9.0, 18.0),
    "storage": Size(5.0, 12.0, 2.6),
    "open": Size(10.0, 24.0),
    "lounge": Size(11.0, 24.0),
    "bathroom": Size(5.5, 11.0, 2.6),
    NOTHING: Size(5.0, 40.0, 4.0),
}
WISHES = {"office": 2.0, "storage": 1.0, "open": 1.0, "lounge": 1.0, "bathroom": 0.7}
DEPTH = (3.2, 4.6)
FEWEST = 3
"""Least number of rooms of a loop."""


def loop_corridor(rng: np.random.Generator, area: float) -> Layout:
    """Draw a loop corridor of about `area` square metres.

    Raises:
        DoesNotFit: if this draw cannot be built.
    """
    layout = Layout(tidy(rng.choice([0.10, 0.12, 0.14])))
    hall = tidy(rng.uniform(1.45, 2.2) + layout.thickness)
    crowd = rng.uniform(0.2, 0.5) + 0.25 * (area > 250.0)  # a long ring needs more to see
    skeleton = _skeleton(rng, area, hall, crowd).turned(rng)
    halls = layout.add_corridors(rng, skeleton.corridors)
    for band in skeleton.bands:
        _band(rng, layout, band, halls, crowd)
    if len(layout.rooms) < len(halls) + FEWEST:
        raise DoesNotFit("a loop without rooms")
    return layout


def _band(
    rng: np.random.Generator, layout: Layout, band: Band, halls: Sequence[int], crowd: float
) -> None:
    """Cut a band into rooms and gaps, and give the rooms their doors."""
    wishes = WISHES | {NOTHING: sum(WISHES.values()) * (1.0 - crowd) / crowd}
    row = fill(rng, band.length, band.depth, layout.thickness, SIZES, wishes)
    for (use, width), start in zip(row, starts(row), strict=False):
        if use == NOTHING:
            continue
        number = layout.add(use, [band.part(start, width)])
        hall = layout.join_longest(rng, number, halls)
        if use in ("open", "lounge") and rng.random() < 0.5:
            layout.join(rng, number, hall)


def _skeleton(rng: np.random.Generator, area: float, hall: float, crowd: float) -> Skeleton:
    """A ring whose length depends on the area in square metres."""
    half_perimeter = area / (hall + 4.4 * crowd) / 2
    width = half_perimeter * rng.uniform(0.45, 0.65)
    height = half_perimeter - width
    if min(width, height) < 2 * hall + 1.0:
        raise DoesNotFit("a ring without a hole")
    bars = int(width > 12.0 and rng.random() < 0.5)
    parts = int(rng.choice([2, 4]))
    return ring(rng, (tidy(width), tidy(height)), hall, DEPTH, bars, parts)
