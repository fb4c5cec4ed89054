"""Colour for a plan: every material drawn from the palette of its room or piece of furniture."""

import colorsys
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators.layout import FRAME
from tutorial_lib.world.generators.palette import (
    COLOURS,
    FEATURES,
    FURNITURE,
    GAMMA,
    NOISE,
    PALETTES,
    WALLS,
    Feature,
    Range,
    Strip,
)
from tutorial_lib.world.materials import PERIOD, Colour, Look, Material, Stripe

LINE = 0.03
"""Metres: width of a tile line, of a frame, and of half the narrowest field."""


def dress(
    plan: FloorPlan, uses: Mapping[str, str], rng: np.random.Generator, palette: str
) -> FloorPlan:
    """The same plan in colour.

    Args:
        plan: its materials are named after rooms, or after furniture with a number.
        uses: for each material of a room, what the room is used for.
        rng: draws all colours.
        palette: one of `PALETTES`.
    """
    column = PALETTES.index(palette)
    used = {*plan.wall_materials, *(piece.material for piece in plan.furniture)}
    materials = []
    for name in (material.name for material in plan.materials if material.name in used):
        materials.append(_material(rng, name, _strip(name, uses), column))
    gammas = GAMMA[column]
    look = Look(
        palette=palette,
        floor=_colour(rng, "floor", column),
        ceiling=_colour(rng, "ceiling", column),
        gamma=round(rng.uniform(*gammas[rng.integers(len(gammas))]), 3),
        noise=round(rng.uniform(*NOISE[column]), 2),
    )
    return replace(plan, materials=tuple(materials), look=look)


def _strip(name: str, uses: Mapping[str, str]) -> Strip:
    """The table's entry for a material's name."""
    if name == FRAME:
        return WALLS[FRAME]
    room = name.split(", lap")[0]
    if room in uses:
        return WALLS[uses[room]]
    return FURNITURE[name.rsplit(" ", 1)[0]]


def _material(rng: np.random.Generator, name: str, strip: Strip, column: int) -> Material:
    """One strip, full of features from its beginning to its end."""
    base = _colour(rng, strip.base[rng.integers(len(strip.base))], column)
    stripes = _tiles(rng, strip.tiles, base)
    names, chance = list(strip.features), np.array(list(strip.features.values()))
    count = int(2 * PERIOD / (0.05 + strip.gap[0]))  # more than ever fit
    order = rng.choice(len(names), size=count, p=chance / chance.sum())
    at = rng.uniform(*strip.gap)
    for number in order:
        if at > PERIOD - 2 * LINE:
            break
        feature = FEATURES[names[number]]
        width = feature.width[0] + (feature.width[1] - feature.width[0]) * rng.random() ** 2
        width = min(width, PERIOD - at)
        stripes += _draw(rng, feature, at, width, column)
        at += width + rng.uniform(*strip.gap)
    return Material(name, base, tuple(stripes))


def _tiles(rng: np.random.Generator, spacing: Range, base: Colour) -> list[Stripe]:
    """Regular lines, a little darker than the base."""
    if not spacing[1]:
        return []
    count = round(PERIOD / rng.uniform(*spacing))
    red, green, blue = (int(channel * 0.8) for channel in base)
    starts = (i * PERIOD / count for i in range(count))
    return [_stripe(start, start + LINE, (red, green, blue)) for start in starts]


def _draw(
    rng: np.random.Generator, feature: Feature, start: float, width: float, column: int
) -> list[Stripe]:
    """The stripes of one feature: its frame, then its fields."""
    stripes, border = [], 0.0
    if feature.frame:
        border = min(LINE, width / 4)
        stripes = [_stripe(start, start + width, _colour(rng, feature.frame, column))]
    count = int(rng.integers(feature.fields[0], feature.fields[1] + 1))
    count = max(min(count, int(width / (border + 2 * LINE))), 1)
    shares = (0.5 + rng.random(count)).tolist()
    scale = (width - border) / sum(shares)
    low = start + border / 2
    for share, number in zip(shares, rng.integers(len(feature.colours), size=count), strict=True):
        high = low + share * scale
        colour = _colour(rng, feature.colours[number], column)
        stripes.append(_stripe(low + border / 2, high - border / 2, colour))
        low = high
    return stripes


def _stripe(start: float, end: float, colour: Colour) -> Stripe:
    return Stripe(round(start, 3), min(round(end, 3), PERIOD), colour)


def _colour(rng: np.random.Generator, name: str, column: int) -> Colour:
    """A colour of that name, in whole numbers from 0 to 255."""
    hue, saturation, value = COLOURS[name][column]
    a, b, c = rng.random(3).tolist()
    red, green, blue = colorsys.hsv_to_rgb(
        (hue[0] + a * (hue[1] - hue[0])) / 360,
        (saturation[0] + b * (saturation[1] - saturation[0])) / 100,
        (value[0] + c * (value[1] - value[0])) / 100,
    )
    return round(255 * red), round(255 * green), round(255 * blue)
