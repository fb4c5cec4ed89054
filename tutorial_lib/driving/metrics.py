"""Was the target reached? One definition for everybody."""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.geometry import Array
from tutorial_lib.world.raycast import Raycaster

REACHED = 0.30
"""Metres from the target that count as reached."""
SLOWEST = 0.3
"""m/s on average, below which a drive is given up (v_min of Meng 2020, III-C)."""
GRACE = 5.0
"""Seconds allowed on top."""


def time_limit(geodesic: ArrayLike) -> Array:
    """Seconds that a drive of so many metres may take.

    >>> time_limit([0.0, 3.0]).tolist()
    [5.0, 15.0]
    """
    return np.asarray(geodesic, dtype=float) / SLOWEST + GRACE


def walls_crossed(caster: Raycaster, poses: Array) -> int:
    """How often a track among `poses` (T, N, 3) passes through a wall."""
    before, after = poses[:-1, :, :2].reshape(-1, 2), poses[1:, :, :2].reshape(-1, 2)
    return int((~caster.sees(before, after)).sum())
