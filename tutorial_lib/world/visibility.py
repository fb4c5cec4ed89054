"""How much two views share; line of sight between points is `Raycaster.sees`."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.se2 import to_local
from tutorial_lib.validation import alike, floats, instance, number, whole
from tutorial_lib.world.raycast import Fan, Raycaster

RAYS = 100
"""Rays that sample a view."""
OFF_THE_WALL = 0.06
"""Metres by which a point on a wall is pulled back before the other view must see it."""
_MOST_RAYS = 100_000
FIELD_OF_VIEW = float(np.deg2rad(120.0))


def mutual_overlap(
    caster: Raycaster,
    first: ArrayLike,
    second: ArrayLike,
    field_of_view: float = FIELD_OF_VIEW,
    rays: int = RAYS,
) -> NDArray[np.float64]:
    """The share of each view that the other one sees as well (Meng 2020, III-B).

    The share of one view's points, sampled by equally spaced rays, that lie within the field of
    view of the other and in its line of sight. Symmetric only where both see equally far.

    Args:
        caster: the walls.
        first: (N, 3) poses.
        second: (N, 3) poses.
        field_of_view: radians, of both.
        rays: that sample each view.

    Returns:
        (N, 2) in [0, 1]: the share of the first view in the second, and of the second in the first.
    """
    instance("caster", caster, Raycaster)
    first = np.atleast_2d(floats("first", first, (..., 3)))
    second = np.atleast_2d(floats("second", second, (..., 3)))
    alike(first=first, second=second)
    field_of_view = number("field_of_view", field_of_view, above=0, most=2 * np.pi)
    rays = whole("rays", rays, least=1, most=_MOST_RAYS)
    shares = [
        _share(caster, a, b, field_of_view, rays) for a, b in ((first, second), (second, first))
    ]
    return np.stack(shares, axis=1)


def _share(
    caster: Raycaster,
    viewers: NDArray[np.float64],
    others: NDArray[np.float64],
    field_of_view: float,
    rays: int,
) -> NDArray[np.float64]:
    """(N,) the share of each viewer's points that the other one sees."""
    fan = Fan(field_of_view * ((np.arange(rays) + 0.5) / rays - 0.5))
    distance = caster.cast(viewers, fan).distance
    seen = np.isfinite(distance)
    # Never back onto the viewer, whose own position has no bearing.
    reach = np.where(seen, np.maximum(distance - OFF_THE_WALL, distance / 2), 0.0)
    angles = viewers[:, 2:] + fan.angles
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = viewers[:, None, :2] + reach[..., None] * direction
    local = to_local(others[:, None], points)
    in_view = seen & (np.abs(np.arctan2(local[..., 1], local[..., 0])) <= field_of_view / 2)
    origins = np.broadcast_to(others[:, None, :2], points.shape)[in_view]
    in_view[in_view] = caster.sees(origins, points[in_view])
    return in_view.mean(axis=1)
