"""Floor plans drawn at random: the same family and seed give the same plan, byte for byte."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators.apartment import apartment
from tutorial_lib.world.generators.corridors import loop_corridor
from tutorial_lib.world.generators.dress import dress
from tutorial_lib.world.generators.furnish import furnish
from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.maze import maze
from tutorial_lib.world.generators.office import office
from tutorial_lib.world.generators.palette import PALETTES
from tutorial_lib.world.generators.rectilinear import DoesNotFit
from tutorial_lib.world.generators.repair import open_up
from tutorial_lib.world.generators.symmetric_office import symmetric_office

_DRAW: dict[str, Callable[[np.random.Generator, float], Layout]] = {
    "apartment": apartment,
    "office": office,
    "symmetric_office": symmetric_office,
    "loop_corridor": loop_corridor,
    "maze": maze,
}
FAMILIES = tuple(_DRAW)
"""Kinds of world. A family's place in this list is part of its seed."""
AREAS = {"any": (100.0, 500.0), "large": (200.0, 460.0)}
"""Least and greatest square metres of all rooms together, by size."""
_WITHIN = (10.0, -30.0)
"""Margins in square metres by which the area aimed at keeps within these limits."""


def generate(family: str, seed: int, palette: str = "standard", size: str = "any") -> FloorPlan:
    """Draw a floor plan.

    Args:
        family: one of `FAMILIES`.
        seed: 0 or greater; it names a world in every family.
        palette: "standard", or "shifted" for the same rooms in colours that no standard world has.
        size: "any", or "large" for those in which maps are built (Meng 2020, Table II); it is
            another plan, even where the area would have fitted.

    Raises:
        InputError: if an argument is none of these.
    """
    _check("family", family, FAMILIES)
    _check("palette", palette, PALETTES)
    _check("size", size, tuple(AREAS))
    seed = _whole(seed)
    stream = [FAMILIES.index(family), seed]
    rng = np.random.default_rng(stream)
    least, most = AREAS[size]
    aim = rng.uniform(least + _WITHIN[0], most + _WITHIN[1])
    while True:
        try:
            layout = _DRAW[family](rng, aim * rng.uniform(0.9, 1.1))
            if not least <= sum(room.area for room in layout.rooms) <= most:
                continue
            if not layout.furniture:  # rooms that are to look alike have theirs already
                furnish(rng, layout, range(len(layout.rooms)))
            plan = open_up(layout.plan(family, seed), layout.twins)
        except DoesNotFit:
            continue
        uses = {room.material: room.use for room in layout.rooms}
        return dress(plan, uses, np.random.default_rng([*stream, 1]), palette)


def _check(name: str, value: str, known: Sequence[str]) -> None:
    if value not in known:
        raise InputError(f"{name}: {value!r} is unknown; use one of {', '.join(known)}")


def _whole(seed: int) -> int:
    try:
        number = operator.index(seed)
    except TypeError:
        number = -1
    if number < 0 or isinstance(seed, bool):
        raise InputError(f"seed: {seed!r}; give a whole number, 0 or greater")
    return number
