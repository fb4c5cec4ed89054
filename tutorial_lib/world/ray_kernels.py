"""The numba kernels behind `raycast`: every ray against every wall, and moving discs.

Shared names: `segments` (4, S) float64 rows x0, y0, x1, y1; `poses` (N, 3); `rays` (2, R) unit
directions in the robot's frame, counter-clockwise; `distance`, `wall`, `along` (N, R) are written.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int32]

F = np.float32
_ZERO = np.float32(0)
_ONE = np.float32(1)


@njit(cache=True, nogil=True, error_model="numpy")
def cast_all(
    segments: Floats,
    poses: Floats,
    rays: Floats,
    bundle: int,
    distance: Floats,
    wall: Ints,
    along: Floats,
) -> None:
    """Compare every ray with every wall that reaches into its bundle's wedge.

    `bundle` neighbouring rays must span less than pi, or be all of them (then no wall is left out).
    The nearest wall is found in float32, many rays at a time; its distance is then computed
    in float64.
    """
    count, many = segments.shape[1], rays.shape[1]
    ends, scratch = np.empty((4, count), F), scratch_for(count, bundle)
    dx, dy, index = np.empty(many, F), np.empty(many, F), np.empty(many, np.int32)
    for pose in range(len(poses)):
        x, y = poses[pose, 0], poses[pose, 1]
        cos, sin = math.cos(poses[pose, 2]), math.sin(poses[pose, 2])
        for s in range(count):
            ends[0, s] = F(segments[0, s] - x)
            ends[1, s] = F(segments[1, s] - y)
            ends[2, s] = F(segments[2, s] - x)
            ends[3, s] = F(segments[3, s] - y)
        turn(rays, cos, sin, dx, dy)
        nearest(ends, count, dx, dy, bundle, scratch, index)
        for ray in range(many):
            ex, ey = direction(rays, ray, cos, sin)
            t, u = meet(segments, index[ray], x, y, ex, ey)
            distance[pose, ray], wall[pose, ray], along[pose, ray] = t, index[ray], u


@njit(cache=True, nogil=True, error_model="numpy")
def scratch_for(count: int, bundle: int) -> tuple[Ints, Ints, Singles, Singles, Singles, Ints]:
    """Working memory for `nearest`, allocated once for many poses."""
    inside, seen = np.empty(count, np.int32), np.empty(count, np.int32)
    ex, ey, best = np.empty(bundle, F), np.empty(bundle, F), np.empty(bundle, F)
    return inside, seen, ex, ey, best, np.empty(bundle, np.int32)


@njit(cache=True, nogil=True, error_model="numpy")
def nearest(
    ends: Singles,
    count: int,
    dx: Singles,
    dy: Singles,
    bundle: int,
    scratch: tuple[Ints, Ints, Singles, Singles, Singles, Ints],
    index: Ints,
) -> None:
    """For each ray from the origin the nearest of the first `count` walls, or -1.

    The inner loop has no branch, so that it runs on many rays at once; 1 / distance is
    cross(ray, b - a) / cross(a, b) for a wall from a to b, which is linear in the ray.
    """
    inside, seen, ex, ey, best, winner = scratch
    for first in range(0, len(dx), bundle):
        size = min(bundle, len(dx) - first)
        for r in range(size):
            ex[r], ey[r], best[r], winner[r] = dx[first + r], dy[first + r], _ZERO, -1
        # A wall is out when both its ends lie right of the first ray or left of the last.
        rx, ry, lx, ly = ex[0], ey[0], ex[size - 1], ey[size - 1]
        narrow = rx * ly - ry * lx > _ZERO
        for s in range(count):
            right_a = rx * ends[1, s] - ry * ends[0, s] < _ZERO
            right_b = rx * ends[3, s] - ry * ends[2, s] < _ZERO
            left_a = lx * ends[1, s] - ly * ends[0, s] > _ZERO
            left_b = lx * ends[3, s] - ly * ends[2, s] > _ZERO
            inside[s] = 1 - (narrow & ((right_a & right_b) | (left_a & left_b)))
        found = 0
        for s in range(count):
            seen[found] = s
            found += inside[s]
        for i in range(found):
            s = seen[i]
            ax, ay, bx, by = ends[0, s], ends[1, s], ends[2, s], ends[3, s]
            scale = _ONE / (ax * by - ay * bx)
            nx, ny = (by - ay) * scale, (bx - ax) * scale
            for r in range(size):
                nearness = ex[r] * nx - ey[r] * ny
                side_a = ex[r] * ay - ey[r] * ax
                side_b = ex[r] * by - ey[r] * bx
                hit = (side_a * side_b <= _ZERO) & (nearness > best[r])
                best[r] = nearness if hit else best[r]
                winner[r] = s if hit else winner[r]
        for r in range(size):
            index[first + r] = winner[r]


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def meet(segments: Floats, s: int, x: float, y: float, ex: float, ey: float) -> tuple[float, float]:
    """Where the ray e from (x, y) meets wall s: metres along the ray and along the wall."""
    if s < 0:
        return np.inf, 0.0
    ax, ay = segments[0, s] - x, segments[1, s] - y
    wx, wy = segments[2, s] - segments[0, s], segments[3, s] - segments[1, s]
    t = (ax * wy - ay * wx) / (ex * wy - ey * wx)
    length = math.sqrt(wx * wx + wy * wy)
    return t, min(max(((t * ex - ax) * wx + (t * ey - ay) * wy) / length, 0.0), length)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def direction(rays: Floats, ray: int, cos: float, sin: float) -> tuple[float, float]:
    """A ray's direction in the world."""
    return cos * rays[0, ray] - sin * rays[1, ray], sin * rays[0, ray] + cos * rays[1, ray]


@njit(cache=True, nogil=True, error_model="numpy")
def turn(rays: Floats, cos: float, sin: float, dx: Singles, dy: Singles) -> None:
    """All rays' directions in the world, in float32."""
    for ray in range(rays.shape[1]):
        ex, ey = direction(rays, ray, cos, sin)
        dx[ray], dy[ray] = F(ex), F(ey)


@njit(cache=True, nogil=True, error_model="numpy")
def cast_discs(
    discs: Floats,
    owners: Ints,
    first: int,
    viewers: Ints,
    poses: Floats,
    rays: Floats,
    distance: Floats,
    wall: Ints,
    along: Floats,
) -> None:
    """Replace hits by discs that are nearer; disc k gets the wall index `first` + k.

    A disc (x, y, radius) with owner -1 exists for every viewer, one with owner -2 - i for every
    viewer but i, and any other only for the viewer with that index. `along` runs counter-clockwise
    around the disc, from its +x side.
    """
    for pose in range(len(poses)):
        x, y = poses[pose, 0], poses[pose, 1]
        cos, sin = math.cos(poses[pose, 2]), math.sin(poses[pose, 2])
        for k in range(len(discs)):
            owner, viewer = owners[k], viewers[pose]
            if (owner >= 0 and owner != viewer) or owner == -2 - viewer:
                continue
            dx, dy, radius = discs[k, 0] - x, discs[k, 1] - y, discs[k, 2]
            # Into the robot's frame, where the rays are.
            cx, cy = cos * dx + sin * dy, cos * dy - sin * dx
            for ray in range(rays.shape[1]):
                forward = cx * rays[0, ray] + cy * rays[1, ray]
                aside = cx * rays[1, ray] - cy * rays[0, ray]
                half2 = radius * radius - aside * aside
                if forward > 0.0 and half2 > 0.0:
                    t = forward - math.sqrt(half2)
                    if 0.0 <= t < distance[pose, ray]:
                        hx, hy = t * rays[0, ray] - cx, t * rays[1, ray] - cy
                        turn = math.atan2(hy, hx) + poses[pose, 2]
                        distance[pose, ray] = t
                        wall[pose, ray] = first + k
                        along[pose, ray] = radius * (turn % (2.0 * math.pi))
