"""Single observations of a follower, for the checks of notebook 04."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tutorial_lib.topology.following.transitions import (
    FollowerSettings,
)

Case = tuple[str, tuple[Any, ...]]
"""What it is like, and the arguments of the function."""


RULES = FollowerSettings()


OTHER_RULES = FollowerSettings(
    p_search=0.7, p_follow=0.8, p_lose=0.3, visited=0.5, near=0.4, timeout=2.0
)
"""Other thresholds than the usual ones, to find those that are written into a function."""


def observe(
    why: str,
    active: int,
    visited: int,
    reach: Sequence[float],
    overlap: Sequence[float],
    at: bool = False,
    rules: FollowerSettings = RULES,
) -> Case:
    """A case of `move_on`: what it is like, and the arguments."""
    return why, (active, visited, np.array(reach), np.array(overlap), at, rules)


_SURE, _FADES = (0.99, 0.99, 0.98, 0.97, 0.95), (0.9, 0.99, 0.6, 0.2, 0.1)


_SEEN, _ENDS = (0.5, 0.6, 0.3, 0.2, 0.85), (0.0, 0.0, 0.0, 0.9, 0.99)


_NEAR, _ASIDE = (0.5, 0.7, 0.65, 0.3, 0.1), (0.3, 0.5, 0.2, 0.1, 0.1)


_ONLY, _ONE = (0.9, 0.5, 0.97, 0.2), (0.4, 0.5, 0.65, 0.1)


_PAST = (0.1, 0.9, 0.3)


_BEHIND = ((0.1, 0.9, 0.6, 0.2, 0.1), (0.1, 0.9, 0.85, 0.2, 0.1))


OBSERVATIONS = {
    key: observe(*case)
    for key, case in {
        "way": ("under way", 2, 1, (0.0, 0.99, 0.97, 0.5), (0.0, 0.5, 0.7, 0.4)),
        "next": ("the next one reachable and near", 1, 0, _SURE, _NEAR),
        "far": ("the next one reachable, but far", 1, 0, _SURE, _SEEN),
        "hidden": ("the next one near, but not reachable", 1, 0, _FADES, _NEAR),
        "only": ("only the next one reachable", 1, 0, _ONLY, _ONE),
        "close": ("close to the active anchor", 1, 0, _FADES, (0.4, 0.85, 0.5, 0.1, 0.1)),
        "at": ("at the active anchor, turned aside", 1, 0, _FADES, _ASIDE, True),
        "beside": ("at it, the next one closer", 1, 0, _FADES[:4], _ONE, True),
        "both": ("at it, the one before close", 1, 0, _FADES[:3], (0.85, 0.7, 0.2), True),
        "second": ("the second next one looks close", 1, 0, _FADES, (0.3, 0.5, 0.7, 0.85, 0.1)),
        "amid": ("three close ones", 1, 0, _FADES, (0.85, 0.9, 0.84, 0.3, 0.1)),
        "behind": ("the one before closer than the active one", 2, 1, *_BEHIND),
        "again": ("the active one visited earlier", 1, 1, _FADES, _NEAR),
        "passed": ("the active one visited, the next one far", 1, 1, _SURE, _SEEN),
        "leap": ("well ahead of the one visited", 2, 0, _FADES[1:], (0.1, 0.5, 0.7, 0.3)),
        "beyond": ("the next one is the closest", 1, 0, _FADES, (0.2, 0.6, 0.85, 0.5, 0.1)),
        "back": ("an earlier one is closer", 2, 2, (0.0, 0.9, 0.97, 0.5), (0.0, 0.9, 0.7, 0.3)),
        "start": ("at the start", 0, -1, (0.97, 0.5, 0.4, 0.98), (0.85, 0.3, 0.2, 0.9)),
        "end": ("at the last anchor", 4, 3, _ENDS, (0.0, 0.0, 0.0, 0.5, 0.9), True),
        "rules": ("other rules", 1, 0, (0.9, 0.95, 0.85), (0.3, 0.45, 0.45), False, OTHER_RULES),
        "doubt": ("other rules, close", 1, 0, _FADES[:3], (0.3, 0.6, 0.3), False, OTHER_RULES),
        "two": ("two far behind the closest", 3, 0, _FADES, (0.1, 0.95, 0.3, 0.9, 0.2)),
        "run": ("two more reachable and near", 1, 0, _SURE, (0.3, 0.5, 0.7, 0.75, 0.7)),
        "limit": ("overlap of exactly rules.visited", 1, 0, _FADES[:3], (0.3, 0.8, 0.5)),
        "reach": ("RE of exactly rules.p_follow", 1, 0, (0.9, 0.95, 0.92), (0.3, 0.5, 0.7)),
        "near": ("overlap of exactly rules.near", 1, 0, (0.9, 0.95, 0.99), (0.3, 0.5, 0.6)),
        "last": ("the last anchor close, not at it", 2, 1, (0.1, 0.9, 0.99), (0.1, 0.3, 0.9)),
        "before": ("the last anchor active, an earlier one close", 2, 0, _FADES[:3], _PAST),
        "far end": ("the last anchor active and far", 2, 1, (0.1, 0.9, 0.99), (0.1, 0.3, 0.4)),
        "one": ("one anchor alone, at it", 0, -1, (0.97,), (0.3,), True),
        "alone": ("one anchor alone, close", 0, -1, (0.97,), (0.9,)),
        "first": ("at the first anchor", 0, -1, (0.9, 0.2, 0.1), (0.3, 0.2, 0.1), True),
    }.items()
}


def random_observations(count: int, seed: int) -> dict[str, Case]:
    """Observations of all kinds: the case of each, and the arguments of `move_on`."""
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
