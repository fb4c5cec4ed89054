"""RE between the anchors of a trajectory and the vertices of a map, asked where it is worth it.

To ask about every pair takes ever longer as a map grows. Pairs that look alike are asked about
first; where RE says yes, so are their neighbours along both trajectories.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.vertices import Numbers

Ask = Callable[[Numbers, Numbers], Array]
"""Tells RE (N,) of pairs of rows (N,) and columns (N,)."""
_BESIDE = ((1, 1), (-1, -1), (0, 1), (0, -1))
"""Steps along the trajectory of the row, and along that of the column."""


def searched(
    ask: Ask, seeds: NDArray[np.bool_], before: Numbers, after: Numbers, p_edge: float
) -> Array:
    """RE (A, C) as far as it was asked about, not a number elsewhere.

    Args:
        ask: tells RE.
        seeds: (A, C) pairs to begin with.
        before: (C,) the column before each on its trajectory, -1 for none.
        after: (C,) the column after each.
        p_edge: RE from which on neighbours are asked about, too.
    """
    told = np.full(seeds.shape, np.nan)
    fresh = seeds
    while fresh.any():
        rows, columns = np.nonzero(fresh)
        told[rows, columns] = ask(rows, columns)
        good = told[rows, columns] > p_edge
        fresh = np.zeros_like(seeds)
        for along, across in _BESIDE:
            beside = stepped(columns[good], across, before, after)
            ahead = rows[good] + along
            exist = (beside >= 0) & (ahead >= 0) & (ahead < len(seeds))
            fresh[ahead[exist], beside[exist]] = True
        fresh &= np.isnan(told)
    return told


def weakest_aligned(told: Array, before: Numbers, after: Numbers, reach: int) -> Array:
    """The least RE (A, C) over aligned sequences around each pair (Meng 2020, III-G).

    Two places that only look alike have neighbours that do not. Where a trajectory ends, the
    sequence does.

    Args:
        told: (A, C) RE, not a number where nobody asked, which counts as 0.
        before: see `searched`.
        after: see `searched`.
        reach: anchors before and after.
    """
    told = np.nan_to_num(told, nan=0.0)
    weakest = told.copy()
    rows, columns = np.nonzero(told)
    for sign in (-1, 1):
        beside = columns
        for step in range(1, reach + 1):
            beside = stepped(beside, sign, before, after)
            ahead = rows + sign * step
            exist = (beside >= 0) & (ahead >= 0) & (ahead < len(told))
            there = told[np.clip(ahead, 0, len(told) - 1), beside]
            least = np.minimum(weakest[rows, columns], np.where(exist, there, 1.0))
            weakest[rows, columns] = least
    return weakest


def stepped(columns: Numbers, step: int, before: Numbers, after: Numbers) -> Numbers:
    """The column one `step` of -1, 0 or 1 on along its trajectory; -1 beyond an end."""
    if not step:
        return columns
    return np.where(columns >= 0, (after if step > 0 else before)[columns], -1)
