"""RE between the anchors of a trajectory and the vertices of a map, queried where promising.

Querying every pair takes ever longer as a map grows. Similar pairs are queried first; where RE is
high, so are their neighbours along both trajectories.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices

Query = Callable[[Indices, Indices], Array]
"""Returns RE (N,) of pairs of rows (N,) and columns (N,)."""
_BESIDE = ((1, 1), (-1, -1), (0, 1), (0, -1))
"""Steps along the trajectory of the row, and along that of the column."""


def search_edges(
    query: Query, seeds: NDArray[np.bool_], worth: NDArray[np.bool_], along: Indices, least: float
) -> Array:
    """RE (A, C) where it was queried, NaN elsewhere.

    Args:
        query: returns RE.
        seeds: (A, C) pairs to begin with.
        worth: (A, C) pairs that may be queried at all.
        along: (C, 2R+1) columns before and after each on its trajectory, see `along_trajectories`.
        least: RE above which neighbours are queried, too.
    """
    found, middle = np.full(seeds.shape, np.nan), along.shape[1] // 2
    fresh = seeds & worth
    while fresh.any():
        rows, columns = np.nonzero(fresh)
        found[rows, columns] = query(rows, columns)
        good = found[rows, columns] > least
        fresh = np.zeros_like(seeds)
        for ahead, step in _BESIDE:
            beside, there = along[columns[good], middle + step], rows[good] + ahead
            exist = (beside >= 0) & (there >= 0) & (there < len(seeds))
            fresh[there[exist], beside[exist]] = True
        fresh &= worth & np.isnan(found)
    return found


def weakest_aligned(query: Query, found: Array, along: Indices, reach: int, least: float) -> Array:
    """The least RE (A, C) over aligned sequences around each pair (Meng 2020, III-G).

    Two places that only look alike have neighbours that do not. Where a trajectory ends, the
    sequence does. Pairs that are at most `least` anyway are not examined further.

    Args:
        query: returns RE of pairs that were not queried yet.
        found: (A, C) RE, NaN where it was not queried; further queries are filled in.
        along: see `search_edges`; R is `reach` at least.
        reach: anchors before and after.
        least: p_edge.
    """
    weakest, middle = np.nan_to_num(found), along.shape[1] // 2
    rows, columns = np.nonzero(weakest > least)
    for step in sorted(set(range(-reach, reach + 1)) - {0}, key=abs):
        beside, there = along[columns, middle + step], rows + step
        exist = (beside >= 0) & (there >= 0) & (there < len(found))
        rows_so, columns_so = there[exist], beside[exist]
        unknown = np.zeros(found.shape, dtype=bool)
        unknown[rows_so, columns_so] = np.isnan(found[rows_so, columns_so])
        found[unknown] = query(*np.nonzero(unknown))
        pairs = rows[exist], columns[exist]
        weakest[pairs] = np.minimum(weakest[pairs], found[rows_so, columns_so])
        good = weakest[rows, columns] > least
        rows, columns = rows[good], columns[good]
    return weakest


def along_trajectories(
    paths: Sequence[Sequence[int]], trajectory: Indices, place: Indices, reach: int
) -> Indices:
    """(V, 2R+1) the vertices from R before to R after each on its trajectory, -1 beyond its ends.

    Args:
        paths: for each trajectory its vertices, in order.
        trajectory: (V,) of each vertex.
        place: (V,) of each on it.
        reach: R.

    >>> trajectory, place = np.array([0, 0, 0, 1]), np.array([0, 1, 2, 0])
    >>> along_trajectories([[0, 1, 2], [3, 1]], trajectory, place, 1).tolist()
    [[-1, 0, 1], [0, 1, 2], [1, 2, -1], [-1, 3, 1]]
    """
    if not len(trajectory):
        return np.empty((0, 2 * reach + 1), dtype=np.intp)
    lengths = np.array([len(path) for path in paths])
    laid = np.concatenate([np.asarray(path, dtype=np.intp) for path in paths])
    begins = np.cumsum(lengths) - lengths
    places = place[:, None] + np.arange(-reach, reach + 1)
    exist = (places >= 0) & (places < lengths[trajectory, None])
    numbers = np.clip(begins[trajectory, None] + places, 0, len(laid) - 1)
    return np.where(exist, laid[numbers], -1)
