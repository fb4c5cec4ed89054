"""Offices: corridors of several shapes, with offices and shared rooms on both sides."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.programme import Size, fill, starts
from tutorial_lib.world.generators.rectilinear import DoesNotFit, tidy
from tutorial_lib.world.generators.skeletons import Band, Skeleton, comb, ring

SIZES = {
    "office": Size(9.5, 22.0, 2.0),
    "meeting": Size(15.0, 38.0, 2.0),
    "open plan": Size(30.0, 75.0, 3.0),
    "kitchen": Size(8.5, 19.0),
    "bathroom": Size(6.5, 14.0, 2.6),
    "storage": Size(5.5, 14.0, 2.6),
    "lounge": Size(12.0, 28.0, 2.0),
}
WISHES = {
    "office": 7.0,
    "meeting": 1.0,
    "open plan": 0.7,
    "kitchen": 0.5,
    "bathroom": 0.7,
    "storage": 0.7,
    "lounge": 0.4,
}
SHARED = ("meeting", "kitchen", "bathroom")
"""What every office has."""
DEPTH = (4.0, 5.8)


def office(rng: np.random.Generator, area: float) -> Layout:
    """Draw an office of about `area` square metres.

    Raises:
        DoesNotFit: if this draw cannot be built.
    """
    layout = Layout(tidy(rng.choice([0.10, 0.12, 0.14])))
    hall = tidy(rng.uniform(1.6, 2.2) + layout.thickness)
    skeleton = _skeleton(rng, area, hall).turned(rng)
    halls = layout.add_corridors(rng, skeleton.corridors)
    if skeleton.cap:
        _room_at_the_end(rng, layout, skeleton.cap, halls)
    for band in skeleton.bands:
        add_band(rng, layout, band, halls)
    uses = [room.use for room in layout.rooms]
    if not set(SHARED) <= set(uses) or uses.count("kitchen") > 2:
        raise DoesNotFit("an office without the rooms that it needs")
    return layout


def add_band(rng: np.random.Generator, layout: Layout, band: Band, halls: Sequence[int]) -> None:
    """Cut a band into rooms with doors to the corridor, and here and there to one another."""
    row = fill(rng, band.length, band.depth, layout.thickness, SIZES, WISHES)
    numbers = []
    for (use, width), start in zip(row, starts(row), strict=False):
        number = layout.add(use, [band.part(start, width)])
        hall = layout.join_longest(rng, number, halls)
        others = [other for other in halls if other != hall]
        if width > 5.0 and rng.random() < 0.6:
            layout.join(rng, number, hall)
        if use in ("meeting", "open plan", "lounge", "office"):
            for other in others:
                if rng.random() < 0.5:
                    layout.join(rng, number, other)
        numbers.append(number)
    for one, two in pairwise(numbers):
        pair = {layout.rooms[one].use, layout.rooms[two].use}
        if "bathroom" not in pair and rng.random() < (0.15 if pair == {"office"} else 0.25):
            layout.join(rng, one, two)


def _room_at_the_end(
    rng: np.random.Generator, layout: Layout, cap: Band, halls: Sequence[int]
) -> None:
    """A large room across the corridor's end."""
    use = ("open plan", "meeting", "lounge")[rng.integers(3)]
    number = layout.add(use, [cap.part(0.0, cap.length)])
    layout.join_longest(rng, number, halls)


def _skeleton(rng: np.random.Generator, area: float, hall: float) -> Skeleton:
    """Corridors whose shape depends on the office's size in square metres."""
    across = sum(DEPTH) + hall
    form = rng.choice(_forms(area))
    if form == "straight":
        cap = tidy(rng.uniform(3.5, 5.0)) if rng.random() < 0.5 else 0.0
        return comb(rng, tidy(area / across - cap), hall, DEPTH, cap=cap)
    if form == "ring":
        core = rng.choice([0.0, rng.uniform(4.0, 6.0), rng.uniform(8.2, 10.0)], p=[0.1, 0.5, 0.4])
        height = max(core, 2.0) + 2 * hall
        width = (area / 1.05 - 2 * 4.9 * height) / (height + 2 * 4.9)
        parts = int(rng.choice([2, 4]))
        return ring(rng, (tidy(max(width, 6.5)), tidy(height)), hall, DEPTH, parts=parts)
    reach = [tidy(value) for value in rng.uniform(5.5, 10.0, 2)]
    if form == "tee":
        length = tidy((area - reach[0] * 7.0) / across)
        at = tidy(rng.uniform(0.0, max(length - hall, 0.0)))
        return comb(rng, length, hall, DEPTH, [(at, reach[0])])
    length = tidy((area - sum(reach) * 7.0) / across)
    if form == "u":
        return comb(rng, length, hall, DEPTH, [(0.0, reach[0]), (tidy(length - hall), reach[1])])
    at, other = (tidy(value) for value in rng.uniform(0.0, max(length - hall, 0.0), 2))
    return comb(rng, length, hall, DEPTH, [(at, reach[0])], [(other, reach[1])])


def _forms(area: float) -> list[str]:
    """The shapes of corridor that fit an area in square metres."""
    smallest = {"straight": 0.0, "tee": 170.0, "u": 260.0, "z": 260.0, "ring": 230.0}
    return [name for name, least in smallest.items() if least <= area][-4:]
