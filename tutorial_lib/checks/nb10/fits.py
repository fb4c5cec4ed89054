"""How well two scans fit, for notebook 10: a hill on which a coarse grid finds the way up.

The library's `agreement` counts points within a tolerance: it judges a pose that is nearly right,
and says nothing from farther away.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.se2 import inverse
from tutorial_lib.validation import floats
from tutorial_lib.world.sensors import full_circle

_FAR = 8.0  # metres beyond which beams are too far apart to show a wall
_WALL = 0.8  # metres between two neighbouring points at most that are on one wall
_WIDTH = 0.1  # metres off the wall at which a point counts half
_HIDDEN = 0.4  # metres behind a wall from which a point is out of sight
_LEAST = 1 / 3  # of the points that must be comparable
_SKIP = 2  # every so many points are asked


def fit(node: NDArray, seen: NDArray, poses: NDArray) -> Array:
    """How well two scans (B,) fit, (P,) from 0 to 1, if one was taken at poses (P, 3) in the other.

    Either scan's points must lie on the walls of the other, or out of its sight. Beams go from left
    to right, as the columns of a panorama do.

    Raises:
        InputError: when an array has another shape.
    """
    first, second = (
        np.ascontiguousarray(floats(name, scan, ("B",), least=0.0, infinite=True)[::-1])
        for name, scan in (("node", node), ("seen", seen))
    )
    poses = np.ascontiguousarray(floats("poses", poses, ("P", 3)))
    angles = full_circle(len(first))
    there = _share(first, second, angles, poses)
    return np.minimum(there, _share(second, first, angles, np.ascontiguousarray(inverse(poses))))


@njit(cache=True, nogil=True, error_model="numpy")
def _share(first: Array, second: Array, angles: Array, poses: Array) -> Array:
    """How well (P,) the second scan's points lie on the walls of the first."""
    beams, shares = len(angles), np.zeros(len(poses))
    wall_x, wall_y = first * np.cos(angles), first * np.sin(angles)
    x0, y0 = second * np.cos(angles), second * np.sin(angles)
    for p in range(len(poses)):
        cos, sin = np.cos(poses[p, 2]), np.sin(poses[p, 2])
        total, compared, known = 0.0, 0, 0
        for i in range(0, beams, _SKIP):
            if second[i] >= _FAR:
                continue
            known += 1
            x = cos * x0[i] - sin * y0[i] + poses[p, 0]
            y = sin * x0[i] + cos * y0[i] + poses[p, 1]
            place = (np.arctan2(y, x) - angles[0]) * beams / (2 * np.pi)
            left = int(np.floor(place)) % beams
            right = (left + 1) % beams
            dx, dy = wall_x[right] - wall_x[left], wall_y[right] - wall_y[left]
            length = np.sqrt(dx * dx + dy * dy)
            if length < _WALL:
                # Beams rise counter-clockwise: the wall's inner side is on its left.
                off = (dy * (x - wall_x[left]) - dx * (y - wall_y[left])) / max(length, 1e-9)
            else:  # between the two beams a wall may be anywhere between their distances
                far = np.sqrt(x * x + y * y)
                low, high = min(first[left], first[right]), max(first[left], first[right])
                off = far - high if far > high else min(far - low, 0.0)
            if off > _HIDDEN:
                continue
            compared += 1
            total += 1.0 / (1.0 + (off / _WIDTH) ** 2)
        if compared >= _LEAST * max(known, 1) and known > 0:
            shares[p] = total / compared
    return shares
