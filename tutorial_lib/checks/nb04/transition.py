"""The check of the follower's state machine, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb04.follower_answers import (
    changed_wrongly,
    explained,
    state_and_anchors,
)
from tutorial_lib.checks.nb04.forms import INVOKE
from tutorial_lib.checks.nb04.move_on import move_on
from tutorial_lib.checks.nb04.observations import (
    OBSERVATIONS,
    OTHER_RULES,
    RULES,
    Case,
    observe,
    random_observations,
)
from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import FollowerSettings, State


def transition(
    state: State,
    active: int,
    visited: int,
    reach: Array,
    overlap: Array,
    at: bool,
    waited: float,
    rules: FollowerSettings,
) -> tuple[State, int, int]:
    """State, active and last visited anchor of a follower after one observation.

    Args:
        state: until now: SEARCH, FOLLOW or DEAD_RECKONING.
        active: see `move_on`.
        visited: see `move_on`.
        reach: see `move_on`; while searching, all are evaluated.
        overlap: see `move_on`.
        at: see `move_on`.
        waited: seconds in dead reckoning; it means nothing in the other states.
        rules: the thresholds.
    """
    return _changed(state, active, visited, reach, overlap, at, waited, rules)


def _changed(
    state: State,
    active: int,
    visited: int,
    reach: Array,
    overlap: Array,
    at: bool,
    waited: float,
    rules: FollowerSettings,
    fault: str = "",
) -> tuple[State, int, int]:
    """The state machine, with a `fault` if one is named."""
    search = rules.p_follow if fault == "follow's threshold" else rules.p_search
    follow = {"soon back": rules.p_lose, "search's": rules.p_search}.get(fault, rules.p_follow)
    lose = rules.p_follow if fault == "soon lost" else rules.p_lose
    if state == State.SEARCH:
        best = int(np.argmax(reach > search) if fault == "first" else np.argmax(reach))
        if reach[best] > search or (fault in ("even", "even search") and reach[best] == search):
            before = {"been there": best, "as it was": visited, "no -1": max(best - 1, 0)}
            return State.FOLLOW, best, before.get(fault, best - 1)
        if fault == "best all the same":
            return State.LOST, best, best - 1
        stays = {"searches on": State.SEARCH, "searches blindly": State.DEAD_RECKONING}
        return stays.get(fault, State.LOST), active, visited
    if state == State.DEAD_RECKONING:
        if fault == "no end":
            return state, active, visited
        if fault == "moves on blindly":
            active, visited = move_on(active, visited, reach, overlap, at, rules)
        late = waited > rules.timeout and fault != "never lost"
        late |= waited == rules.timeout and fault == "impatient"
        if fault == "done blindly" and at and active == len(reach) - 1:
            return State.DONE, active, visited
        trusted = reach.max() if fault == "any" else reach[active]
        above = trusted > follow or (fault in ("even", "even back") and trusted == follow)
        if fault == "moves on coming back" and above:
            active, visited = move_on(active, visited, reach, overlap, at, rules)
        if fault == "resets" and late and not above:
            return State.LOST, -1, -1
        back = above and not (late and fault == "lost first")
        here = State.LOST if late else State.DEAD_RECKONING
        return State.FOLLOW if back else here, active, visited
    last = active == len(reach) - 1
    close = overlap[active] > rules.visited
    if fault == "times out" and waited > rules.timeout and not (at and last):
        return State.LOST, active, visited
    if at and last and fault == "moves at the end":
        return State.DONE, *move_on(active, visited, reach, overlap, at, rules)
    done = {"any anchor": at, "last is enough": last, "never done": False, "done after": False}
    done |= {"close or at": last and (at or close), "close": last and close}
    if fault == "not alone":
        last &= len(reach) > 1
    if done.get(fault, at and last):
        return State.DONE, active, visited
    ahead, seen = move_on(active, visited, reach, overlap, at, rules)
    if fault == "done after" and at and ahead == len(reach) - 1:
        return State.DONE, ahead, seen
    if fault == "stands":
        ahead, seen = active, visited
    trusted = reach[active if fault == "old reach" else ahead] > lose
    trusted |= fault in ("even", "even follow") and reach[ahead] == lose
    if fault == "moved":
        trusted |= ahead > active
    if fault == "forgets" and not trusted:
        ahead, seen = active, visited
    here = State.FOLLOW if trusted or fault == "trusts" else State.DEAD_RECKONING
    return here, ahead, seen


_FAULTS = {
    "dead reckoning must end, too: in FOLLOW, or in LOST": "no end",
    "a robot that is done keeps its anchors: DONE before move_on": "moves at the end",
    "RE of exactly a threshold is not above it": "even",
    "in Search RE of exactly rules.p_search is not above it": "even search",
    "in Follow RE of exactly rules.p_lose is not above it": "even follow",
    "in dead reckoning RE of exactly rules.p_follow is not above it": "even back",
    "visited is the anchor before the one that was found, not what went in": "as it was",
    "before the first anchor there is none: where Search finds anchor 0, visited is -1": "no -1",
    "dead reckoning is left above rules.p_follow, not above rules.p_search": "search's",
    "dead reckoning is left when the active anchor can be reached, not any anchor": "any",
    "in dead reckoning the robot cannot be DONE: first it must see its anchor again": (
        "done blindly"
    ),
    "back in Follow the active anchor stays for this step; do not call move_on": (
        "moves on coming back"
    ),
    "a robot that becomes lost keeps active and visited as they were": "resets",
    "waited counts in dead reckoning alone; in Follow no time is up here": "times out",
    "a high overlap with the last anchor is not enough to be DONE, and none is needed: at": "close",
    "a high overlap with the last anchor is not enough to be DONE: at": "close or at",
    "a path may have a single anchor, which is the last one, too": "not alone",
    "a robot that found no anchor keeps active and visited as they were": "best all the same",
    "Search takes the anchor with the highest RE, not the first above the threshold": "first",
    "the anchor that was found is still ahead; visited is the one before it": "been there",
    "a robot that finds no anchor gives up: LOST": "searches on",
    "a robot that finds no anchor has no waypoint to drive to: LOST": "searches blindly",
    "Search has a threshold of its own, rules.p_search": "follow's threshold",
    "Follow is left below rules.p_lose, not below rules.p_follow": "soon lost",
    "dead reckoning is left above rules.p_follow, not above rules.p_lose": "soon back",
    "in dead reckoning the active anchor stays; do not call move_on": "moves on blindly",
    "after more than rules.timeout seconds of dead reckoning the robot is LOST": "never lost",
    "after exactly rules.timeout seconds the robot is not lost yet; it takes more": "impatient",
    "a robot that can reach the active anchor again is not lost, however long it took": (
        "lost first"
    ),
    "at an anchor that is not the last one the robot is not done": "any anchor",
    "check for DONE before move_on; at belongs to the anchor that was active before it, and yours "
    "stops one anchor early": "done after",
    "a robot that drives to the last anchor is not there yet: at": "last is enough",
    "at the last anchor the robot is DONE": "never done",
    "in Follow the active anchor must move on: move_on": "stands",
    "use the RE of the anchor that is active after move_on": "old reach",
    "a robot that has moved on must be able to reach the new anchor, too: its RE decides": "moved",
    "keep what move_on returned, in dead reckoning too": "forgets",
    "Follow must notice when the active anchor cannot be reached: DEAD_RECKONING": "trusts",
}


def _step(why: str, state: State, seen: Case, waited: float = 0.0, at: bool | None = None) -> Case:
    active, visited, reach, overlap, here, rules = seen[1]
    here = here if at is None else at
    return why, (state, active, visited, reach, overlap, here, waited, rules)


def _sought(reach: Sequence[float], rules: FollowerSettings = RULES) -> Case:
    return observe("", -1, -1, reach, [0.3] * len(reach), False, rules)


_LOW, _HALF, _HIGH = (0.3, 0.35, 0.97, 0.4), (0.3, 0.7, 0.5, 0.2), (0.3, 0.96, 0.5, 0.2)
_BESIDE, _CLOSE = (0.3, 0.7, 0.65, 0.1), (0.3, 0.85, 0.65, 0.1)
_EXACT, _EVEN = (0.3, 0.4, 0.5, 0.2), (0.3, 0.92, 0.5, 0.2)
_SURE, _ARRIVED = (0.3, 0.9, 0.99, 0.95), (0.1, 0.4, 0.85, 0.65)
_S, _F, _D = State.SEARCH, State.FOLLOW, State.DEAD_RECKONING
_CASES = [
    _step("Search, two anchors reachable", _S, _sought((0.6, 0.93, 0.97, 0.4))),
    _step("Search, RE of exactly p_search", _S, _sought((0.6, 0.92, 0.5, 0.4))),
    _step("Follow, RE(active) of exactly p_lose", _F, observe("", 1, 0, _EXACT, _BESIDE)),
    _step("Dead reckoning, RE of exactly p_follow", _D, observe("", 1, 0, _EVEN, _BESIDE), 1.0),
    _step("Search, none reachable", _S, _sought((0.6, 0.9, 0.5, 0.4))),
    _step("Search, the last one reachable, at", _S, _sought((0.6, 0.5, 0.4, 0.95)), 0.0, True),
    _step("Search, other rules", _S, _sought((0.1, 0.75, 0.5), OTHER_RULES)),
    _step("Follow, under way", _F, OBSERVATIONS["way"]),
    _step("Follow, the next anchor reachable and near", _F, OBSERVATIONS["next"]),
    _step("Follow, at an anchor", _F, OBSERVATIONS["at"]),
    _step("Follow, at the last anchor but one", _F, observe("", 2, 1, _SURE, _ARRIVED, True)),
    _step(
        "Follow, only the next one high",
        _F,
        observe("", 1, 0, (0.9, 0.3, 0.97), (0.4, 0.5, 0.7)),
    ),
    _step("Follow, RE(active) middling", _F, observe("", 1, 0, _HALF, _BESIDE)),
    _step("Follow, RE(active) low", _F, observe("", 1, 0, (0.3, 0.35, 0.5, 0.4), _BESIDE)),
    _step("Follow, the next one low", _F, observe("", 1, 0, (0.9, 0.99, 0.2, 0.1), _CLOSE)),
    _step(
        "Follow, other rules",
        _F,
        observe("", 1, 0, _LOW, (0.3, 0.45, 0.3, 0.1), rules=OTHER_RULES),
    ),
    _step("Follow, the last anchor, not there yet", _F, OBSERVATIONS["end"], at=False),
    _step("Follow, at the last anchor", _F, OBSERVATIONS["end"]),
    _step("Follow, at the only anchor", _F, OBSERVATIONS["one"]),
    _step("Follow, waited for long", _F, OBSERVATIONS["way"], 9.0),
    _step("Dead reckoning, RE(active) low", _D, observe("", 1, 0, _LOW, _BESIDE), 1.0),
    _step("Dead reckoning, RE(active) middling", _D, observe("", 1, 0, _HALF, _BESIDE), 1.0),
    _step("Dead reckoning, RE(active) high", _D, observe("", 1, 0, _HIGH, _BESIDE), 1.0),
    _step("Dead reckoning for exactly the timeout", _D, observe("", 1, 0, _LOW, _BESIDE), 4.0),
    _step("Dead reckoning for long, RE(active) low", _D, observe("", 1, 0, _LOW, _BESIDE), 4.1),
    _step("Dead reckoning for long, RE(active) high", _D, observe("", 1, 0, _HIGH, _BESIDE), 4.1),
    _step(
        "Dead reckoning for long, other rules",
        _D,
        observe("", 1, 0, _LOW, _BESIDE, rules=OTHER_RULES),
        2.1,
    ),
]


@cache
def _random_steps(count: int, seed: int) -> dict[str, tuple[Any, ...]]:
    """Steps of all kinds from every state."""
    rng, steps = np.random.default_rng(seed), {}
    for number, seen in enumerate(random_observations(count, seed).values()):
        active, visited, reach, overlap, at, rules = seen
        state = (_S, _F, _F, _D)[rng.integers(4)]
        if rng.random() < 0.5:  # the active anchor in the middle, or exactly at a threshold
            reach[active] = (0.5, rules.p_lose, rules.p_follow)[rng.integers(3)]
        if state == _S and rng.random() < 0.3:
            reach[:] = np.minimum(reach, rules.p_search)
        if state == _S:
            active, visited, at = -1, -1, False
        waited = float((0.0, rules.timeout, rules.timeout + 0.1)[rng.integers(3)])
        case = (state, active, visited, reach, overlap, at, waited, rules)
        steps[f"step {number}, {state.name}"] = case
    return steps


@check(transition, _CASES[4][1])
def check_transition(student: Callable[..., Any]) -> None:
    """Searching, following, dead reckoning, their ends, exact thresholds, and 90 at random."""
    faults = with_faults(_changed, _FAULTS)
    compare(
        "transition",
        student,
        dict(_CASES) | _random_steps(90, 2),
        transition,
        faults,
        invoke=INVOKE,
        form=state_and_anchors,
        difference=explained,
        broken=changed_wrongly,
    )
