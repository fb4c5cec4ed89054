"""Poses in the plane, SE(2).

A pose is ``[x, y, theta]`` in metres and radians: x right, y up, heading 0 along +x and
counter-clockwise positive. Every function takes arrays of any matching leading shape, and raises an
`InputError` that names the argument which is not finite or has another shape.
"""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib import se2
from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array
from tutorial_lib.validation import floats, match

__all__ = [
    "Array",
    "arc_length",
    "compose",
    "distance_to_segments",
    "inverse",
    "relative",
    "to_local",
    "to_world",
    "wrap",
]


def wrap(angle: ArrayLike) -> Array:
    """Bring angles into [-pi, pi).

    >>> float(wrap(1.5 * np.pi)) == -0.5 * np.pi
    True
    """
    return se2.wrap(floats("angle", angle))


def to_local(pose: ArrayLike, points: ArrayLike) -> Array:
    """Points of the world in the frame of a pose: x ahead, y to the left.

    Args:
        pose: (..., 3).
        points: (..., 2), in metres.

    Returns:
        (..., 2) points in the frame of `pose`.

    >>> to_local([1.0, 1.0, np.pi / 2], [1.0, 3.0]).round(6).tolist()
    [2.0, 0.0]
    """
    pose, points = floats("pose", pose, (..., 3)), floats("points", points, (..., 2))
    match(pose=pose.shape[:-1], points=points.shape[:-1])
    return se2.to_local(pose, points)


def to_world(pose: ArrayLike, points: ArrayLike) -> Array:
    """Points given in the frame of a pose, in world coordinates; the inverse of `to_local`.

    >>> to_world([1.0, 1.0, np.pi / 2], [2.0, 0.0]).round(6).tolist()
    [1.0, 3.0]
    """
    pose, points = floats("pose", pose, (..., 3)), floats("points", points, (..., 2))
    match(pose=pose.shape[:-1], points=points.shape[:-1])
    return se2.to_world(pose, points)


def compose(first: ArrayLike, second: ArrayLike) -> Array:
    """The pose reached by moving by `second`, given in the frame of `first`.

    >>> compose([1.0, 0.0, np.pi / 2], [1.0, 0.0, 0.0]).round(6).tolist()
    [1.0, 1.0, 1.570796]
    """
    first, second = floats("first", first, (..., 3)), floats("second", second, (..., 3))
    match(first=first.shape[:-1], second=second.shape[:-1])
    return se2.compose(first, second)


def relative(origin: ArrayLike, pose: ArrayLike) -> Array:
    """A pose in the frame of another one; the inverse of `compose`.

    >>> relative([1.0, 0.0, np.pi / 2], [1.0, 1.0, np.pi / 2]).round(6).tolist()
    [1.0, 0.0, 0.0]
    """
    origin, pose = floats("origin", origin, (..., 3)), floats("pose", pose, (..., 3))
    match(origin=origin.shape[:-1], pose=pose.shape[:-1])
    return se2.relative(origin, pose)


def inverse(pose: ArrayLike) -> Array:
    """The inverse of a pose: composed, the two are the identity.

    >>> inverse([1.0, 0.0, np.pi / 2]).round(6).tolist()
    [-0.0, 1.0, -1.570796]
    """
    return se2.inverse(floats("pose", pose, (..., 3)))


def arc_length(points: ArrayLike) -> Array:
    """Metres along a path up to each of its points.

    Args:
        points: (P, 2 or more), P > 0, in metres; a pose is one.

    Returns:
        (P,) metres, 0 at the first point.

    >>> arc_length([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]).tolist()
    [0.0, 5.0, 6.0]
    """
    points = floats("points", points, ("P", "2 or more"), empty=False)
    if points.shape[1] < 2:
        raise InputError(f"points: shape {points.shape}; give at least x and y of each")
    return se2.arc_length(points)


def distance_to_segments(points: ArrayLike, segments: ArrayLike) -> Array:
    """Distance from each point to each segment.

    Args:
        points: (N, 2).
        segments: (S, 4) as x0, y0, x1, y1.

    Returns:
        (N, S) in metres.

    >>> distance_to_segments([[1.0, 2.0], [5.0, 0.0]], [[0.0, 0.0, 2.0, 0.0]]).ravel().tolist()
    [2.0, 3.0]
    """
    points, segments = floats("points", points, ("N", 2)), floats("segments", segments, ("S", 4))
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    offset = points[:, None] - start
    length2 = np.maximum((along**2).sum(-1), 1e-300)
    share = np.clip((offset * along).sum(-1) / length2, 0.0, 1.0)
    return np.linalg.norm(offset - share[..., None] * along, axis=-1)
