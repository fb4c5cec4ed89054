"""The numba kernels behind `raycast` for many walls, which are sorted into a uniform grid.

Cell (i, j) holds the walls ``members[starts[c] : starts[c + 1]]``, c = j * columns + i; the grid
begins at `corner` and a cell is `cell` metres wide. The other names are those of `ray_kernels`.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.world.ray_kernels import (
    F,
    Floats,
    Ints,
    direction,
    meet,
    nearest,
    scratch_for,
    turn,
)

_AROUND = 3  # cells around the robot's own whose walls every ray is compared with


@njit(cache=True, nogil=True, error_model="numpy")
def cast_grid(
    segments: Floats,
    starts: Ints,
    members: Ints,
    corner: Floats,
    cell: float,
    columns: int,
    poses: Floats,
    rays: Floats,
    bundle: int,
    distance: Floats,
    wall: Ints,
    along: Floats,
) -> None:
    """As `cast_all`, with the walls sorted into a uniform grid.

    The walls of the cells around the robot are compared with every ray; only rays that meet none of
    them nearby walk on through the grid.
    """
    lines, many = (len(starts) - 1) // columns, rays.shape[1]
    total = segments.shape[1]
    # One place more than walls: a wall met again is written, but not counted.
    ends, near = np.empty((4, total + 1), F), np.empty(total + 1, np.int32)
    stamp = np.full(total, -1, np.int32)
    scratch = scratch_for(total, bundle)
    dx, dy, index = np.empty(many, F), np.empty(many, F), np.empty(many, np.int32)
    for pose in range(len(poses)):
        x, y = poses[pose, 0], poses[pose, 1]
        cos, sin = math.cos(poses[pose, 2]), math.sin(poses[pose, 2])
        gx, gy = (x - corner[0]) / cell, (y - corner[1]) / cell
        i, j = math.floor(gx), math.floor(gy)
        count = 0
        for row in range(max(j - _AROUND, 0), min(j + _AROUND + 1, lines)):
            c = row * columns
            left, right = max(i - _AROUND, 0), min(i + _AROUND + 1, columns)
            if left >= right:
                continue
            for m in range(starts[c + left], starts[c + right]):
                s = members[m]
                near[count] = s
                ends[0, count] = F(segments[0, s] - x)
                ends[1, count] = F(segments[1, s] - y)
                ends[2, count] = F(segments[2, s] - x)
                ends[3, count] = F(segments[3, s] - y)
                count += stamp[s] != pose
                stamp[s] = pose
        # Within this distance no wall is outside the cells around the robot.
        reach = cell * (_AROUND + min(gx - i, i + 1 - gx, gy - j, j + 1 - gy))
        turn(rays, cos, sin, dx, dy)
        nearest(ends, count, dx, dy, bundle, scratch, index)
        for ray in range(many):
            ex, ey = direction(rays, ray, cos, sin)
            s = near[index[ray]] if index[ray] >= 0 else -1
            t, u = meet(segments, s, x, y, ex, ey)
            if t > reach:
                s = walk(segments, starts, members, gx, gy, cell, columns, x, y, ex, ey)
                t, u = meet(segments, s, x, y, ex, ey)
            distance[pose, ray], wall[pose, ray], along[pose, ray] = t, s, u


@njit(cache=True, nogil=True, error_model="numpy")
def see(
    segments: Floats,
    starts: Ints,
    members: Ints,
    corner: Floats,
    cell: float,
    columns: int,
    origins: Floats,
    points: Floats,
    slack: float,
    clear: NDArray[np.bool_],
) -> None:
    """Whether no wall stands between each origin and its point, but for the last `slack` metres."""
    for n in range(len(points)):
        x, y = origins[n, 0], origins[n, 1]
        ex, ey = points[n, 0] - x, points[n, 1] - y
        length = math.sqrt(ex * ex + ey * ey)
        clear[n] = length <= slack
        if length > slack:
            ex, ey = ex / length, ey / length
            gx, gy = (x - corner[0]) / cell, (y - corner[1]) / cell
            s = walk(segments, starts, members, gx, gy, cell, columns, x, y, ex, ey)
            clear[n] = meet(segments, s, x, y, ex, ey)[0] >= length - slack


@njit(cache=True, nogil=True, error_model="numpy")
def walk(
    segments: Floats,
    starts: Ints,
    members: Ints,
    gx: float,
    gy: float,
    cell: float,
    columns: int,
    x: float,
    y: float,
    ex: float,
    ey: float,
) -> int:
    """Follow one ray through the grid (Amanatides and Woo 1987) to its wall, or -1.

    The ray starts at (x, y), which is (gx, gy) in cells.
    """
    lines = (len(starts) - 1) // columns
    entry = enter(gx, gy, ex, ey, columns, lines)
    if entry == np.inf:
        return -1
    best, index = np.inf, -1
    i = min(max(math.floor(gx + entry * ex), 0), columns - 1)
    j = min(max(math.floor(gy + entry * ey), 0), lines - 1)
    step_x, step_y = (1 if ex > 0 else -1), (1 if ey > 0 else -1)
    per_x = abs(1.0 / ex) if ex != 0.0 else np.inf
    per_y = abs(1.0 / ey) if ey != 0.0 else np.inf
    next_x = ((i + (ex > 0)) - gx) / ex if ex != 0.0 else np.inf
    next_y = ((j + (ey > 0)) - gy) / ey if ey != 0.0 else np.inf
    while 0 <= i < columns and 0 <= j < lines:
        c = j * columns + i
        for m in range(starts[c], starts[c + 1]):
            s = members[m]
            ax, ay = segments[0, s] - x, segments[1, s] - y
            bx, by = segments[2, s] - x, segments[3, s] - y
            if (ex * ay - ey * ax) * (ex * by - ey * bx) <= 0.0:
                t = (ax * (by - ay) - ay * (bx - ax)) / (ex * (by - ay) - ey * (bx - ax))
                if 0.0 <= t < best:
                    best, index = t, s
        # Nothing in a later cell can be nearer than the border to it.
        if best <= min(next_x, next_y) * cell:
            break
        if next_x < next_y:
            i += step_x
            next_x += per_x
        else:
            j += step_y
            next_y += per_y
    return index


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def enter(gx: float, gy: float, ex: float, ey: float, columns: int, lines: int) -> float:
    """Distance in cells at which a ray enters the grid, 0 from inside, inf when it misses it."""
    near, far = 0.0, np.inf
    if ex != 0.0:
        a, b = -gx / ex, (columns - gx) / ex
        near, far = max(near, min(a, b)), min(far, max(a, b))
    elif not 0.0 <= gx <= columns:
        return np.inf
    if ey != 0.0:
        a, b = -gy / ey, (lines - gy) / ey
        near, far = max(near, min(a, b)), min(far, max(a, b))
    elif not 0.0 <= gy <= lines:
        return np.inf
    return near if near <= far else np.inf
