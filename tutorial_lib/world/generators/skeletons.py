"""Where corridors run, and the bands beside them that are cut into rooms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tutorial_lib.world.generators.rectilinear import DoesNotFit, Rect, tidy

Range = tuple[float, float]

SHORTEST = 2.6
"""Metres: a shorter band is not worth building."""


@dataclass(frozen=True)
class Band:
    """A strip of building beside a corridor.

    Attributes:
        rect: up to the middle of its walls.
        along_x: whether the corridor, and so the row of rooms, runs along x.
        front_high: whether the corridor is on the side of high y (or x).
    """

    rect: Rect
    along_x: bool
    front_high: bool

    @property
    def length(self) -> float:
        """Metres along the corridor."""
        x0, y0, x1, y1 = self.rect
        return x1 - x0 if self.along_x else y1 - y0

    @property
    def depth(self) -> float:
        """Metres away from the corridor."""
        x0, y0, x1, y1 = self.rect
        return y1 - y0 if self.along_x else x1 - x0

    def part(self, start: float, length: float, near: float = 0.0, far: float = 1e9) -> Rect:
        """A slot: metres along the band, and between `near` and `far` metres from the corridor."""
        x0, y0, _, y1 = self.rect if self.along_x else _transposed(self.rect)
        far = min(far, self.depth)
        low, high = (y1 - far, y1 - near) if self.front_high else (y0 + near, y0 + far)
        rect = tidy(x0 + start), tidy(low), tidy(x0 + start + length), tidy(high)
        return rect if self.along_x else _transposed(rect)


@dataclass(frozen=True)
class Skeleton:
    """Corridors, each a group of rectangles that make one room, and the bands beside them.

    Attributes:
        corridors: groups of rectangles; groups that touch are joined by a door.
        bands: to be cut into rooms.
        cap: a band across the corridor's end, if there is one.
    """

    corridors: list[list[Rect]]
    bands: list[Band]
    cap: Band | None = None

    def turned(self, rng: np.random.Generator) -> Skeleton:
        """The same seen in a mirror or turned, at random."""
        flip_x, flip_y, swap = rng.random(3) < 0.5

        def rect(r: Rect) -> Rect:
            x0, y0, x1, y1 = r
            x0, x1 = (-x1, -x0) if flip_x else (x0, x1)
            y0, y1 = (-y1, -y0) if flip_y else (y0, y1)
            return (y0, x0, y1, x1) if swap else (x0, y0, x1, y1)

        def band(b: Band) -> Band:
            flipped = flip_y if b.along_x else flip_x
            return Band(rect(b.rect), b.along_x != swap, b.front_high != flipped)

        return Skeleton(
            [[rect(r) for r in group] for group in self.corridors],
            [band(b) for b in self.bands],
            self.cap and band(self.cap),
        )


def comb(
    rng: np.random.Generator,
    length: float,
    hall: float,
    depth: Range,
    below: Sequence[tuple[float, float]] = (),
    above: Sequence[tuple[float, float]] = (),
    cap: float = 0.0,
) -> Skeleton:
    """A straight corridor with side branches: I, L, T, U, Z, H, all are combs.

    Args:
        rng: draws the bands' depths.
        length: of the corridor, in metres.
        hall: the corridor's width, in metres.
        depth: least and greatest depth of a band, in metres.
        below: branches on that side, each with its position along the corridor and its length.
        above: branches on the other side.
        cap: width of the room across the corridor's end, in metres; 0 for none.
    """
    corridor = [(0.0, 0.0, length, hall)]
    corridor += [(at, -reach, at + hall, 0.0) for at, reach in below]
    corridor += [(at, hall, at + hall, hall + reach) for at, reach in above]
    bands = [
        Band((x0, -y1, x1, -y0), along_x, not high if along_x else high)
        for (x0, y0, x1, y1), along_x, high in _side(rng, length, hall, depth, below)
    ]
    bands += [
        Band((x0, hall + y0, x1, hall + y1), along_x, high)
        for (x0, y0, x1, y1), along_x, high in _side(rng, length, hall, depth, above)
    ]
    end = None
    if cap and all(band.rect[2] <= length + 1e-6 for band in bands):
        beside = [band.rect for band in bands if band.rect[2] > length - 1e-6]
        low, high = min(rect[1] for rect in beside), max(rect[3] for rect in beside)
        end = Band((length, max(low, -6.0), length + cap, min(high, hall + 6.0)), False, False)
    return Skeleton([corridor], bands, end)


def _side(
    rng: np.random.Generator,
    length: float,
    hall: float,
    depth: Range,
    branches: Sequence[tuple[float, float]],
) -> list[tuple[Rect, bool, bool]]:
    """The bands on one side of a corridor, which lies below y = 0."""
    bands: list[tuple[Rect, bool, bool]] = []
    start = 0.0
    for at, reach in branches:
        left, right = (tidy(rng.uniform(*depth)) for _ in range(2))
        if 0.0 < at - left - start < SHORTEST:
            left = at - start  # too little for another band: the branch's own gets deeper
        if start > 0.0 and at - left < start:
            raise DoesNotFit("branches too close to each other")
        if at - left - start >= SHORTEST:
            bands.append(((start, 0.0, at - left, tidy(rng.uniform(*depth))), True, False))
        bands.append(((at - left, 0.0, at, reach), False, True))
        bands.append(((at + hall, 0.0, at + hall + right, reach), False, False))
        start = at + hall + right
    if length - start >= SHORTEST:
        bands.append(((start, 0.0, length, tidy(rng.uniform(*depth))), True, False))
    return bands


def ring(
    rng: np.random.Generator,
    size: tuple[float, float],
    hall: float,
    depth: Range,
    bars: int = 0,
    parts: int = 2,
) -> Skeleton:
    """A corridor around one or more cores; with a bar across, a figure eight.

    Args:
        rng: draws the depths of the outer bands.
        size: of the corridor's outer rectangle, in metres.
        hall: the corridor's width, in metres.
        depth: least and greatest depth of an outer band, in metres.
        bars: how many corridors run across.
        parts: of how many pieces, with doors between, the ring is made: 2 or 4.
    """
    width, height = size
    bottom, top = (0.0, 0.0, width, hall), (0.0, height - hall, width - hall, height)
    right, left = (width - hall, hall, width, height), (0.0, hall, hall, height - hall)
    pieces = [[bottom, right], [top, left]] if parts == 2 else [[bottom], [right], [top], [left]]
    pitch = (width - hall) / (bars + 1)
    starts = [tidy(i * pitch) for i in range(bars + 2)]
    pieces += [[(x, hall, tidy(x + hall), height - hall)] for x in starts[1:-1]]
    south, north, west, east = (tidy(value) for value in rng.uniform(*depth, 4))
    bands = [
        Band((0.0, -south, width, 0.0), True, True),
        Band((0.0, height, width, height + north), True, False),
        Band((-west, 0.0, 0.0, height), False, True),
        Band((width, 0.0, width + east, height), False, False),
    ]
    for x0, x1 in pairwise(starts):
        bands += _core(rng, (tidy(x0 + hall), hall, x1, tidy(height - hall)), depth)
    return Skeleton(pieces, bands)


def _core(rng: np.random.Generator, rect: Rect, depth: Range) -> list[Band]:
    """The bands inside a ring: one row, two back to back, or two with a courtyard between."""
    x0, y0, x1, y1 = rect
    height = y1 - y0
    if x1 - x0 < SHORTEST or height < SHORTEST:
        return []
    if height < 1.5 * depth[0]:
        return [Band(rect, True, False)]
    south, north = (tidy(value) for value in rng.uniform(*depth, 2))
    if south + north + 2.0 > height:
        south = tidy(height / 2)
        north = height - south
    return [
        Band((x0, y0, x1, y0 + south), True, False),
        Band((x0, y1 - north, x1, y1), True, True),
    ]


def _transposed(rect: Rect) -> Rect:
    x0, y0, x1, y1 = rect
    return y0, x0, y1, x1
