"""The outlines of a grid's free space, along the edges of its cells, with few corners.

Lengths here are in cells: x is the column, y the row, row 0 the lowest, and cell (row, column)
covers the unit square whose lower left corner is (column, row).
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_CORNERS

TOLERANCE = 0.45
"""How far, in cells, a simplified outline may pass by a corner of the exact one; below a half."""


def free_loops(free: NDArray[np.bool_]) -> list[NDArray[np.float64]]:
    """Outline the free cells by simple closed polygons within half a cell of their border.

    Args:
        free: (H, W), row 0 the lowest y; what lies outside of the grid is not free.

    Returns:
        Loops (K, 2) of corners x, y in cells, the free side on the left: counter-clockwise around
        a region of edge-connected free cells, clockwise around a hole in it. Loops do not cross;
        where two cells touch only at a corner, two loops may meet there.
    """
    return [simplified(loop, pinned) for loop, pinned in trace_loops(free)]


def signed_area(loop: NDArray[np.float64]) -> float:
    """Area inside a polygon (K, 2), in the square of its unit; negative when it runs clockwise."""
    x, y = np.asarray(loop, dtype=float).T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def trace_loops(free: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], NDArray[np.bool_]]]:
    """The exact outlines of the free cells.

    Args:
        free: (H, W), row 0 the lowest y.

    Returns:
        For each loop its corners (K, 2) as x, y and (K,) whether the outline touches itself or
        another one there. Every loop visits a corner once.

    Raises:
        InputError: when there are more than `MAX_CORNERS`.
    """
    padded = np.pad(np.asarray(free, dtype=bool), 1)
    sw, se, nw, ne = padded[:-1, :-1], padded[:-1, 1:], padded[1:, :-1], padded[1:, 1:]
    # Borders with the free cell on their left that leave a lattice point: east, north, west, south.
    leaving = np.stack([ne & ~se, nw & ~ne, sw & ~nw, se & ~sw])
    arriving = np.stack([nw & ~sw, sw & ~se, se & ~ne, ne & ~nw])
    corner = (leaving & ~arriving).any(axis=0)
    count = np.count_nonzero(corner)
    if count > MAX_CORNERS:
        raise InputError(
            f"the outline of its free space has {count:,} corners, more than the "
            f"{MAX_CORNERS:,} that are read; clean or scale down the picture"
        )
    rows, columns = np.nonzero(corner)
    touching = leaving[:, rows, columns].sum(axis=0) == 2
    points = np.stack([columns, rows], axis=1).astype(np.int64)
    cycles = _cycles(_neighbours(rows, columns), leaving[:, rows, columns], touching)
    return [(points[loop], touching[loop]) for loop in cycles]


def _neighbours(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> list[list[int]]:
    """For each heading and corner, the corner that comes next; corners are sorted by row."""
    count = len(rows)
    index = np.arange(count)
    upward = np.lexsort((rows, columns))
    place = np.empty(count, dtype=np.intp)
    place[upward] = index
    north = upward[np.minimum(place + 1, count - 1)]
    south = upward[np.maximum(place - 1, 0)]
    return [(index + 1).tolist(), north.tolist(), (index - 1).tolist(), south.tolist()]


def _cycles(
    following: list[list[int]], leaving: NDArray[np.bool_], touching: NDArray[np.bool_]
) -> list[list[int]]:
    """Follow every border around; where two meet at a point, keep to the same free cell."""
    only = leaving.argmax(axis=0).tolist()
    touches = touching.tolist()
    done = [[False] * len(only) for _ in range(4)]
    loops: list[list[int]] = []
    for corner, heading in np.argwhere(leaving.T).tolist():
        loop = []
        while not done[heading][corner]:
            done[heading][corner] = True
            loop.append(corner)
            corner = following[heading][corner]
            heading = (heading + 1) % 4 if touches[corner] else only[corner]
        if loop:
            loops += _split(loop, touches)
    return loops


def _split(loop: list[int], touches: list[bool]) -> list[list[int]]:
    """Cut a loop that meets itself into loops that do not."""
    loops: list[list[int]] = []
    pending: list[int] = []
    place: dict[int, int] = {}  # where each touching corner stands in `pending`
    for corner in loop:
        if touches[corner]:
            if corner in place:
                inner = pending[place[corner] :]
                del pending[place[corner] :]
                for other in inner:
                    place.pop(other, None)
                loops.append(inner)
            place[corner] = len(pending)
        pending.append(corner)
    return [*loops, pending]


def simplified(loop: NDArray[np.int64], pinned: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Drop corners of an exact outline that lie within `TOLERANCE` (Douglas-Peucker).

    Two parts of outlines that share no point are at least a cell apart, and a side stays within
    less than half a cell of the part that it replaces. So sides can meet only where the exact
    outlines touch, and those corners stay: no two sides cross, of one loop or of two.

    Args:
        loop: (K, 2) the corners x, y.
        pinned: (K,) corners that must stay, since the outline touches itself or another there.

    Returns:
        (L, 2) corners of a simple polygon, 3 <= L <= K.
    """
    if len(loop) == 4:
        return loop.astype(float)
    outlying = ((loop - loop.mean(axis=0)) ** 2).sum(axis=1)
    start = int(pinned.argmax() if pinned.any() else outlying.argmax())
    ring = np.roll(loop, -start, axis=0).astype(float)
    kept = np.append(np.roll(pinned, -start), True)
    kept[0] = True
    ring = np.concatenate([ring, ring[:1]])
    if kept.sum() == 2:
        kept[((ring - ring[0]) ** 2).sum(axis=1).argmax()] = True
    ends = np.flatnonzero(kept).tolist()
    todo = list(pairwise(ends))
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        distance = _to_segment(ring[first + 1 : last], ring[first], ring[last])
        worst = int(distance.argmax())
        if distance[worst] > TOLERANCE:
            middle = first + 1 + worst
            kept[middle] = True
            todo += [(first, middle), (middle, last)]
    return ring[:-1][kept[:-1]]


def _to_segment(
    points: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Distance of each point (N, 2) from the segment."""
    along, offset = end - start, points - start
    share = np.clip(offset @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    rest = offset - share[:, None] * along
    return np.sqrt((rest**2).sum(axis=1))
