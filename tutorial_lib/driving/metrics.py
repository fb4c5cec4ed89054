"""Metrics of driving: one definition each."""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.validation import alike, floats, instance, whole
from tutorial_lib.world.raycast import Raycaster

REACHED = 0.30
"""Metres from the target that count as reached."""
SLOWEST = 0.3
"""m/s on average, below which a rollout is given up (v_min of Meng 2020, III-C)."""
GRACE = 5.0
"""Seconds allowed on top."""
STRAYED = 1.0
"""Metres from the path beyond which a robot no longer follows it."""
AHEAD = 3.0
"""Metres of a path that may be cut short, where it turns to and fro within those of `STRAYED`."""
_LONGEST = 1e6  # metres
_DENSE = 0.02  # metres between the points at which a path is compared with a track


def time_limit(geodesic: ArrayLike) -> Array:
    """Time limit in seconds of a rollout of so many metres.

    >>> time_limit([0.0, 3.0]).tolist()
    [5.0, 15.0]
    """
    return floats("geodesic", geodesic, least=0, infinite=True) / SLOWEST + GRACE


def spl(success: ArrayLike, shortest: ArrayLike, travelled: ArrayLike) -> Array:
    """Success weighted by path length (Anderson et al. 2018): of each episode, to be averaged.

    Args:
        success: (N,) of each episode.
        shortest: (N,) geodesic metres from start to goal.
        travelled: (N,) metres.

    Raises:
        InputError: when a length is negative or not finite, or a success is not from 0 to 1.

    >>> spl([1, 1, 0], [2.0, 2.0, 2.0], [4.0, 1.5, 2.0]).tolist()
    [0.5, 1.0, 0.0]
    """
    success = floats("success", success, ("N",), least=0, most=1)
    shortest = floats("shortest", shortest, ("N",), least=0)
    travelled = floats("travelled", travelled, ("N",), least=0)
    alike(success=success, shortest=shortest, travelled=travelled)
    longest = np.maximum(np.maximum(shortest, travelled), 1e-9)
    return success * np.maximum(shortest, 1e-9) / longest


def walls_crossed(caster: Raycaster, poses: Array) -> int:
    """How often a track among `poses` (T, N, 3) passes through a wall."""
    instance("caster", caster, Raycaster)
    poses = floats("poses", poses, ("T", "N", 3))
    before, after = poses[:-1, :, :2].reshape(-1, 2), poses[1:, :, :2].reshape(-1, 2)
    return int((~caster.sees(before, after)).sum())


def covered(path: ArrayLike, track: ArrayLike, collided_at: int | None = None) -> float:
    """Metres of a path that a robot followed before it strayed from it or touched something.

    Summed over trajectories and divided by the sum of their lengths, this is the cover rate (Meng
    2020, IV-B). A path may cross itself, so a robot is compared with the part of it from `STRAYED`
    behind to `AHEAD` ahead of where it got to; skipping more does not count. The end counts
    as covered from `REACHED` on.

    Args:
        path: (P, 2 or more) points to be followed, in metres; a pose is one.
        track: (T, 2 or more) where the robot was, step by step.
        collided_at: index of the step of a collision; nothing counts after it.

    Raises:
        InputError: when there is no path, or something is not finite.

    >>> covered([[0, 0], [4, 0]], [[0, 0], [0.5, 0.9], [1, 0.9], [1.5, 0.9], [2, 1.1], [3, 0]])
    1.5
    """
    path, track = _points("path", path), _points("track", track)
    if collided_at is not None:
        collided_at = whole("collided_at", collided_at, least=0)
        track = track[: collided_at + 1]
    places, miles = _densely(path)
    behind, ahead, now = round(STRAYED / _DENSE), round(AHEAD / _DENSE), 0
    for point in track:
        first = max(now - behind, 0)
        gap = np.linalg.norm(places[first : now + ahead + 1] - point, axis=1)
        if gap.min() > STRAYED:
            break
        now = max(now, first + int(gap.argmin()))
        if miles[-1] - miles[now] <= REACHED and np.linalg.norm(places[-1] - point) <= REACHED:
            return float(miles[-1])
    return float(miles[now])


def _points(name: str, points: ArrayLike) -> Array:
    """(P, 2) finite points."""
    points = floats(name, points, ("P", "2 or more"), empty=False)
    if points.shape[1] < 2:
        raise InputError(f"{name}: shape {points.shape}; give finite points (P, 2), one at least")
    return points[:, :2]


def _densely(path: Array) -> tuple[Array, Array]:
    """Points (Q, 2) about every `_DENSE` metres of a path, and the metres (Q,) up to each."""
    miles = arc_length(path)
    if miles[-1] > _LONGEST:
        raise InputError(f"path: {miles[-1]:g} m; give metres, {_LONGEST:g} at most")
    at = np.linspace(0.0, miles[-1], int(np.ceil(miles[-1] / _DENSE)) + 1)
    return np.stack([np.interp(at, miles, column) for column in path.T], axis=1), at
