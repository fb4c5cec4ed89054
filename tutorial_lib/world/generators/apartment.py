"""Apartments: a hallway with bedrooms and bathrooms, and a living room with its kitchen."""

from itertools import pairwise

import numpy as np

from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.programme import Size, fill, starts
from tutorial_lib.world.generators.rectilinear import DoesNotFit, Rect, tidy
from tutorial_lib.world.generators.skeletons import Band, Skeleton, comb, ring

SIZES = {
    "living": Size(20.5, 44.0, 2.1),
    "kitchen": Size(8.2, 19.5),
    "bedroom": Size(9.2, 21.5, 1.9),
    "bathroom": Size(5.0, 9.8, 2.5),
    "office": Size(7.5, 16.0),
    "storage": Size(4.0, 8.5, 2.6),
}
WISHES = {"bedroom": 4.0, "bathroom": 2.0, "office": 1.3, "storage": 1.0, "living": 0.8}
DEPTH = (3.6, 4.9)
SECOND_LIVING_ROOM = 13.0
"""Metres; a longer band has a living room of its own."""


def apartment(rng: np.random.Generator, area: float) -> Layout:
    """Draw an apartment of about `area` square metres.

    Raises:
        DoesNotFit: if this draw cannot be built.
    """
    layout = Layout(tidy(rng.choice([0.10, 0.12, 0.14])))
    hall = tidy(rng.uniform(1.45, 2.2) + layout.thickness)
    skeleton = _skeleton(rng, area, min(hall, 2.3)).turned(rng)
    halls = layout.add_corridors(rng, skeleton.corridors)
    if skeleton.cap:
        _living_at_the_end(rng, layout, skeleton.cap, halls)
    social = None if skeleton.cap else max(skeleton.bands, key=lambda band: band.length)
    for band in skeleton.bands:
        _band(rng, layout, band, halls, social is band)
    _check(layout)
    return layout


def _skeleton(rng: np.random.Generator, area: float, hall: float) -> Skeleton:
    """A hallway whose shape depends on the apartment's size in square metres."""
    across = sum(DEPTH) + hall
    if area < 190.0 or (area < 240.0 and rng.random() < 0.5):
        cap = tidy(rng.uniform(3.8, 5.2)) if rng.random() < 0.5 else 0.0
        return comb(rng, tidy(area / across - cap), hall, DEPTH, cap=cap)
    if area > 260.0 and rng.random() < 0.4:
        core = rng.uniform(2.9, 4.8) if area < 330.0 or rng.random() < 0.5 else 2 * DEPTH[0]
        height = core + 2 * hall
        width = (area / 1.05 - 2 * 4.2 * height) / (height + 2 * 4.2)
        return ring(rng, (tidy(max(width, 6.0)), tidy(height)), hall, DEPTH, parts=2)
    branches = 1 if area < 260.0 else 2 if area < 360.0 else 3
    reach = [tidy(value) for value in rng.uniform(6.0, 10.0, 3)]
    length = tidy((area - sum(reach[:branches]) * 6.0) / across)
    first, other = (tidy(value) for value in rng.uniform(0.0, max(length - hall, 0.0), 2))
    ends = [(0.0, reach[0]), (tidy(length - hall), reach[1])]
    if branches == 1:
        cap = tidy(rng.uniform(3.8, 5.2)) if rng.random() < 0.3 else 0.0
        return comb(rng, length, hall, DEPTH, [(first, reach[0])], cap=cap)
    if branches == 2 and rng.random() < 0.5:
        return comb(rng, length, hall, DEPTH, [(first, reach[0])], [(other, reach[1])])
    return comb(rng, length, hall, DEPTH, ends, [(other, reach[2])] if branches == 3 else ())


def _living_at_the_end(
    rng: np.random.Generator, layout: Layout, cap: Band, halls: list[int]
) -> None:
    """The living room across the hallway's end, the kitchen in one corner of it."""
    wall = layout.thickness
    kitchen = tidy(rng.uniform(9.5, 15.0) / (cap.depth - wall) + wall)
    first = rng.random() < 0.5
    rooms = [("kitchen", kitchen), ("living", cap.length - kitchen)]
    row = rooms if first else rooms[::-1]
    numbers = {
        use: layout.add(use, [cap.part(start, width)])
        for (use, width), start in zip(row, starts(row), strict=False)
    }
    layout.join_longest(rng, numbers["living"], halls)
    layout.join_longest(rng, numbers["kitchen"], [numbers["living"]])


def _band(
    rng: np.random.Generator, layout: Layout, band: Band, halls: list[int], social: bool
) -> None:
    """Cut a band into rooms and give every one its doors."""
    must = ("living", "kitchen") if social else ()
    if not social and band.length > SECOND_LIVING_ROOM:
        must = ("living",)
    row = fill(rng, band.length, band.depth, layout.thickness, SIZES, WISHES, must)
    uses = [use for use, _ in row]
    slots = list(zip(starts(row), [width for _, width in row], strict=False))
    shapes = [[band.part(start, width)] for start, width in slots]
    _shorten_bathrooms(rng, layout, band, uses, slots, shapes)
    numbers = [layout.add(use, shape) for use, shape in zip(uses, shapes, strict=True)]
    for use, number in zip(uses, numbers, strict=True):
        if use != "kitchen" or rng.random() < 0.6:
            layout.join_longest(rng, number, halls)
    for one, two in pairwise(numbers):
        pair = {layout.rooms[one].use, layout.rooms[two].use}
        if pair == {"living", "kitchen"} and not layout.join(rng, one, two):
            raise DoesNotFit("a kitchen that cannot open to its living room")
        if pair in ({"living", "office"}, {"kitchen", "storage"}) and rng.random() < 0.6:
            layout.join(rng, one, two)


def _shorten_bathrooms(
    rng: np.random.Generator,
    layout: Layout,
    band: Band,
    uses: list[str],
    slots: list[tuple[float, float]],
    shapes: list[list[Rect]],
) -> None:
    """Let a bedroom or living room reach around the back of the bathroom beside it."""
    if band.depth < 4.2:
        return
    for i, use in enumerate(uses):
        beside = [j for j in (i - 1, i + 1) if 0 <= j < len(uses)]
        takers = [j for j in beside if uses[j] in ("bedroom", "living") and len(shapes[j]) == 1]
        if use != "bathroom" or not takers or rng.random() < 0.3:
            continue
        taker = takers[rng.integers(len(takers))]
        depth = tidy(rng.uniform(2.3, band.depth - 1.85))
        bathroom = band.part(*slots[i], far=depth)
        grown = [*shapes[taker], band.part(*slots[i], near=depth)]
        size, width = SIZES[uses[taker]], slots[i][1]
        area = Layout(layout.thickness)
        area.add(uses[taker], grown)
        small = (width - layout.thickness) * (depth - layout.thickness)
        if small >= SIZES["bathroom"].least and area.rooms[0].area <= size.most:
            shapes[i], shapes[taker] = [bathroom], grown


def _check(layout: Layout) -> None:
    """An apartment needs somewhere to sleep and to wash."""
    uses = [room.use for room in layout.rooms]
    baths, beds = uses.count("bathroom"), uses.count("bedroom")
    if not 1 <= baths <= beds + 1:
        raise DoesNotFit("bedrooms and bathrooms out of proportion")
