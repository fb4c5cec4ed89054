"""Shapes with right angles: rectangles, and outlines that run counter-clockwise. In metres."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Rect = tuple[float, float, float, float]
"""x0, y0, x1, y1 with x0 < x1 and y0 < y1."""
Outline = tuple[Point, ...]


class DoesNotFit(Exception):  # noqa: N818 - not an error: the generator draws again
    """What was drawn cannot be built; the generator tries the next draw."""


def tidy(value: float) -> float:
    """A length rounded to 0.1 mm, so that equal places are equal numbers."""
    return round(float(value), 4) + 0.0


def overlap(a: Rect, b: Rect, margin: float = 0.0) -> bool:
    """Whether two rectangles come closer to each other than `margin` metres."""
    return (
        a[0] < b[2] + margin
        and b[0] < a[2] + margin
        and a[1] < b[3] + margin
        and b[1] < a[3] + margin
    )


def outline_of(rects: Sequence[Rect]) -> Outline:
    """The outline of rectangles that together make one region without holes."""
    xs = sorted({tidy(x) for rect in rects for x in rect[0::2]})
    ys = sorted({tidy(y) for rect in rects for y in rect[1::2]})
    mask = np.zeros((len(ys) - 1, len(xs) - 1), dtype=bool)
    for x0, y0, x1, y1 in rects:
        rows = slice(ys.index(tidy(y0)), ys.index(tidy(y1)))
        mask[rows, xs.index(tidy(x0)) : xs.index(tidy(x1))] = True
    return trace(mask, xs, ys)


def trace(mask: NDArray[np.bool_], xs: Sequence[float], ys: Sequence[float]) -> Outline:
    """Walk around the cells of a mask, with the cells on the left.

    Args:
        mask: (H, W) cells of one region.
        xs: the W + 1 lines between columns.
        ys: the H + 1 lines between rows.

    Raises:
        DoesNotFit: if the region has a hole or falls apart.
    """
    padded = np.pad(mask, 1)
    step: dict[tuple[int, int], tuple[int, int]] = {}
    for row, column in np.argwhere(mask).tolist():
        left, right = (column, column + 1)
        low, high = (row, row + 1)
        if not padded[row, column + 1]:
            step[left, low] = (right, low)
        if not padded[row + 1, column + 2]:
            step[right, low] = (right, high)
        if not padded[row + 2, column + 1]:
            step[right, high] = (left, high)
        if not padded[row + 1, column]:
            step[left, high] = (left, low)
    start = min(step)
    path = [start]
    while step[path[-1]] != start:
        path.append(step[path[-1]])
    if len(path) < len(step):
        raise DoesNotFit("a region with a hole")
    return tuple((xs[column], ys[row]) for column, row in _corners(path))


def _corners(path: list[tuple[int, int]]) -> Iterable[tuple[int, int]]:
    """The points of a closed path where it turns."""
    for before, here, after in zip([path[-1], *path[:-1]], path, [*path[1:], path[0]], strict=True):
        if (before[0] == here[0]) != (here[0] == after[0]):
            yield here


def sides(outline: Outline) -> list[tuple[Point, Point]]:
    """The sides of an outline, from corner to corner."""
    return list(zip(outline, [*outline[1:], outline[0]], strict=True))


def inset(outline: Outline, distance: float) -> Outline:
    """The outline moved inwards on every side by `distance` metres."""
    shrunk = []
    for before, here, after in zip(
        [outline[-1], *outline[:-1]], outline, [*outline[1:], outline[0]], strict=True
    ):
        dx, dy = np.add(_inward(before, here), _inward(here, after))
        shrunk.append((tidy(here[0] + distance * dx), tidy(here[1] + distance * dy)))
    return tuple(shrunk)


def _inward(start: Point, end: Point) -> Point:
    """The unit vector to the left of the direction from `start` to `end`."""
    return float(np.sign(start[1] - end[1])), float(np.sign(end[0] - start[0]))


def common_walls(a: Outline, b: Outline, thickness: float) -> list[tuple[Rect, bool]]:
    """Where two rooms lie back to back: the wall between, and whether it runs along x."""
    return [
        (wall, along_x)
        for along_x in (True, False)
        for one in _faces(a, along_x)
        for two in _faces(b, along_x)
        if (wall := _between(one, two, along_x, thickness))
    ]


def _faces(outline: Outline, along_x: bool) -> list[tuple[float, float, float]]:
    """The sides along x or y: where they stand, and their first and last coordinate, in order."""
    along, across = (0, 1) if along_x else (1, 0)
    return [
        (start[across], start[along], end[along])
        for start, end in sides(outline)
        if start[across] == end[across]
    ]


def _between(
    one: tuple[float, float, float],
    two: tuple[float, float, float],
    along_x: bool,
    thickness: float,
) -> Rect | None:
    """The wall between two faces that look away from each other, or nothing."""
    facing_up = (one[2] > one[1]) == along_x  # the room is on the upper side of its face
    gap = one[0] - two[0] if facing_up else two[0] - one[0]
    if (one[2] > one[1]) == (two[2] > two[1]) or abs(gap - thickness) > 1e-6:
        return None
    low = max(min(one[1:]), min(two[1:]))
    high = min(max(one[1:]), max(two[1:]))
    if low >= high:
        return None
    near, far = sorted((one[0], two[0]))
    return (low, near, high, far) if along_x else (near, low, far, high)
