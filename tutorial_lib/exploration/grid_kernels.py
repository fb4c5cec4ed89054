"""The numba kernels behind local maps: rays into cells, and shortest paths over cells.

A map has three kinds of cell; cell (row, column) of a grid holds the point with y and x in
``corner + resolution * [row, row + 1)`` and likewise for columns.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
STRAIGHT, DIAGONAL, KNIGHT = 29, 41, 65
"""Lengths of a king's and a knight's steps, in 1/29 of a cell: 1, 1.414 and 2.241 cells."""
DEAREST = 8
"""The most that a cell may cost, times its length."""

BEHIND = 0.02
"""Metres beyond the end of a ray at which its wall is entered.

A wall often lies on the border of two cells. Without this, rounding would decide which of the two
is occupied; with it, it is the one that does not face the robot."""

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]

_CLOSE, _LONGEST = 3.5, 15.0  # cells between two ends of rays on one wall
_BUCKETS = KNIGHT * DEAREST + 1
_STEPS = np.array(
    [(0, 1, STRAIGHT), (1, 0, STRAIGHT), (0, -1, STRAIGHT), (-1, 0, STRAIGHT)]
    + [(i, j, DIAGONAL) for i in (-1, 1) for j in (-1, 1)]
    + [(i, j, KNIGHT) for i in (-1, 1) for j in (-2, 2)]
    + [(i, j, KNIGHT) for i in (-2, 2) for j in (-1, 1)],
    np.int32,
)


@njit(cache=True, nogil=True, error_model="numpy")
def draw_rays(
    grids: Bytes,
    corners: Floats,
    resolution: float,
    robots: NDArray[np.intp],
    poses: Floats,
    panoramas: Floats,
    bearings: Floats,
    reach: float,
) -> None:
    """Enter each robot's panorama: free up to `reach` metres or a wall, and that is occupied.

    Between neighbouring rays one more is drawn, as long as the shorter of them.
    """
    side, count = grids.shape[1], panoramas.shape[1]
    step = resolution * 0.7
    for m in range(len(robots)):
        grid, corner = grids[robots[m]], corners[robots[m]]
        pose, ranges = poses[m], panoramas[m]
        for k in range(2 * count):
            ray = k // 2
            after = (ray + 1) % count
            length, bearing = ranges[ray], bearings[ray]
            if k % 2:
                length = min(length, ranges[after])
                bearing += np.pi / count * (-1.0 if bearings[1] < bearings[0] else 1.0)
            cos, sin = np.cos(pose[2] + bearing), np.sin(pose[2] + bearing)
            far = min(length - resolution / 2, reach)
            for i in range(int(far / step) + 1):
                row = int(np.floor((pose[1] + i * step * sin - corner[1]) / resolution))
                column = int(np.floor((pose[0] + i * step * cos - corner[0]) / resolution))
                if 0 <= row < side and 0 <= column < side:
                    grid[row, column] = FREE
        x, y = np.empty(count), np.empty(count)
        for ray in range(count):
            cos, sin = np.cos(pose[2] + bearings[ray]), np.sin(pose[2] + bearings[ray])
            x[ray] = (pose[0] + (ranges[ray] + BEHIND) * cos - corner[0]) / resolution
            y[ray] = (pose[1] + (ranges[ray] + BEHIND) * sin - corner[1]) / resolution
        for ray in range(count):
            if ranges[ray] <= reach:
                _draw_wall(grid, x, y, ray, ranges[(ray + 1) % count] <= reach)


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_wall(grid: Bytes, x: Floats, y: Floats, ray: int, both: bool) -> None:
    """Mark where a ray ends, and the wall from there to the end of the next one, if it is one.

    It is one where the ends are close, or where the next ones on either side lie on their line.
    """
    side, count = len(grid), len(x)
    after, before, beyond = (ray + 1) % count, (ray - 1) % count, (ray + 2) % count
    dx, dy = x[after] - x[ray], y[after] - y[ray]
    gap = np.sqrt(dx * dx + dy * dy)
    wall = both and gap < _CLOSE
    if both and _CLOSE <= gap < _LONGEST:
        first = abs((x[before] - x[ray]) * dy - (y[before] - y[ray]) * dx) / gap
        last = abs((x[beyond] - x[ray]) * dy - (y[beyond] - y[ray]) * dx) / gap
        wall = first < 0.5 and last < 0.5
    steps = int(gap / 0.7) + 1 if wall else 1
    for k in range(steps):
        row, column = int(np.floor(y[ray] + dy * k / steps)), int(np.floor(x[ray] + dx * k / steps))
        if 0 <= row < side and 0 <= column < side:
            grid[row, column] = OCCUPIED


@njit(cache=True, nogil=True, error_model="numpy")
def costs_of(
    grid: Bytes, body: float, comfort: float, near: int, unknown: int, start: int, cost: Bytes
) -> None:
    """What it costs to enter each cell, in times its length; 0 where the robot does not fit.

    `body` and `comfort` are in cells, from the middle of an occupied cell: nearer than `body` is
    blocked, nearer than `comfort` costs `near`. A robot that stands too near a wall may leave: the
    cells about `start` are passable at the highest cost.
    """
    side = len(grid)
    around = int(comfort)
    for row in range(side):
        for column in range(side):
            kind = grid[row, column]
            cost[row, column] = unknown if kind == UNKNOWN else 1
    for row in range(side):
        for column in range(side):
            if grid[row, column] != OCCUPIED:
                continue
            for i in range(max(row - around, 0), min(row + around + 1, side)):
                for j in range(max(column - around, 0), min(column + around + 1, side)):
                    far = np.sqrt((i - row) ** 2 + (j - column) ** 2)
                    if far <= body:
                        cost[i, j] = 0
                    elif far <= comfort and cost[i, j] and cost[i, j] < near:
                        cost[i, j] = near
    row, column = start // side, start % side
    if cost[row, column] == 0:
        for i in range(max(row - 3, 0), min(row + 4, side)):
            for j in range(max(column - 3, 0), min(column + 4, side)):
                if cost[i, j] == 0 and grid[i, j] != OCCUPIED:
                    cost[i, j] = DEAREST
        cost[row, column] = DEAREST


@njit(cache=True, nogil=True, error_model="numpy")
def spread(cost: Bytes, start: int, ends: Bytes, length: Ints, parent: Ints) -> int:
    """Shortest paths from a cell until the first of the `ends` is reached (Dial's Dijkstra).

    `cost` (S, S) is 0 where nothing passes, else at most `DEAREST`; `ends` (S, S) is 1 at cells to
    stop at. Written: `length` (S * S,) in 1/29 of a cell, -1 where not reached, and `parent`.
    Returns the end that was reached, or -1.
    """
    side = len(cost)
    cells = side * side
    flat, stop = cost.reshape(cells), ends.reshape(cells)
    length[:] = -1
    parent[:] = -1
    head = np.full(_BUCKETS, -1, np.int32)
    later, which = np.empty(16 * cells + 1, np.int32), np.empty(16 * cells + 1, np.int32)
    settled = np.zeros(cells, np.uint8)
    length[start], head[0], later[0], which[0] = 0, 0, -1, start
    used, waiting, now = 1, 1, 0
    while waiting:
        bucket = now % _BUCKETS
        while head[bucket] >= 0:
            entry = head[bucket]
            head[bucket] = later[entry]
            waiting -= 1
            cell = which[entry]
            if settled[cell] or length[cell] != now:
                continue
            settled[cell] = 1
            if stop[cell]:
                return cell
            row, column = cell // side, cell % side
            for s in range(16):
                down, right, metres = _STEPS[s, 0], _STEPS[s, 1], _STEPS[s, 2]
                i, j = row + down, column + right
                if not (0 <= i < side and 0 <= j < side):
                    continue
                other = i * side + j
                if flat[other] == 0 or settled[other] or not _open(cost, row, column, down, right):
                    continue
                total = now + metres * flat[other]
                if length[other] < 0 or total < length[other]:
                    length[other], parent[other] = total, cell
                    slot = total % _BUCKETS
                    later[used], which[used], head[slot] = head[slot], other, used
                    used += 1
                    waiting += 1
        now += 1
    return -1


@njit(cache=True, nogil=True, error_model="numpy")
def path_length(parent: Ints, end: int, side: int) -> float:
    """Cells along the path to a cell that `spread` reached, whatever they cost."""
    total, cell = 0.0, end
    while parent[cell] >= 0:
        before = parent[cell]
        down, right = cell // side - before // side, cell % side - before % side
        total += np.sqrt(down * down + right * right)
        cell = before
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _open(cost: Bytes, row: int, column: int, down: int, right: int) -> bool:
    """Whether both cells that a step passes between are free."""
    if down == 0 or right == 0:
        return True
    if abs(down) == 2:
        half = down // 2
        return cost[row + half, column] > 0 and cost[row + half, column + right] > 0
    if abs(right) == 2:
        half = right // 2
        return cost[row, column + half] > 0 and cost[row + down, column + half] > 0
    return cost[row, column + right] > 0 and cost[row + down, column] > 0


@njit(cache=True, nogil=True, error_model="numpy")
def in_sight(cost: Bytes, first: int, last: int, most: int) -> bool:
    """Whether the straight line between two cells passes only cells that cost 1 to `most`."""
    side = len(cost)
    y, x = first // side, first % side
    dy, dx = last // side - y, last % side - x
    count = 2 * max(abs(dy), abs(dx)) + 1
    for k in range(1, count + 1):
        value = cost[int(y + 0.5 + dy * k / count), int(x + 0.5 + dx * k / count)]
        if value == 0 or value > most:
            return False
    return True
