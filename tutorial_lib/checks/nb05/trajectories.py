"""Small maps of several trajectories, for the checks of notebook 05."""

import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices


def neighbours(*paths: list[int]) -> tuple[Indices, Indices]:
    """(V,) the vertex before and after each, -1 for none."""
    before, after = np.full((2, sum(map(len, paths))), -1)
    for path in paths:
        before[path[1:]], after[path[:-1]] = path[:-1], path[1:]
    return before, after


def random_reach(anchors: int, vertices: int, seed: int) -> Array:
    """RE (A, V) at random."""
    return np.random.default_rng(seed).uniform(0.05, 1.0, (anchors, vertices)).round(2)


ONE, TWO = neighbours([0, 1, 2, 3, 4]), neighbours([0, 1, 2], [3, 4, 5])
MIXED = neighbours([4, 0, 6, 2], [1, 5, 3])
JOINED = np.array([-1, 0, 1, -1, 1]), np.array([1, 2, -1, 1, -1])
"""A trajectory 0, 1, 2; vertex 1 is reused by one from 3 and by one that goes on to 4."""
