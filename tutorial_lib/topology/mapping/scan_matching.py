"""Where one laser scan was taken, as seen from another: whichever way the robot looked.

Pictures that look opposite ways show nothing in common; scans of the full circle show the same
walls. One is rotated until the distances correlate, then moved and turned until its points lie on
the walls of the other (iterative closest point, to lines), and judged by whether each scan shows
what the other says must be seen.
"""

import numpy as np
from numba import njit

from tutorial_lib.se2 import Array, inverse, wrap
from tutorial_lib.validation import fit_together
from tutorial_lib.world.sensors import full_circle

_NEAR = 4.0  # metres; what is farther looks different from where the other scan was taken
_FAR = 8.0  # metres beyond which beams are too far apart to show a wall
_WALL = 0.8  # metres between two neighbouring points at most that are on one wall
_TOLERANCE = 0.12  # metres between a point and the wall that it is on
_WIDEST, _SHRINK, _NARROWEST = 0.8, 0.65, 0.15  # metres of association, step by step
_STEPS = 8
_SKIP = 2  # every so many points are moved onto walls; all of them are judged
_STIFF = 0.5  # keeps a scan of one long wall where it is along that wall
_LEAST = 1 / 3  # of the points that must be comparable


def likely_rotations(
    lasers: Array, others: Array, least: float, count: int = 2
) -> tuple[Array, Array]:
    """How well scans correlate when turned, and by how much they are turned then.

    Args:
        lasers: (N, B) metres, full circles.
        others: (M, B).
        least: rad; headings that differ less are not looked at.
        count: R, of the best rotations.

    Returns:
        (N, M) the best correlation, -1 to 1; and (N, M, R) rad, headings of the other.
    """
    beams = lasers.shape[1]
    angles = wrap(np.arange(beams) * (2 * np.pi / beams))
    ours, theirs = (np.fft.rfft(_normalised(scans)) for scans in (lasers, others))
    best = np.empty((len(lasers), len(others)))
    rotations = np.empty((len(lasers), len(others), count))
    for row, one in enumerate(ours):
        found = np.fft.irfft(one * np.conj(theirs), n=beams)
        peak = (found >= np.roll(found, 1, axis=1)) & (found >= np.roll(found, -1, axis=1))
        found = np.where(peak & (np.abs(angles) >= least), found, -1.0)
        order = np.argpartition(-found, range(count), axis=1)[:, :count]
        rotations[row] = angles[order]
        best[row] = np.take_along_axis(found, order[:, :1], axis=1)[:, 0]
    return best, rotations


def match_scans(first: Array, second: Array, starts: Array) -> tuple[Array, Array]:
    """Poses (P, 3) of second scans in the frames of the first, and how well each pair agrees.

    Args:
        first: (P, B) metres.
        second: (P, B).
        starts: (P, R, 3) poses to begin with; the best result of each pair is returned.

    Returns:
        Poses (P, 3), and agreements (P,) from 0 to 1, -1 where no two can be compared; see
        `agreement`.

    Raises:
        InputError: when an array has another shape.
    """
    scans = {name: (scan, ("P", "B")) for name, scan in (("first", first), ("second", second))}
    fit_together(**scans, starts=(starts, ("P", "R", 3)))
    angles = full_circle(first.shape[1])
    best, scores = starts[:, 0].copy(), np.full(len(first), -1.0)
    for start in range(starts.shape[1]):
        poses = _aligned(first, second, angles, np.ascontiguousarray(starts[:, start]))
        found = agreement(first, second, poses)
        better = found > scores
        best[better], scores[better] = poses[better], found[better]
    return best, scores


def agreement(first: Array, second: Array, poses: Array) -> Array:
    """The share (P,) of points that either scan confirms; the lower of both.

    A point behind a wall of the other scan is no contradiction, one in front of it is. Where fewer
    than a third of the points can be compared the share is not a number.

    Args:
        first: (P, B) metres.
        second: (P, B).
        poses: (P, 3) of the second in the frames of the first.

    Raises:
        InputError: when an array has another shape.
    """
    scans = {name: (scan, ("P", "B")) for name, scan in (("first", first), ("second", second))}
    fit_together(**scans, poses=(poses, ("P", 3)))
    angles = full_circle(first.shape[1])
    there = _confirmed(first, second, angles, np.ascontiguousarray(poses))
    back = _confirmed(second, first, angles, np.ascontiguousarray(inverse(poses)))
    return np.minimum(there, back)


def _normalised(lasers: Array) -> Array:
    """Scans (N, B) of mean zero and length one."""
    rows = np.minimum(lasers, _NEAR)
    rows = rows - rows.mean(axis=1, keepdims=True)
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-6)


@njit(cache=True, nogil=True, error_model="numpy")
def _aligned(first: Array, second: Array, angles: Array, starts: Array) -> Array:
    """Poses (P, 3) of the second scans after iterative closest point."""
    poses, beams = starts.copy(), len(angles)
    walls, points = np.empty((beams, 4)), np.empty((beams, 2))
    for pair in range(len(first)):
        count = _walls(first[pair], angles, walls)
        known = _points(second[pair], angles, points)
        reach = _WIDEST
        for _ in range(_STEPS):
            moved = _closer(
                points[:known:_SKIP], walls[:count], poses[pair], max(reach, _NARROWEST)
            )
            reach *= _SHRINK
            if not moved:
                break
    return poses


@njit(cache=True, nogil=True, error_model="numpy")
def _points(laser: Array, angles: Array, points: Array) -> int:
    """Write the points of a scan, and return how many there are."""
    count = 0
    for beam in range(len(laser)):
        if laser[beam] < _FAR:
            points[count, 0] = laser[beam] * np.cos(angles[beam])
            points[count, 1] = laser[beam] * np.sin(angles[beam])
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _walls(laser: Array, angles: Array, walls: Array) -> int:
    """Write the walls between neighbouring points: an end and the way to the other."""
    count, beams = 0, len(laser)
    for beam in range(beams):
        other = (beam + 1) % beams
        if max(laser[beam], laser[other]) >= _FAR:
            continue
        x, y = laser[beam] * np.cos(angles[beam]), laser[beam] * np.sin(angles[beam])
        dx = laser[other] * np.cos(angles[other]) - x
        dy = laser[other] * np.sin(angles[other]) - y
        if 0.0 < dx * dx + dy * dy < _WALL * _WALL:
            walls[count, 0], walls[count, 1], walls[count, 2], walls[count, 3] = x, y, dx, dy
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _closer(points: Array, walls: Array, pose: Array, reach: float) -> bool:
    """One Gauss-Newton step on the distances of points from their nearest walls."""
    hessian, gradient, used = _STIFF * np.eye(3), np.zeros(3), 0
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    row = np.empty(3)
    for i in range(len(points)):
        ox, oy = cos * points[i, 0] - sin * points[i, 1], sin * points[i, 0] + cos * points[i, 1]
        x, y, nearest, off = ox + pose[0], oy + pose[1], reach * reach, 0.0
        for k in range(len(walls)):
            dx, dy = walls[k, 2], walls[k, 3]
            ax, ay = x - walls[k, 0], y - walls[k, 1]
            square = dx * dx + dy * dy
            along = min(1.0, max(0.0, (ax * dx + ay * dy) / square))
            far = (ax - along * dx) ** 2 + (ay - along * dy) ** 2
            if far < nearest:
                length = np.sqrt(square)
                nearest, off = far, (ay * dx - ax * dy) / length
                row[0], row[1] = -dy / length, dx / length
        if nearest < reach * reach:
            row[2] = row[1] * ox - row[0] * oy
            used += 1
            for a in range(3):
                gradient[a] += row[a] * off
                for b in range(3):
                    hessian[a, b] += row[a] * row[b]
    if used < 10:
        return False
    pose -= np.linalg.solve(hessian, gradient)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _confirmed(first: Array, second: Array, angles: Array, poses: Array) -> Array:
    """The share (P,) of the second scans' points that the first ones confirm."""
    shares, beams = np.empty(len(first)), len(angles)
    points = np.empty((beams, 2))
    for pair in range(len(first)):
        known = _points(second[pair], angles, points)
        cos, sin = np.cos(poses[pair, 2]), np.sin(poses[pair, 2])
        good, bad = 0, 0
        for i in range(known):
            x = cos * points[i, 0] - sin * points[i, 1] + poses[pair, 0]
            y = sin * points[i, 0] + cos * points[i, 1] + poses[pair, 1]
            far = np.sqrt(x * x + y * y)
            place = (np.arctan2(y, x) - angles[0]) * beams / (2 * np.pi)
            left = int(np.floor(place))
            # Between two beams a wall may be anywhere between their distances.
            one, other = first[pair, left % beams], first[pair, (left + 1) % beams]
            if far > max(one, other) + _TOLERANCE:
                continue
            if far >= min(one, other) - _TOLERANCE:
                good += 1
            else:
                bad += 1
        compared = good + bad >= _LEAST * max(known, 1) and known > 0
        shares[pair] = good / (good + bad) if compared else np.nan
    return shares
