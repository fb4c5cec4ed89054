"""Which rooms a band is cut into, and how wide each gets."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tutorial_lib.world.generators.rectilinear import DoesNotFit, tidy

SOCIABLE = ("bedroom", "office", "gap")
"""Uses of which two may be side by side."""
NARROWEST = 1.65
"""Metres between the walls of the narrowest room."""


@dataclass(frozen=True)
class Size:
    """What a room may measure: least and greatest square metres, and length over width at most."""

    least: float
    most: float
    stretch: float = 2.2

    def widths(self, depth: float, wall: float) -> tuple[float, float]:
        """Least and greatest width, in metres from wall to wall, at a given depth."""
        inner = depth - wall
        low = max(self.least / inner, inner / self.stretch, NARROWEST)
        high = min(self.most / inner, inner * self.stretch)
        return low + wall, high + wall


def fill(
    rng: np.random.Generator,
    length: float,
    depth: float,
    wall: float,
    sizes: Mapping[str, Size],
    wishes: Mapping[str, float],
    must: Sequence[str] = (),
) -> list[tuple[str, float]]:
    """Cut a band into rooms.

    Args:
        rng: draws the rooms.
        length: of the band, in metres.
        depth: of the band, in metres.
        wall: thickness of the walls, in metres.
        sizes: what each use may measure.
        wishes: how often each use is drawn; only some uses may be their own neighbours.
        must: uses that have to be there, side by side and in this order.

    Returns:
        Uses and widths in metres, in order; the widths add up to `length`.

    Raises:
        DoesNotFit: if no drawn row fits.
    """
    spans = {use: sizes[use].widths(depth, wall) for use in sizes}
    possible = [use for use in wishes if spans[use][0] < spans[use][1]]
    if not possible or any(spans[use][0] >= spans[use][1] for use in must):
        raise DoesNotFit("a band too shallow or too deep for its rooms")
    chance = np.array([wishes[use] for use in possible])
    for _ in range(60):
        uses = _draw_row(rng, length, spans, possible, chance / chance.sum(), must)
        low = np.array([spans[use][0] for use in uses])
        high = np.array([spans[use][1] for use in uses])
        low, high = low + rng.uniform(0.0, 0.3, len(uses)) * (high - low), high
        if low.sum() <= length <= high.sum() and _neighbours_differ(uses):
            share = (length - low.sum()) / (high - low).sum()
            return list(zip(uses, (low + share * (high - low)).tolist(), strict=True))
    raise DoesNotFit("no row of rooms as long as the band")


def starts(row: Sequence[tuple[str, float]]) -> list[float]:
    """Where each room of a row begins, in metres along the band; one more for the end."""
    return [tidy(value) for value in np.cumsum([0.0, *(width for _, width in row)])]


def _draw_row(
    rng: np.random.Generator,
    length: float,
    spans: Mapping[str, tuple[float, float]],
    possible: Sequence[str],
    chance: np.ndarray,
    must: Sequence[str],
) -> list[str]:
    """Uses whose middle widths add up to about the length, the wanted ones at any place."""
    others: list[str] = []
    total = sum(sum(spans[use]) / 2 for use in must)
    while total < length or not (must or others):
        use = possible[rng.choice(len(possible), p=chance)]
        width = sum(spans[use]) / 2
        if (must or others) and total + width / 2 > length:
            break
        others.append(use)
        total += width
    at = rng.integers(len(others) + 1)
    block = list(must) if rng.random() < 0.5 else list(must)[::-1]
    return others[:at] + block + others[at:]


def _neighbours_differ(uses: Sequence[str]) -> bool:
    alike = (a for a, b in pairwise(uses) if a == b)
    return all(use in SOCIABLE for use in alike)
