"""Floor plans drawn at random: the same family and seed give the same plan, byte for byte."""

from collections.abc import Callable

import numpy as np

from tutorial_lib.validation import one_of, whole
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators.apartment import apartment
from tutorial_lib.world.generators.corridors import loop_corridor
from tutorial_lib.world.generators.dress import dress
from tutorial_lib.world.generators.furnish import furnish
from tutorial_lib.world.generators.hall import hall
from tutorial_lib.world.generators.layout import Layout
from tutorial_lib.world.generators.maze import maze
from tutorial_lib.world.generators.office import office
from tutorial_lib.world.generators.palette import PALETTES
from tutorial_lib.world.generators.rectilinear import DoesNotFit
from tutorial_lib.world.generators.repair import open_up
from tutorial_lib.world.generators.scanned import scanned
from tutorial_lib.world.generators.symmetric_office import symmetric_office
from tutorial_lib.world.generators.wayfinding import with_signs

_DRAW: dict[str, Callable[[np.random.Generator, float], Layout]] = {
    "apartment": apartment,
    "office": office,
    "symmetric_office": symmetric_office,
    "loop_corridor": loop_corridor,
    "maze": maze,
    "hall": hall,
}
FAMILIES = (*_DRAW, "scanned")
"""Kinds of world. A family's place in this list is part of its seed."""
SCANNED = ("apartment", "office", "maze", "hall", "hall")
"""Families of the buildings that are scanned, as often as they stand here."""
AREAS = {"any": (100.0, 500.0), "large": (200.0, 460.0)}
"""Least and greatest square metres of all rooms together, by size."""
HALL_AREAS = {"any": (300.0, 1500.0), "large": (600.0, 1500.0)}
"""The same for halls."""
SIGNS = ("plain", "wayfinding")
"""Whether a world's walls have accents that lead, see `wayfinding`."""
_WITHIN = (10.0, -30.0)
"""Margins in square metres by which the area aimed at keeps within these limits."""


def area_limits(family: str, size: str = "any") -> tuple[float, float]:
    """Least and greatest square metres of all rooms of a plan together."""
    one_of("family", family, FAMILIES)
    one_of("size", size, AREAS)
    return (HALL_AREAS if family == "hall" else AREAS)[size]


def generate(
    family: str, seed: int, palette: str = "standard", size: str = "any", signs: str = "plain"
) -> FloorPlan:
    """Draw a floor plan.

    Args:
        family: one of `FAMILIES`.
        seed: 0 or greater; it names a world in every family.
        palette: "standard", or "shifted" for the same rooms in colours that no standard world has.
        size: "any", or "large" for those in which maps are built (Meng 2020, Table II); it is
            another plan, even where the area would have fitted.
        signs: "plain", or "wayfinding" for the same plan with accents on its walls whose colour
            follows the distance along the corridors.

    Raises:
        InputError: if an argument is none of these.
    """
    one_of("family", family, FAMILIES)
    one_of("palette", palette, PALETTES)
    one_of("size", size, AREAS)
    one_of("signs", signs, SIGNS)
    seed = whole("seed", seed, least=0)
    plan = (_scanned if family == "scanned" else _drawn)(family, seed, palette, size)
    if signs == "plain":
        return plan
    return with_signs(plan, np.random.default_rng([FAMILIES.index(family), seed, 2]))


def _drawn(family: str, seed: int, palette: str, size: str) -> FloorPlan:
    """A plan of rooms and doors, furnished and in colour."""
    stream = [FAMILIES.index(family), seed]
    rng = np.random.default_rng(stream)
    least, most = area_limits(family, size)
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


def _scanned(family: str, seed: int, palette: str, size: str) -> FloorPlan:
    """The scan of the building that has the same seed in another family."""
    rng = np.random.default_rng([FAMILIES.index(family), seed])
    building = _drawn(SCANNED[rng.integers(len(SCANNED))], seed, "standard", size)
    while True:
        try:
            return scanned(building, (family, seed), rng, palette)
        except DoesNotFit:
            continue
