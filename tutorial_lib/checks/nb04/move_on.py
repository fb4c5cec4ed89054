"""The check of how a follower moves on along its trail, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, call, check
from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import (
    FollowerSettings,
    State,
    last_visited,
    next_active,
)

Case = tuple[str, tuple[Any, ...]]
"""What it is like, and the arguments of the function."""
RULES = FollowerSettings()
OTHER_RULES = FollowerSettings(
    p_search=0.7, p_follow=0.8, p_lose=0.3, visited=0.5, near=0.4, patience=2.0
)
"""Other numbers than the usual ones, for whoever writes those into a function."""


def move_on(
    active: int, visited: int, reach: Array, overlap: Array, at: bool, rules: FollowerSettings
) -> tuple[int, int]:
    """Active and last visited anchor after one look, by the library's rules.

    Args:
        active: place along the trail of the anchor that is driven to.
        visited: place of the anchor last visited, -1 for none.
        reach: (L,) RE of the trail's anchors; 0 where nobody asked.
        overlap: (L,) mean predicted overlap with them.
        at: whether the robot is at the active anchor.
        rules: what is enough.
    """
    last = len(reach) - 1
    near = (active - 1, active, active + 1)
    around = [overlap[place] if 0 <= place <= last else np.nan for place in near]
    one, before, here = np.array([active]), np.array([visited]), np.array([at])
    seen = last_visited(before, one, np.array([around]), here, rules.visited)
    next_reach = np.array([reach[active + 1] if active < last else np.nan])
    chosen = next_active(one, seen, next_reach, np.array(around[2:]), rules)
    return int(chosen[0]), int(seen[0])


def look(
    why: str,
    active: int,
    visited: int,
    reach: Sequence[float],
    overlap: Sequence[float],
    at: bool = False,
    rules: FollowerSettings = RULES,
) -> Case:
    """A case: what it is like, and the arguments of `move_on`."""
    return why, (active, visited, np.array(reach), np.array(overlap), at, rules)


_SURE, _FADES = (0.99, 0.99, 0.98, 0.97, 0.95), (0.9, 0.99, 0.6, 0.2, 0.1)
_SEEN, _ENDS = (0.5, 0.6, 0.3, 0.2, 0.85), (0.0, 0.0, 0.0, 0.9, 0.99)
_NEAR, _ASIDE = (0.5, 0.7, 0.65, 0.3, 0.1), (0.3, 0.5, 0.2, 0.1, 0.1)
_ONLY, _ONE = (0.9, 0.5, 0.97, 0.2), (0.4, 0.5, 0.65, 0.1)
_BEHIND = ((0.1, 0.9, 0.6, 0.2, 0.1), (0.1, 0.9, 0.85, 0.2, 0.1))
LOOKS = {
    key: look(*case)
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
    }.items()
}


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
    visited = _visited(active, visited, overlap, at, rules, fault)
    kept = before if at and fault == "at forgotten" else visited
    if active == last:
        return active, kept
    sure = bool(reach[active if fault == "own reach" else active + 1] > rules.p_follow)
    near, been = bool(overlap[active + 1] > rules.near), visited >= active
    if fault == "paper":
        return active + 1 if sure and near else visited + 1, visited
    if fault == "leaps" and been:
        return visited + 1, visited
    go = {
        "no overlap": been or sure,
        "no reach": been or near,
        "no visit": sure and near,
        "equal": visited == active or (sure and near),
        "visit needs reach": sure and (near or been),
        "old": before >= active or (sure and near),
        "never": False,
    }.get(fault, been or (sure and near))
    return active + int(go), kept


def _visited(
    active: int, visited: int, overlap: Array, at: bool, rules: FollowerSettings, fault: str
) -> int:
    """The last visited anchor, with the `fault`."""
    last = len(overlap) - 1
    first, end = max(active - 1, 0), min(active + 1, last) + 1
    first, end = {
        "whole trail": (0, last + 1),
        "wraps": (active - 1, end),
        "wide": (first, min(active + 2, last) + 1),
    }.get(fault, (first, end))
    closest = max(range(first, end), key=lambda place: overlap[place])
    found = overlap[closest] > rules.visited
    if fault == "farthest" and found:
        closest = max(place for place in range(first, end) if overlap[place] > rules.visited)
    if found or fault == "always":
        visited = closest if fault == "back" else max(visited, closest)
    if not at or fault == "no at" or (fault == "either" and found):
        return visited
    return max(visited, closest if fault == "at closest" else active)


_UNMOVED = {
    "the last visited anchor never goes back to an earlier one: max": "back",
    "the closest anchor counts as visited only if its overlap is above rules.visited": "always",
    "look only at the anchors before, at and after the active one; one far along the trail may "
    "look alike": "whole trail",
    "compare no overlaps beyond that of the next anchor, active + 1; active + 2 is too far": "wide",
    "of several neighbours above rules.visited only the closest counts, not the farthest": (
        "farthest"
    ),
    "before the first anchor there is none; overlap[-1] is the last one of the trail": "wraps",
    "the next anchor must be near, too: its overlap above rules.near": "no overlap",
    "the next anchor must be reachable, too: its RE above rules.p_follow": "no reach",
    "who is at the active anchor has visited it, whatever the overlap": "no at",
    "at means at the active anchor: that one was visited, not the closest": "at closest",
    "ask for at whether or not the closest anchor was visited: if, not elif": "either",
    "keep that the active anchor was visited: at": "at forgotten",
    "once the active anchor was visited, the robot must get on": "no visit",
    "who has visited the next anchor has left the active one behind, too: visited >= active": (
        "equal"
    ),
    "go on by one anchor at a time, to active + 1, not to visited + 1": "leaps",
    "once the active anchor was visited, the robot must get on, whatever the RE of the next one": (
        "visit needs reach"
    ),
    "update the last visited anchor first, then ask whether the active one was visited": "old",
    "the RE of the next anchor counts, reach[active + 1], not that of the active one": "own reach",
    "the active anchor never moves on": "never",
    "the paper's visited + 1 lets the active anchor fall back as soon as the next one is in doubt; "
    "here it stays": "paper",
}


@check(move_on, LOOKS["next"][1])
def check_move_on(student: Callable[..., Any]) -> None:
    """Twenty-one looks: under way, near, at an anchor, at both ends, and with other rules."""
    faults = {words: partial(_moved, fault=fault) for words, fault in _UNMOVED.items()}
    compare("move_on", student, list(LOOKS.values()), move_on, faults)


def compare(
    name: str,
    student: Callable[..., Any],
    cases: Sequence[Case],
    right: Callable[..., Any],
    faults: Mapping[str, Callable[..., Any]],
) -> None:
    """Demand the right answer to all cases.

    Args:
        name: of the exercise.
        student: whose function is judged.
        cases: what it is asked.
        right: answers it, with a tuple that may begin with a state.
        faults: by what to say of it, functions that answer as a known mistake does; one that
            explains all of the student's answers is named.

    Raises:
        WrongAnswer: when an answer is wrong.
    """
    wanted = [_outcome(right(*arguments)) for _, arguments in cases]
    answers = []
    for why, arguments in cases:
        try:
            got = call(student, *arguments)
        except IndexError as error:
            words = f"IndexError, {error}; after the last anchor there is none: stay there"
            raise WrongAnswer(f"{name}, {why}: {words}") from None
        answers.append(_checked(f"{name}, {why}", got, len(right(*arguments))))
    for (why, _), got, want in zip(cases, answers, wanted, strict=True):
        if got == want:
            continue
        for words, fault in faults.items():
            if answers == [_outcome(fault(*arguments)) for _, arguments in cases]:
                raise WrongAnswer(f"{name}, {why}: {words}")
        raise WrongAnswer(f"{name}, {why}: {_spoken(got)} came back; {_spoken(want)} is right")


def _checked(what: str, got: Any, count: int) -> tuple[int, ...]:  # noqa: ANN401 - students'
    """A student's answer, if it has the right form."""
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    parts = "active, visited" if count == 2 else "state, active, visited"
    if not isinstance(got, tuple | list) or len(got) != count:
        raise WrongAnswer(f"{what}: return {parts}")
    whole = all(isinstance(number, int | np.integer) for number in got)
    if not whole or (count == 3 and got[0] not in list(State)):
        raise WrongAnswer(f"{what}: {got} came back; return {parts}: a State and whole numbers")
    return _outcome(got if count == 2 else (State(got[0]), *got[1:]))


def _outcome(answer: Sequence[int]) -> tuple[int, ...]:
    """What counts of an answer: who is lost or done has no anchor any more."""
    if isinstance(answer[0], State):
        over = answer[0] in (State.LOST, State.DONE)
        return answer[:1] if over else (answer[0], *map(int, answer[1:]))
    return tuple(int(number) for number in answer)


def _spoken(answer: tuple[int, ...]) -> str:
    return ", ".join(part.name if isinstance(part, State) else str(part) for part in answer)
