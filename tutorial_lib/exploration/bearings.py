"""Directions around a panorama: bins of bearings, and the columns of the image."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.se2 import Array, wrap
from tutorial_lib.validation import floats, integers, whole

DIRECTIONS = 12
"""Directions of a node, n_theta of Chaplot et al. 2020."""
RADIUS = 3.0
"""Metres of a node and of its local map, r of the paper."""

_MOST = 1_000_000  # directions, or columns of a panorama


def bin_of(bearings: ArrayLike, directions: int = DIRECTIONS) -> NDArray[np.intp]:
    """The bin nearest to each bearing (...), in rad; the last one is followed by 0.

    >>> bin_of(np.deg2rad([0.0, 14.0, 16.0, -30.0, 350.0])).tolist()
    [0, 0, 1, 11, 0]
    """
    whole("directions", directions, least=1, most=_MOST)
    bins = np.rint(floats("bearings", bearings) * directions / (2 * np.pi))
    return bins.astype(np.intp) % directions


def bearing_of(bins: ArrayLike, directions: int = DIRECTIONS) -> Array:
    """The bearings (...) in [-pi, pi) on which bins are centred.

    >>> np.rad2deg(bearing_of([0, 1, 11])).round(6).tolist()
    [0.0, 30.0, -30.0]
    """
    whole("directions", directions, least=1, most=_MOST)
    return wrap(integers("bins", bins) * (2 * np.pi / directions))


def column_bearings(columns: int) -> Array:
    """Bearings (W,) of a panorama's columns: from nearly pi on the left down to nearly -pi.

    >>> np.rad2deg(column_bearings(4)).tolist()
    [135.0, 45.0, -45.0, -135.0]
    """
    whole("columns", columns, least=1, most=_MOST)
    return np.pi - (np.arange(columns, dtype=float) + 0.5) * (2 * np.pi / columns)


def column_of(bearings: ArrayLike, columns: int) -> NDArray[np.intp]:
    """The column of a panorama that covers each bearing (...).

    >>> column_of([0.1, -0.1, np.pi - 0.1, -np.pi + 0.1], 192).tolist()
    [92, 99, 3, 188]
    """
    whole("columns", columns, least=1, most=_MOST)
    turns = (np.pi - floats("bearings", bearings)) / (2 * np.pi)
    return np.floor(turns * columns).astype(np.intp) % columns
