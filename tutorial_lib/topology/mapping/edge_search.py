"""RE between the anchors of a trajectory and the vertices of a map, asked where it is worth it.

To ask about every pair takes ever longer as a map grows. Pairs that look alike are asked about
first; where RE says yes, so are their neighbours along both trajectories.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Numbers

Ask = Callable[[Numbers, Numbers], Array]
"""Tells RE (N,) of pairs of rows (N,) and columns (N,)."""
_BESIDE = ((1, 1), (-1, -1), (0, 1), (0, -1))
"""Steps along the trajectory of the row, and along that of the column."""


def search_edges(
    ask: Ask, seeds: NDArray[np.bool_], worth: NDArray[np.bool_], along: Numbers, least: float
) -> Array:
    """RE (A, C) as far as it was asked about, not a number elsewhere.

    Args:
        ask: tells RE.
        seeds: (A, C) pairs to begin with.
        worth: (A, C) pairs that may be asked about at all.
        along: (C, 2R+1) columns before and after each on its trajectory, see `along_trajectories`.
        least: RE from which on neighbours are asked about, too.
    """
    told, middle = np.full(seeds.shape, np.nan), along.shape[1] // 2
    fresh = seeds & worth
    while fresh.any():
        rows, columns = np.nonzero(fresh)
        told[rows, columns] = ask(rows, columns)
        good = told[rows, columns] > least
        fresh = np.zeros_like(seeds)
        for ahead, step in _BESIDE:
            beside, there = along[columns[good], middle + step], rows[good] + ahead
            exist = (beside >= 0) & (there >= 0) & (there < len(seeds))
            fresh[there[exist], beside[exist]] = True
        fresh &= worth & np.isnan(told)
    return told


def weakest_aligned(ask: Ask, told: Array, along: Numbers, reach: int, least: float) -> Array:
    """The least RE (A, C) over aligned sequences around each pair (Meng 2020, III-G).

    Two places that only look alike have neighbours that do not. Where a trajectory ends, the
    sequence does. Pairs that are at most `least` anyway are not looked at any further.

    Args:
        ask: tells RE of pairs that nobody asked about.
        told: (A, C) RE, not a number where nobody asked; what is asked now is put in.
        along: see `search_edges`; R is `reach` at least.
        reach: anchors before and after.
        least: p_edge.
    """
    weakest, middle = np.nan_to_num(told), along.shape[1] // 2
    rows, columns = np.nonzero(weakest > least)
    for step in sorted(set(range(-reach, reach + 1)) - {0}, key=abs):
        beside, there = along[columns, middle + step], rows + step
        exist = (beside >= 0) & (there >= 0) & (there < len(told))
        rows_so, columns_so = there[exist], beside[exist]
        unknown = np.zeros(told.shape, dtype=bool)
        unknown[rows_so, columns_so] = np.isnan(told[rows_so, columns_so])
        told[unknown] = ask(*np.nonzero(unknown))
        pairs = rows[exist], columns[exist]
        weakest[pairs] = np.minimum(weakest[pairs], told[rows_so, columns_so])
        good = weakest[rows, columns] > least
        rows, columns = rows[good], columns[good]
    return weakest


def along_trajectories(
    trails: Sequence[Sequence[int]], trajectory: Numbers, place: Numbers, reach: int
) -> Numbers:
    """(V, 2R+1) the vertices from R before to R after each on its trajectory, -1 beyond its ends.

    Args:
        trails: for each trajectory its vertices, in order.
        trajectory: (V,) of each vertex.
        place: (V,) of each on it.
        reach: R.

    >>> trajectory, place = np.array([0, 0, 0, 1]), np.array([0, 1, 2, 0])
    >>> along_trajectories([[0, 1, 2], [3, 1]], trajectory, place, 1).tolist()
    [[-1, 0, 1], [0, 1, 2], [1, 2, -1], [-1, 3, 1]]
    """
    if not len(trajectory):
        return np.empty((0, 2 * reach + 1), dtype=np.intp)
    lengths = np.array([len(trail) for trail in trails])
    laid = np.concatenate([np.asarray(trail, dtype=np.intp) for trail in trails])
    begins = np.cumsum(lengths) - lengths
    places = place[:, None] + np.arange(-reach, reach + 1)
    exist = (places >= 0) & (places < lengths[trajectory, None])
    numbers = np.clip(begins[trajectory, None] + places, 0, len(laid) - 1)
    return np.where(exist, laid[numbers], -1)
