"""Single observations of a follower, for the checks of notebook 04."""

from collections.abc import Sequence

import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import FollowerSettings

Case = tuple[int, int, Array, Array, bool, FollowerSettings]
"""The arguments of `move_on`."""
RULES = FollowerSettings()
OTHER_RULES = FollowerSettings(
    p_search=0.7, p_follow=0.8, p_lose=0.3, visited=0.5, near=0.4, timeout=2.0
)
"""Other thresholds than the usual ones, to find those that are written into a function."""


def observe(
    active: int,
    visited: int,
    reach: Sequence[float],
    overlap: Sequence[float],
    at: bool = False,
    rules: FollowerSettings = RULES,
) -> Case:
    """A case of `move_on`."""
    return active, visited, np.array(reach), np.array(overlap), at, rules


_SURE, _FADES = (0.99, 0.99, 0.98, 0.97, 0.95), (0.9, 0.99, 0.6, 0.2, 0.1)
_SEEN, _ENDS = (0.5, 0.6, 0.3, 0.2, 0.85), (0.0, 0.0, 0.0, 0.9, 0.99)
_NEAR, _ASIDE = (0.5, 0.7, 0.65, 0.3, 0.1), (0.3, 0.5, 0.2, 0.1, 0.1)
_ONLY, _ONE = (0.9, 0.5, 0.97, 0.2), (0.4, 0.5, 0.65, 0.1)
_PAST = (0.1, 0.9, 0.3)
_BEHIND = ((0.1, 0.9, 0.6, 0.2, 0.1), (0.1, 0.9, 0.85, 0.2, 0.1))
OBSERVATIONS = {
    "under way": observe(2, 1, (0.0, 0.99, 0.97, 0.5), (0.0, 0.5, 0.7, 0.4)),
    "the next one reachable and near": observe(1, 0, _SURE, _NEAR),
    "the next one reachable, but far": observe(1, 0, _SURE, _SEEN),
    "the next one near, but not reachable": observe(1, 0, _FADES, _NEAR),
    "only the next one reachable": observe(1, 0, _ONLY, _ONE),
    "close to the active anchor": observe(1, 0, _FADES, (0.4, 0.85, 0.5, 0.1, 0.1)),
    "at the active anchor, turned aside": observe(1, 0, _FADES, _ASIDE, True),
    "at it, the next one closer": observe(1, 0, _FADES[:4], _ONE, True),
    "at it, the one before close": observe(1, 0, _FADES[:3], (0.85, 0.7, 0.2), True),
    "the second next one looks close": observe(1, 0, _FADES, (0.3, 0.5, 0.7, 0.85, 0.1)),
    "three close ones": observe(1, 0, _FADES, (0.85, 0.9, 0.84, 0.3, 0.1)),
    "the one before closer than the active one": observe(2, 1, *_BEHIND),
    "the active one visited earlier": observe(1, 1, _FADES, _NEAR),
    "the active one visited, the next one far": observe(1, 1, _SURE, _SEEN),
    "well ahead of the one visited": observe(2, 0, _FADES[1:], (0.1, 0.5, 0.7, 0.3)),
    "the next one is the closest": observe(1, 0, _FADES, (0.2, 0.6, 0.85, 0.5, 0.1)),
    "an earlier one is closer": observe(2, 2, (0.0, 0.9, 0.97, 0.5), (0.0, 0.9, 0.7, 0.3)),
    "at the start": observe(0, -1, (0.97, 0.5, 0.4, 0.98), (0.85, 0.3, 0.2, 0.9)),
    "at the last anchor": observe(4, 3, _ENDS, (0.0, 0.0, 0.0, 0.5, 0.9), True),
    "other rules": observe(1, 0, (0.9, 0.95, 0.85), (0.3, 0.45, 0.45), False, OTHER_RULES),
    "other rules, close": observe(1, 0, _FADES[:3], (0.3, 0.6, 0.3), False, OTHER_RULES),
    "two far behind the closest": observe(3, 0, _FADES, (0.1, 0.95, 0.3, 0.9, 0.2)),
    "two more reachable and near": observe(1, 0, _SURE, (0.3, 0.5, 0.7, 0.75, 0.7)),
    "overlap of exactly rules.visited": observe(1, 0, _FADES[:3], (0.3, 0.8, 0.5)),
    "RE of exactly rules.p_follow": observe(1, 0, (0.9, 0.95, 0.92), (0.3, 0.5, 0.7)),
    "overlap of exactly rules.near": observe(1, 0, (0.9, 0.95, 0.99), (0.3, 0.5, 0.6)),
    "the last anchor close, not at it": observe(2, 1, (0.1, 0.9, 0.99), (0.1, 0.3, 0.9)),
    "the last anchor active, an earlier one close": observe(2, 0, _FADES[:3], _PAST),
    "the last anchor active and far": observe(2, 1, (0.1, 0.9, 0.99), (0.1, 0.3, 0.4)),
    "one anchor alone, at it": observe(0, -1, (0.97,), (0.3,), True),
    "one anchor alone, close": observe(0, -1, (0.97,), (0.9,)),
    "at the first anchor": observe(0, -1, (0.9, 0.2, 0.1), (0.3, 0.2, 0.1), True),
}


def random_observations(count: int, seed: int) -> dict[str, Case]:
    """Observations of all kinds."""
    rng = np.random.default_rng(seed)
    cases = {}
    for number in range(count):
        last = int(rng.integers(1, 7))
        active = int(rng.integers(last + 1))
        visited = int(rng.integers(-1, active + 1))
        rules = (RULES, OTHER_RULES)[number % 2]
        reach, overlap = rng.uniform(0.0, 1.0, (2, last + 1)).round(3)
        if number % 3 == 0:
            reach[rng.integers(last + 1)] = rules.p_follow
            overlap[rng.integers(last + 1)] = (rules.near, rules.visited)[number % 2]
        at = bool(rng.random() < 0.2)
        cases[f"observation {number}"] = (active, visited, reach, overlap, at, rules)
    return cases
