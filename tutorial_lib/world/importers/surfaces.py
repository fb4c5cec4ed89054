"""Materials for walls from a map, which does not record how they look."""

import colorsys
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_SURFACES
from tutorial_lib.validation import one_of, whole
from tutorial_lib.world.materials import PERIOD, Colour, Look, Material, Stripe

PALETTES = ("standard", "shifted")
SPAN = 25.0
"""Metres of outline after which the material changes, before its strip would repeat."""
_OWN = 4.0  # metres around, from which an obstacle has materials of its own
_NEAR = 0.01  # metres from a corner within which no cut is made; the corner is used
_PITCH = 0.8  # metres from one feature to the next, on average
# Hues around the circle: no wall or poster of "shifted" has a hue that "standard" knows.
_WALL_HUES = {"standard": (0.04, 0.10, 0.15, 0.57, 0.62), "shifted": (0.30, 0.37, 0.80, 0.88)}
_POSTER_HUES = {
    "standard": (0.00, 0.08, 0.15, 0.33, 0.55, 0.64, 0.78),
    "shifted": (0.04, 0.115, 0.22, 0.44, 0.50, 0.71, 0.90),
}

Walls = tuple[NDArray[np.float64], tuple[str, ...], NDArray[np.float64], tuple[Material, ...]]


def check_choice(seed: int, palette: str) -> None:
    """Check what the caller chose.

    Raises:
        InputError: when `seed` is negative or no whole number, or `palette` is unknown.
    """
    whole("seed", seed, least=0)
    one_of("palette", palette, PALETTES)


def imported_look(rng: np.random.Generator, palette: str) -> Look:
    """Floor, ceiling, gamma and noise of an imported world."""
    if palette == "standard":
        floor = _colour(rng, (0.06, 0.10), (0.15, 0.35), (0.40, 0.58))
        return Look(palette, floor, _colour(rng, (0.55, 0.65), (0.0, 0.05), (0.80, 0.90)))
    floor = _colour(rng, (0.28, 0.80), (0.30, 0.50), (0.25, 0.45))
    ceiling = _colour(rng, (0.10, 0.35), (0.15, 0.30), (0.60, 0.75))
    low, high = ((0.7, 0.8), (1.3, 1.5))[int(rng.integers(2))]
    gamma, noise = round(rng.uniform(low, high), 3), round(rng.uniform(6.0, 12.0), 3)
    return Look(palette, floor, ceiling, gamma, noise)


def dress_loops(
    loops: Sequence[NDArray[np.float64]], rng: np.random.Generator, palette: str
) -> Walls:
    """Walls along closed loops, with materials that tell places apart.

    A loop longer than `SPAN` is cut into equal spans of at most that length, each with its own
    material; small obstacles share strips, each at a stretch of its own.

    Args:
        loops: each (K, 2) corners in metres; a loop's last corner is joined to its first.
        rng: where the colours come from.
        palette: "standard" or "shifted".

    Returns:
        Walls (W, 4), W names of materials, offsets (W,) in metres, and the materials.

    Raises:
        InputError: when the loops are so long that they need more than `MAX_SURFACES`.
    """
    walls: list[NDArray[np.float64]] = []
    numbers: list[NDArray[np.intp]] = []
    offsets: list[NDArray[np.float64]] = []
    count, shared, used = 0, -1, SPAN
    for loop in loops:
        sides, along = _cut(loop)
        length = along[-1] + np.hypot(*(sides[-1, 2:] - sides[-1, :2]))
        if length < _OWN:
            if used + length > SPAN:
                shared, used, count = count, 0.0, count + 1
            number, offset = np.full(len(sides), shared), used + along
            used += length
        else:
            spans = int(np.ceil(length / SPAN))
            span = np.minimum(((along + _NEAR) / (length / spans)).astype(int), spans - 1)
            number, offset = count + span, np.maximum(along - span * (length / spans), 0.0)
            count += spans
        if count > MAX_SURFACES:
            raise InputError(
                f"its outlines need more than {MAX_SURFACES:,} materials, one for each "
                f"{SPAN:g} m; clean or scale down the map"
            )
        walls.append(sides)
        numbers.append(number)
        offsets.append(offset)
    materials = tuple(_material(f"surface{i}", rng, palette) for i in range(count))
    names = tuple(materials[number].name for number in np.concatenate(numbers).tolist())
    return np.concatenate(walls), names, np.round(np.concatenate(offsets), 6), materials


def _cut(loop: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A loop's sides (K, 4), cut where its material changes, and metres (K,) up to each."""
    ring = np.concatenate([loop, loop[:1]])
    place = np.append(0.0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T)))
    spans = int(np.ceil(place[-1] / SPAN))
    cuts = np.arange(1, spans) * (place[-1] / spans)
    after = np.searchsorted(place, cuts)
    near = np.minimum(cuts - place[after - 1], place[after] - cuts) < _NEAR
    cuts = cuts[~near]
    at = np.searchsorted(place, cuts)
    share = ((cuts - place[at - 1]) / (place[at] - place[at - 1]))[:, None]
    ring = np.insert(ring, at, ring[at - 1] + share * (ring[at] - ring[at - 1]), axis=0)
    place = np.insert(place, at, cuts)
    return np.concatenate([ring[:-1], ring[1:]], axis=1), place[:-1]


def _material(name: str, rng: np.random.Generator, palette: str) -> Material:
    """A strip with a distinctive feature every `_PITCH` metres on average."""
    stripes: list[Stripe] = []
    hue = float(rng.choice(_WALL_HUES[palette]))
    deep = palette == "shifted"
    colour = _colour(
        rng,
        (hue - 0.02, hue + 0.02),
        (0.25, 0.55) if deep else (0.05, 0.45),
        (0.40, 0.80) if deep else (0.60, 0.92),
    )
    feature = (_poster, _poster, _window, _frame, _frame)
    left = rng.uniform(0.0, 0.3)
    while left < PERIOD - 0.1:
        width = feature[int(rng.integers(len(feature)))](stripes, left, rng, palette)
        left += width + max(0.08, rng.exponential(_PITCH - 0.55))
    fitting = [Stripe(s.start, min(s.end, PERIOD), s.colour) for s in stripes if s.start < PERIOD]
    return Material(name, colour, tuple(fitting))


def _poster(stripes: list[Stripe], left: float, rng: np.random.Generator, palette: str) -> float:
    """A poster of several colours, 0.3 to 1.5 m wide; the width in metres."""
    width = 0.3 + 1.2 * rng.beta(1.2, 2.2)
    inner = np.sort(rng.uniform(0.0, width, int(rng.integers(1, 5))))
    edges = [0.0, *inner.tolist(), width]
    for start, end in pairwise(edges):
        _add(stripes, left + start, left + end, _vivid(rng, palette))
    return width


def _window(stripes: list[Stripe], left: float, rng: np.random.Generator, palette: str) -> float:
    """A window with a frame and up to two bars; the width in metres."""
    width = rng.uniform(0.5, 1.2)
    standard = palette == "standard"
    glass = (0.50, 0.58) if standard else (0.10, 0.16)
    _add(stripes, left, left + width, _grey(rng, 215, 250) if standard else _grey(rng, 10, 50))
    panes = int(rng.integers(1, 4))
    pane = (width - 0.06) / panes
    colour = _colour(rng, glass, (0.15, 0.45), (0.55, 0.95))
    for k in range(panes):
        start = left + 0.06 + k * pane
        _add(stripes, start, start + pane - 0.06, colour)
    return width


def _frame(stripes: list[Stripe], left: float, rng: np.random.Generator, palette: str) -> float:
    """A post or pipe of one colour; the width in metres."""
    width = rng.uniform(0.08, 0.30)
    dark = rng.random() < 0.5
    _add(stripes, left, left + width, _grey(rng, 15, 70) if dark else _vivid(rng, palette))
    return width


def _add(stripes: list[Stripe], start: float, end: float, colour: Colour) -> None:
    start, end = round(float(start), 3), round(float(end), 3)
    if start < min(end, PERIOD):
        stripes.append(Stripe(start, min(end, PERIOD), colour))


def _vivid(rng: np.random.Generator, palette: str) -> Colour:
    hue = float(rng.choice(_POSTER_HUES[palette]))
    return _colour(rng, (hue - 0.015, hue + 0.015), (0.45, 1.0), (0.30, 0.95))


def _grey(rng: np.random.Generator, low: int, high: int) -> Colour:
    level = int(rng.integers(low, high + 1))
    return level, level, level


def _colour(
    rng: np.random.Generator,
    hue: tuple[float, float],
    saturation: tuple[float, float],
    value: tuple[float, float],
) -> Colour:
    """A colour drawn from ranges of hue, saturation and value, each 0 to 1."""
    h, s, v = (rng.uniform(*between) for between in (hue, saturation, value))
    red, green, blue = (round(255 * channel) for channel in colorsys.hsv_to_rgb(h % 1.0, s, v))
    return red, green, blue
