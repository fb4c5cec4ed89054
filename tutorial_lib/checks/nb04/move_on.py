"""The check of how a follower moves on along its path of anchors, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb04.follower_answers import INVOKE, explained, moved_wrongly, two_anchors
from tutorial_lib.checks.nb04.observations import OBSERVATIONS, RULES, random_observations
from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import (
    FollowerSettings,
    last_visited,
    next_active,
)


def move_on(
    active: int, visited: int, reach: Array, overlap: Array, at: bool, rules: FollowerSettings
) -> tuple[int, int]:
    """Active and last visited anchor after one observation, by the library's rules.

    Args:
        active: index along the path of the anchor that the robot drives to.
        visited: index of the anchor visited last, -1 for none.
        reach: (L,) RE of the path's anchors; 0 where not evaluated.
        overlap: (L,) mean predicted overlap with them.
        at: whether the robot is at the active anchor.
        rules: the thresholds.
    """
    last = len(reach) - 1
    near = (active - 1, active, active + 1)
    around = [overlap[place] if 0 <= place <= last else np.nan for place in near]
    one, before, here = np.array([active]), np.array([visited]), np.array([at])
    seen = last_visited(before, one, np.array([around]), here, rules.visited)
    next_reach = np.array([reach[active + 1] if active < last else np.nan])
    chosen = next_active(one, seen, next_reach, np.array(around[2:]), rules)
    return int(chosen[0]), int(seen[0])


def _moved(
    active: int,
    visited: int,
    reach: Array,
    overlap: Array,
    at: bool,
    rules: FollowerSettings,
    fault: str,
) -> tuple[int, int]:
    """The rule with a `fault`."""
    last, before = len(reach) - 1, visited
    rules = _ruled(rules, fault)
    visited = _visited(active, visited, reach, overlap, at, rules, fault)
    kept = before if at and fault == "at forgotten" else visited
    if fault == "exchanged":
        moved, seen = move_on(active, before, reach, overlap, at, rules)
        return seen, moved
    if active == last and fault == "past the end":
        return active + int(visited >= active), kept
    if active == last:
        return active, before if fault == "last stays" else kept
    sure = bool(reach[active if fault == "own reach" else active + 1] > rules.p_follow)
    near = bool(overlap[active if fault == "own overlap" else active + 1] > rules.near)
    been = visited >= active
    sure |= fault == "reach even" and reach[active + 1] == rules.p_follow
    near |= fault == "near even" and overlap[active + 1] == rules.near
    if fault == "runs":
        ahead = active
        while ahead < last and (visited >= ahead or _ready(ahead + 1, reach, overlap, rules)):
            ahead += 1
        return ahead, visited
    if fault == "visited as it was":
        return active + int(been or (sure and near)), before
    if fault == "paper":
        return active + 1 if sure and near else visited + 1, visited
    if fault == "leaps" and been:
        return visited + 1, visited
    go = {
        "one of two": been or sure or near,
        "no overlap": been or sure,
        "no reach": been or near,
        "no visit": sure and near,
        "equal": visited == active or (sure and near),
        "visit needs reach": sure and (near or been),
        "old": before >= active or (sure and near),
        "never": False,
    }.get(fault, been or (sure and near))
    return active + int(go), kept


def _ready(place: int, reach: Array, overlap: Array, rules: FollowerSettings) -> bool:
    return bool(reach[place] > rules.p_follow and overlap[place] > rules.near)


def _ruled(rules: FollowerSettings, fault: str) -> FollowerSettings:
    """The thresholds, with the `fault`."""
    if fault == "constants":
        return RULES
    if fault == "lose":
        return replace(rules, p_follow=rules.p_lose)
    if fault == "visited when near":
        return replace(rules, visited=rules.near)
    return replace(rules, near=rules.visited) if fault == "near when visited" else rules


def _visited(
    active: int,
    visited: int,
    reach: Array,
    overlap: Array,
    at: bool,
    rules: FollowerSettings,
    fault: str,
) -> int:
    """The last visited anchor, with the `fault`."""
    last = len(overlap) - 1
    first, end = max(active - 1, 0), min(active + 1, last) + 1
    first, end = {
        "whole path": (0, last + 1),
        "wraps": (active - 1, end),
        "wraps round": (active - 1, end),
        "not before": (active, end),
        "not after": (first, active + 1),
        "wide": (first, min(active + 2, last) + 1),
        "wide back": (max(active - 2, 0), end),
    }.get(fault, (first, end))
    best = reach if fault == "by reach" else overlap
    closest = max(range(first, end), key=lambda place: best[place])
    closest = closest % (last + 1) if fault == "wraps round" else closest
    found = bool(overlap[closest] > rules.visited)
    found |= fault == "visited even" and overlap[closest] == rules.visited
    if fault == "farthest" and found:
        closest = max(place for place in range(first, end) if overlap[place] > rules.visited)
    if found or fault == "always":
        visited = closest if fault == "back" else max(visited, closest)
    if not at or fault == "no at" or (fault == "either" and found):
        return visited
    if fault == "at back":
        return active
    return max(visited, closest if fault == "at closest" else active)


_FAULTS = {
    "an overlap of exactly rules.visited is not enough: above": "visited even",
    "an RE of exactly rules.p_follow is not enough: above": "reach even",
    "an overlap of exactly rules.near is not enough: above": "near even",
    "one anchor at a step: if, not while": "runs",
    "return the last visited anchor as it is after this step, not as it was": "visited as it was",
    "at the last anchor, too, the last visited one may change; only the active one stays": (
        "last stays"
    ),
    "compare the overlap of three anchors only; active - 2 is too far back": "wide back",
    "the last visited anchor never goes back to an earlier one: max": "back",
    "the closest anchor counts as visited only if its overlap is above rules.visited": "always",
    "look only at the anchors before, at and after the active one; one far along the path may "
    "look alike": "whole path",
    "compare no overlaps beyond that of the next anchor, active + 1; active + 2 is too far": "wide",
    "of several neighbours above rules.visited only the closest counts, not the farthest": (
        "farthest"
    ),
    "before the first anchor there is none; overlap[-1] is the last one of the path": "wraps",
    "before the first anchor there is none; yours compares overlap[-1], that of the last one": (
        "wraps round"
    ),
    "the anchor before the active one may be the closest, too": "not before",
    "the anchor after the active one may be the closest, too": "not after",
    "the closest anchor is the one with the largest overlap, not with the highest RE": "by reach",
    "at does not take the last visited anchor back to the active one: max": "at back",
    "after the last anchor there is none: it stays active": "past the end",
    "return first the active anchor, then the one last visited": "exchanged",
    "to be near, the overlap of the next anchor counts, overlap[active + 1], not that of the "
    "active one": "own overlap",
    "the next anchor must be reachable and near; one of them is not enough": "one of two",
    "an anchor is reachable above rules.p_follow, not above rules.p_lose": "lose",
    "an anchor counts as visited above rules.visited, not above rules.near": "visited when near",
    "an anchor is near above rules.near, not above rules.visited": "near when visited",
    "the thresholds stand in rules, and are not always the same": "constants",
    "the next anchor must be near, too: its overlap above rules.near": "no overlap",
    "the next anchor must be reachable, too: its RE above rules.p_follow": "no reach",
    "a robot at the active anchor has visited it, whatever the overlap": "no at",
    "at means at the active anchor: that one was visited, not the closest": "at closest",
    "check at whether or not the closest anchor was visited: if, not elif": "either",
    "remember that the active anchor was visited: at": "at forgotten",
    "once the active anchor was visited, the robot must move on": "no visit",
    "a robot that has visited the next anchor has passed the active one, too: visited >= active": (
        "equal"
    ),
    "move on by one anchor at a time, to active + 1, not to visited + 1": "leaps",
    "once the active anchor was visited, the robot must move on, whatever the RE of the next one": (
        "visit needs reach"
    ),
    "update the last visited anchor first, then check whether the active one was visited": "old",
    "the RE of the next anchor counts, reach[active + 1], not that of the active one": "own reach",
    "the active anchor never moves on": "never",
    "the paper's visited + 1 lets the active anchor fall back as soon as the next one is in doubt; "
    "here it stays": "paper",
}
_CASES = dict(OBSERVATIONS.values()) | random_observations(80, 1)


@check(move_on, OBSERVATIONS["next"][1])
def check_move_on(student: Callable[..., Any]) -> None:
    """Under way, near, at an anchor, at both ends, exactly at thresholds, and 80 at random."""
    faults = with_faults(_moved, _FAULTS)
    compare(
        "move_on",
        student,
        _CASES,
        move_on,
        faults,
        invoke=INVOKE,
        form=two_anchors,
        difference=explained,
        broken=moved_wrongly,
    )
