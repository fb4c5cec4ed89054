"""How well two scans fit, for notebook 10: a hill on which a coarse grid finds the way up.

The library's `agreement` counts points within a tolerance: it judges a pose that is nearly right,
and says nothing from farther away.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.se2 import inverse
from tutorial_lib.validation import fit_together, floats
from tutorial_lib.world.sensors import full_circle

_FAR = 8.0  # metres beyond which beams are too far apart to show a wall
_MOST = 1e6  # metres; beyond, arithmetic fails
_WALL = 0.8  # metres between two neighbouring points at most that are on one wall
_WIDTH = 0.1  # metres off the wall at which a point counts half
_HIDDEN = 0.4  # metres behind a wall from which a point is out of sight
_LEAST = 1 / 3  # of the points that must be comparable
_SKIP = 3  # every so many points are asked


def fit(node: NDArray, seen: NDArray, poses: NDArray) -> Array:
    """How well two scans (B,) fit, (P,) from 0 to 1, if one was taken at poses (P, 3) in the other.

    Either scan's points must lie on the walls of the other, or out of its sight. Beams go from left
    to right, as the columns of a panorama do.

    Raises:
        InputError: when an array has another shape.
    """
    fit_together(node=(node, ("B",)), seen=(seen, ("B",)), poses=(poses, ("P", 3)))
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
    walls, points = np.empty((beams, 3)), np.empty((beams, 2))
    known = _points(second, angles, points)
    is_wall = _walls(first, angles, walls)
    for p in range(len(poses)):
        cos, sin = np.cos(poses[p, 2]), np.sin(poses[p, 2])
        total, compared = 0.0, 0
        for i in range(known):
            x = cos * points[i, 0] - sin * points[i, 1] + poses[p, 0]
            y = sin * points[i, 0] + cos * points[i, 1] + poses[p, 1]
            left = int((np.arctan2(y, x) - angles[0]) * (beams / (2 * np.pi)) + beams) - beams
            left += beams * (left < 0)
            if is_wall[left]:
                off = walls[left, 0] * x + walls[left, 1] * y - walls[left, 2]
            else:  # between the two beams a wall may be anywhere between their distances
                one, other = first[left], first[left + 1 if left + 1 < beams else 0]
                far = np.sqrt(x * x + y * y)
                off = (
                    far - max(one, other)
                    if far > max(one, other)
                    else min(0, far - min(one, other))
                )
            if off > _HIDDEN:
                continue
            compared += 1
            total += 1.0 / (1.0 + (off / _WIDTH) ** 2)
        if compared >= _LEAST * max(known, 1) and known > 0:
            shares[p] = total / compared
    return shares


@njit(cache=True, nogil=True, error_model="numpy")
def _points(laser: Array, angles: Array, points: Array) -> int:
    """Write some of the points of a scan, and return how many."""
    count = 0
    for beam in range(0, len(laser), _SKIP):
        if laser[beam] < _FAR:
            points[count, 0] = laser[beam] * np.cos(angles[beam])
            points[count, 1] = laser[beam] * np.sin(angles[beam])
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _walls(laser: Array, angles: Array, walls: Array) -> NDArray[np.bool_]:
    """Write the lines between neighbouring points, outward normals first; which are walls."""
    beams, there = len(laser), np.zeros(len(laser), np.bool_)
    for beam in range(beams):
        other = (beam + 1) % beams
        if max(laser[beam], laser[other]) >= _MOST:
            continue
        x, y = laser[beam] * np.cos(angles[beam]), laser[beam] * np.sin(angles[beam])
        dx = laser[other] * np.cos(angles[other]) - x
        dy = laser[other] * np.sin(angles[other]) - y
        length = np.sqrt(dx * dx + dy * dy)
        if 0.0 < length < _WALL:
            walls[beam, 0], walls[beam, 1] = dy / length, -dx / length
            walls[beam, 2] = walls[beam, 0] * x + walls[beam, 1] * y
            there[beam] = True
    return there
