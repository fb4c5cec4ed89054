"""Tables of RE and trajectories to insert, for the check of notebook 05."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tutorial_lib.checks.nb05.small_map import SmallMap
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices


@dataclass(frozen=True)
class Case:
    """Trajectories to insert one after the other."""

    reach: Array
    scores: Array
    trajectories: list[Indices]
    p_reuse: float


def _along(places: list[list[float]], p_reuse: float, seed: int, less: float = 0.0) -> Case:
    """Trajectories along a corridor: RE falls with the metres ahead, and faster behind.

    Args:
        places: metres along the corridor of each trajectory's anchors.
        p_reuse: of the case.
        seed: of a little noise.
        less: by which RE as edges is lower, as with sequences; higher if negative.
    """
    rng, metres = np.random.default_rng(seed), np.concatenate(places)
    ahead = metres - metres[:, None]
    far = np.where(ahead >= 0, ahead, -3 * ahead)
    reach = (np.exp(-0.05 * far**2) * rng.uniform(0.97, 1.0, far.shape)).round(4)
    np.fill_diagonal(reach, 1.0)
    scores = np.clip(reach - less * rng.random(far.shape), 0.0, 1.0).round(4)
    bounds = np.cumsum([0, *map(len, places)])
    own = [np.arange(first, last) for first, last in pairwise(bounds)]
    return Case(reach, scores, own, p_reuse)


def _random_case(seed: int) -> Case:
    """RE at random, and trajectories of different lengths."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(2, 6, 4)
    reach = rng.uniform(0.0, 1.0, (lengths.sum(), lengths.sum())).round(3)
    scores = (reach * rng.uniform(0.5, 1.0, reach.shape)).round(3)
    numbers = rng.permutation(lengths.sum())
    own = np.split(numbers, np.cumsum(lengths)[:-1])
    return Case(reach, scores, own, float(rng.choice([0.3, 0.5, 0.7])))


_TWICE = [[0.0, 1.0, 2.0, 3.0], [0.1, 1.1, 2.1, 3.1]]
CASES = {
    "one trajectory": _along(_TWICE[:1], 0.9, 1),
    "the same path twice": _along(_TWICE, 0.9, 2),
    "nothing may be reused": _along(_TWICE, 1.0, 3),
    "a part in common": _along([[0, 1, 2, 3], [9, 8, 2, 3, 4, 5], [1, 2, 3, 4]], 0.9, 4),
    "scores below reach": _along([[0, 1, 2, 3], [0.5, 1.5, 2.5, 7], [1, 2, 3, 4, 8]], 0.85, 5, 0.4),
    "some scores above reach": _along([[0, 1, 2, 3], [0.2, 1.2, 5, 6]], 0.85, 9, -0.3),
    "back and there again": _along([[0, 1, 2, 3], [3, 2, 1, 0], [0, 1, 2, 3]], 0.8, 6),
    "many anchors close together": _along([[0, 0.5, 1, 1.5], [0, 0.1, 0.2, 0.3, 0.4, 1.4]], 0.9, 7),
} | {f"RE at random ({seed})": _random_case(seed) for seed in range(6)}
_LARGE = _along([np.linspace(0, 40, 90).tolist(), np.linspace(5, 30, 17).tolist()], 0.9, 8)


def _example() -> tuple:
    """A trajectory to insert into a map of 90 vertices."""
    grown, (first, second) = SmallMap.empty(_LARGE.reach), _LARGE.trajectories
    grown.vertices = first.tolist()
    grown.paths = [first.tolist()]
    grown.trajectory[first], grown.place[first] = 0, first
    grown.before[first[1:]], grown.after[first[:-1]] = first[:-1], first[1:]
    return grown, second, _LARGE.scores, _LARGE.p_reuse


EXAMPLE = _example()
