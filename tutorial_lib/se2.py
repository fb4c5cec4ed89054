"""The arithmetic of `geometry`, on arrays that are right already.

What is called thousands of times a second comes here; `geometry` checks what it is given first. NaN
in gives NaN out.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def wrap(angle: ArrayLike) -> Array:
    """See `geometry.wrap`."""
    return (np.asarray(angle, dtype=float) + np.pi) % (2 * np.pi) - np.pi


def to_local(pose: ArrayLike, points: ArrayLike) -> Array:
    """See `geometry.to_local`."""
    pose, points = np.asarray(pose, dtype=float), np.asarray(points, dtype=float)
    cos, sin = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    dx, dy = points[..., 0] - pose[..., 0], points[..., 1] - pose[..., 1]
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=-1)


def to_world(pose: ArrayLike, points: ArrayLike) -> Array:
    """See `geometry.to_world`."""
    pose, points = np.asarray(pose, dtype=float), np.asarray(points, dtype=float)
    cos, sin = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = points[..., 0], points[..., 1]
    return np.stack([pose[..., 0] + cos * x - sin * y, pose[..., 1] + sin * x + cos * y], axis=-1)


def compose(first: ArrayLike, second: ArrayLike) -> Array:
    """See `geometry.compose`."""
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    position = to_world(first, second[..., :2])
    heading = wrap(first[..., 2] + second[..., 2])
    return np.concatenate([position, heading[..., None]], axis=-1)


def relative(origin: ArrayLike, pose: ArrayLike) -> Array:
    """See `geometry.relative`."""
    origin, pose = np.asarray(origin, dtype=float), np.asarray(pose, dtype=float)
    position = to_local(origin, pose[..., :2])
    heading = wrap(pose[..., 2] - origin[..., 2])
    return np.concatenate([position, heading[..., None]], axis=-1)


def inverse(pose: ArrayLike) -> Array:
    """See `geometry.inverse`."""
    pose = np.asarray(pose, dtype=float)
    return relative(pose, np.zeros_like(pose))


def arc_length(points: ArrayLike) -> Array:
    """See `geometry.arc_length`."""
    points = np.asarray(points, dtype=float)[:, :2]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
