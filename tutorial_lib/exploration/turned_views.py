"""What a robot with a panorama would see with a camera ahead, had it turned.

A panorama holds every such picture, so that what was learned for the camera of a car can be used by
a robot that looks all around, in whatever direction.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import column_of
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, wrap
from tutorial_lib.world.sensors import Camera, Laser, full_circle


def turned(
    observations: Observation, headings: ArrayLike, *, with_depth: bool = False
) -> Observation:
    """Observations with the camera's picture and a laser scan, as if the robots had turned.

    Args:
        observations: N panoramas with depth.
        headings: (N,) or one for all, rad counter-clockwise from where the robots look.
        with_depth: whether the camera measures depth, too.

    Raises:
        InputError: where there is no depth.
    """
    if observations.depth is None:
        raise InputError("turned views: panoramas without depth; use the rgbd sensor")
    count = len(observations)
    headings = np.broadcast_to(np.asarray(headings, dtype=float), (count,))
    odometry = observations.odometry.copy()
    odometry[:, 2] = wrap(odometry[:, 2] + headings)
    ranges = np.asarray(observations.depth, dtype=float)
    return Observation(
        pinhole(observations.image, headings),
        _depths(ranges, headings) if with_depth else None,
        _scans(ranges, headings),
        odometry,
        observations.speed,
        observations.steering,
    )


def pinhole(panoramas: NDArray[np.uint8], headings: Array) -> NDArray[np.uint8]:
    """The `Camera`'s pictures (N, 16, 64, 3) out of panoramas (N, 16, W, 3).

    Each pixel is the mean of what it covers: a row of the camera's image is straight, that of a
    panorama lies on a cylinder, so that a wall's height differs by the cosine of its bearing.

    Args:
        panoramas: as `PanoramicCamera` takes them.
        headings: (N,) rad counter-clockwise.
    """
    count, rows, columns = panoramas.shape[:3]
    camera = Camera(rows=rows)
    borders, row_borders = _borders(camera)
    # To the left of column 0 is the last one.
    places = (np.pi - borders - headings[:, None]) / (2 * np.pi) * columns % columns
    width = (np.roll(places, -1, axis=1) - places)[:, :-1] % columns
    places = np.concatenate([places[:, :1], places[:, :1] + np.cumsum(width, axis=1)], axis=1)
    around = np.concatenate([panoramas, panoramas], axis=2).astype(np.float32)
    upright = _means(np.moveaxis(around, 2, 1), places)  # (N, 64, 16, 3)
    upright = upright.reshape(-1, rows, 3)
    straight = _means(upright, np.tile(row_borders, (count, 1)))
    straight = straight.reshape(count, camera.columns, rows, 3)
    return np.rint(np.moveaxis(straight, 1, 2)).astype(np.uint8)


@lru_cache(maxsize=4)
def _borders(camera: Camera) -> tuple[Array, Array]:
    """Bearings (65,) of the columns' borders, and rows (64, 17) of a panorama at those of rows."""
    edge = np.tan(camera.field_of_view / 2)
    bearings = np.arctan(edge * np.linspace(1.0, -1.0, camera.columns + 1))
    slopes = np.linspace(1.0, -1.0, camera.rows + 1)
    flatten = camera.flatten[::-1, None].astype(float)
    return bearings, (1.0 - flatten * slopes) * camera.rows / 2


def _means(values: NDArray[np.float32], borders: Array) -> NDArray[np.float32]:
    """Means (M, K, ...) of values (M, L, ...) between neighbours of borders (M, K + 1), rising."""
    total = np.cumsum(values, axis=1, dtype=np.float64)
    total = np.concatenate([np.zeros_like(total[:, :1]), total], axis=1)
    whole = np.clip(np.floor(borders).astype(np.intp), 0, values.shape[1] - 1)
    part = borders - whole
    row = np.arange(len(values))[:, None]
    each = (..., *(None,) * (values.ndim - 2))
    until = total[row, whole] + part[each] * values[row, whole]
    return (np.diff(until, axis=1) / np.diff(borders, axis=1)[each]).astype(np.float32)


def _depths(ranges: Array, headings: Array) -> Array:
    """Metres (N, 64) along the rays of the `Camera`'s columns, from left to right."""
    bearings = Camera().fan.angles[::-1]
    columns = column_of(bearings + headings[:, None], ranges.shape[1])
    return np.take_along_axis(ranges, columns, axis=1)


def _scans(ranges: Array, headings: Array) -> Array:
    """Laser scans (N, 96), in the frames of robots that have turned by `headings` (N,)."""
    laser = Laser()
    columns = column_of(full_circle(laser.beams) + headings[:, None], ranges.shape[1])
    return np.minimum(np.take_along_axis(ranges, columns, axis=1), laser.range)
