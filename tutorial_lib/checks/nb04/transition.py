"""The check of the follower's state machine, in notebook 04."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import exercise, parts
from tutorial_lib.checks.nb04.forms import INVOKE, came_back, demand, whole
from tutorial_lib.checks.nb04.move_on import move_on, why_moved
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
    """State, active and last visited anchor after one observation; see the exercise."""
    last = len(reach) - 1
    if state == State.SEARCH:
        best = int(np.argmax(reach))
        if reach[best] > rules.p_search:
            return State.FOLLOW, best, best - 1
        return State.LOST, active, visited
    if state == State.DEAD_RECKONING:
        if reach[active] > rules.p_follow:
            return State.FOLLOW, active, visited
        return State.LOST if waited > rules.timeout else state, active, visited
    if at and active == last:
        return State.DONE, active, visited
    active, visited = move_on(active, visited, reach, overlap, at, rules)
    follows = reach[active] > rules.p_lose
    return State.FOLLOW if follows else State.DEAD_RECKONING, active, visited


def _step(state: State, seen: Case, waited: float = 0.0, at: bool | None = None) -> tuple[Any, ...]:
    """A case: an observation in a state."""
    *before, here, rules = seen
    return state, *before, here if at is None else at, waited, rules


def _sought(reach: Sequence[float], rules: FollowerSettings = RULES) -> Case:
    return observe(-1, -1, reach, [0.3] * len(reach), False, rules)


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
        seen = active, visited, reach, overlap, at, rules
        steps[f"step {number}, {state.name}"] = _step(state, seen, waited)
    return steps


_LOW, _HALF, _HIGH = (0.3, 0.35, 0.97, 0.4), (0.3, 0.7, 0.5, 0.2), (0.3, 0.96, 0.5, 0.2)
_BESIDE, _CLOSE = (0.3, 0.7, 0.65, 0.1), (0.3, 0.85, 0.65, 0.1)
_EXACT, _EVEN = (0.3, 0.4, 0.5, 0.2), (0.3, 0.92, 0.5, 0.2)
_SURE, _ARRIVED = (0.3, 0.9, 0.99, 0.95), (0.1, 0.4, 0.85, 0.65)
_S, _F, _D = State.SEARCH, State.FOLLOW, State.DEAD_RECKONING
CASES = {
    "Search, two anchors reachable": _step(_S, _sought((0.6, 0.93, 0.97, 0.4))),
    "Search, RE of exactly p_search": _step(_S, _sought((0.6, 0.92, 0.5, 0.4))),
    "Follow, RE(active) of exactly p_lose": _step(_F, observe(1, 0, _EXACT, _BESIDE)),
    "Dead reckoning, RE of exactly p_follow": _step(_D, observe(1, 0, _EVEN, _BESIDE), 1.0),
    "Search, none reachable": _step(_S, _sought((0.6, 0.9, 0.5, 0.4))),
    "Search, the last one reachable, at": _step(_S, _sought((0.6, 0.5, 0.4, 0.95)), 0.0, True),
    "Search, other rules": _step(_S, _sought((0.1, 0.75, 0.5), OTHER_RULES)),
    "Follow, under way": _step(_F, OBSERVATIONS["under way"]),
    "Follow, the next anchor reachable and near": _step(
        _F, OBSERVATIONS["the next one reachable and near"]
    ),
    "Follow, at an anchor": _step(_F, OBSERVATIONS["at the active anchor, turned aside"]),
    "Follow, at the last anchor but one": _step(_F, observe(2, 1, _SURE, _ARRIVED, True)),
    "Follow, only the next one high": _step(_F, observe(1, 0, (0.9, 0.3, 0.97), (0.4, 0.5, 0.7))),
    "Follow, RE(active) middling": _step(_F, observe(1, 0, _HALF, _BESIDE)),
    "Follow, RE(active) low": _step(_F, observe(1, 0, (0.3, 0.35, 0.5, 0.4), _BESIDE)),
    "Follow, the next one low": _step(_F, observe(1, 0, (0.9, 0.99, 0.2, 0.1), _CLOSE)),
    "Follow, other rules": _step(_F, observe(1, 0, _LOW, (0.3, 0.45, 0.3, 0.1), rules=OTHER_RULES)),
    "Follow, the last anchor, not there yet": _step(
        _F, OBSERVATIONS["at the last anchor"], at=False
    ),
    "Follow, at the last anchor": _step(_F, OBSERVATIONS["at the last anchor"]),
    "Follow, at the only anchor": _step(_F, OBSERVATIONS["one anchor alone, at it"]),
    "Follow, waited for long": _step(_F, OBSERVATIONS["under way"], 9.0),
    "Dead reckoning, RE(active) low": _step(_D, observe(1, 0, _LOW, _BESIDE), 1.0),
    "Dead reckoning, RE(active) middling": _step(_D, observe(1, 0, _HALF, _BESIDE), 1.0),
    "Dead reckoning, RE(active) high": _step(_D, observe(1, 0, _HIGH, _BESIDE), 1.0),
    "Dead reckoning, at the last anchor, RE high": _step(
        _D, observe(3, 2, (0.2, 0.3, 0.6, 0.97), _ARRIVED, True), 1.0
    ),
    "Dead reckoning for exactly the timeout": _step(_D, observe(1, 0, _LOW, _BESIDE), 4.0),
    "Dead reckoning for long, RE(active) low": _step(_D, observe(1, 0, _LOW, _BESIDE), 4.1),
    "Dead reckoning for long, RE(active) high": _step(_D, observe(1, 0, _HIGH, _BESIDE), 4.1),
    "Dead reckoning for long, other rules": _step(
        _D, observe(1, 0, _LOW, _BESIDE, rules=OTHER_RULES), 2.1
    ),
    **_random_steps(90, 2),
}
MISTAKES = """
dead reckoning must end, too: in FOLLOW, or in LOST
    reach[active] > rules.p_follow -> False
    State.LOST if waited > rules.timeout else state -> state
dead reckoning leads to FOLLOW or LOST, at the last anchor as well; in Follow it's DONE
    return State.FOLLOW, active, visited
        -> return (State.DONE if at and active == last else State.FOLLOW), active, visited
a robot that is done keeps its anchors: DONE before move_on
    State.DONE, active, visited -> State.DONE, *move_on(active, visited, reach, overlap, at, rules)
RE of exactly a threshold is not above it
    > rules.p_search -> >= rules.p_search
    > rules.p_follow -> >= rules.p_follow
    > rules.p_lose -> >= rules.p_lose
in Search RE of exactly rules.p_search is not above it
    > rules.p_search -> >= rules.p_search
in Follow RE of exactly rules.p_lose is not above it
    > rules.p_lose -> >= rules.p_lose
in dead reckoning RE of exactly rules.p_follow is not above it
    > rules.p_follow -> >= rules.p_follow
visited is the anchor before the one that was found, not what went in
    best, best - 1 -> best, visited
before the first anchor there is none: where Search finds anchor 0, visited is -1
    best, best - 1 -> best, max(best - 1, 0)
dead reckoning is left above rules.p_follow, not above rules.p_search
    rules.p_follow -> rules.p_search
dead reckoning is left when the active anchor can be reached, not any anchor
    reach[active] > rules.p_follow -> reach.max() > rules.p_follow
in dead reckoning the robot cannot be DONE: first it must see its anchor again
    == State.DEAD_RECKONING: -> == State.DEAD_RECKONING and not (at and active == last):
back in Follow the active anchor stays for this step; do not call move_on
    State.FOLLOW, active, visited
        -> State.FOLLOW, *move_on(active, visited, reach, overlap, at, rules)
a robot that becomes lost keeps active and visited as they were
    return State.LOST if -> return (State.LOST, -1, -1) if
    else state, active, visited -> else (state, active, visited)
waited counts in dead reckoning alone; in Follow no time is up here
    if at and active == last: -> if (done := at and active == last) or waited > rules.timeout:
    return State.DONE, -> return State.DONE if done else State.LOST,
a high overlap with the last anchor is not enough to be DONE, and none is needed: at
    if at and -> if overlap[active] > rules.visited and
a high overlap with the last anchor is not enough to be DONE: at
    if at and -> if (at or overlap[active] > rules.visited) and
a path may have a single anchor, which is the last one, too
    active == last: -> active == last > 0:
a robot that found no anchor keeps active and visited as they were
    State.LOST, active, visited -> State.LOST, best, best - 1
Search takes the anchor with the highest RE, not the first above the threshold
    np.argmax(reach) -> np.argmax(reach > rules.p_search)
the anchor that was found is still ahead; visited is the one before it
    best, best - 1 -> best, best
a robot that finds no anchor gives up: LOST
    State.LOST, active, visited -> State.SEARCH, active, visited
a robot that finds no anchor has no waypoint to drive to: LOST
    State.LOST, active, visited -> State.DEAD_RECKONING, active, visited
Search has a threshold of its own, rules.p_search
    rules.p_search -> rules.p_follow
Follow is left below rules.p_lose, not below rules.p_follow
    rules.p_lose -> rules.p_follow
dead reckoning is left above rules.p_follow, not above rules.p_lose
    rules.p_follow -> rules.p_lose
in dead reckoning the active anchor stays; do not call move_on
    == State.DEAD_RECKONING:
        -> == State.DEAD_RECKONING and (now := move_on(active, visited, reach, overlap, at, rules)):
    reach[active] > rules.p_follow -> reach[now[0]] > rules.p_follow
    State.FOLLOW, active, visited -> State.FOLLOW, *now
    else state, active, visited -> else state, *now
after more than rules.timeout seconds of dead reckoning the robot is LOST
    waited > rules.timeout -> False
after exactly rules.timeout seconds the robot is not lost yet; it takes more
    waited > rules.timeout -> waited >= rules.timeout
a robot that can reach the active anchor again is not lost, however long it took
    rules.p_follow: -> rules.p_follow and waited <= rules.timeout:
at an anchor that is not the last one the robot is not done
    at and active == last -> at
check for DONE before move_on; at belongs to the anchor that was active before it, and yours stops
one anchor early
    if at and active == last: -> if False:
    State.FOLLOW if follows -> State.DONE if at and active == last else State.FOLLOW if follows
a robot that drives to the last anchor is not there yet: at
    at and active == last -> active == last
at the last anchor the robot is DONE
    at and active == last -> False
in Follow the active anchor must move on: move_on
    active, visited = move_on(active, visited, reach, overlap, at, rules) -> pass
use the RE of the anchor that is active after move_on
    active, visited = move_on -> before = active; active, visited = move_on
    follows = reach[active] -> follows = reach[before]
a robot that has moved on must be able to reach the new anchor, too: its RE decides
    active, visited = move_on -> before = active; active, visited = move_on
    follows = -> follows = active > before or
keep what move_on returned, in dead reckoning too
    active, visited = move_on -> before = active, visited; active, visited = move_on
    State.DEAD_RECKONING, active, visited
        -> State.DEAD_RECKONING, *((active, visited) if follows else before)
Follow must notice when the active anchor cannot be reached: DEAD_RECKONING
    reach[active] > rules.p_lose -> True
"""


def _formed(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401
    words = "state, active, visited"
    answer = parts(what, got, 3, f"return {words}")
    fits = all(map(whole, answer)) and int(answer[0]) in list(State)
    demand(fits, what, got, f"{words}: a State and whole numbers")
    return (State(int(answer[0])), *map(int, answer[1:]))


def _broken(got: tuple[int, ...], want: tuple[int, ...], *case: Any) -> str:  # noqa: ANN401
    """Which part of the rule an answer breaks."""
    state, active, _, reach, _, at = case[:6]
    if state == State.SEARCH:
        return (
            "in Search RE alone decides, in this step: above rules.p_search the best anchor is "
            "active, and visited the one before it; else the robot is LOST, with its anchors"
        )
    if state == State.DEAD_RECKONING:
        return (
            "dead reckoning goes over to FOLLOW above rules.p_follow, else to LOST after more "
            "than rules.timeout, else it goes on; its anchors stay"
        )
    if at and active == len(reach) - 1:
        return "in Follow, at the last anchor, the robot is DONE and keeps both anchors"
    if State.DONE in (got[0], want[0]):
        return "DONE takes both: the last anchor is active, and at is True; visited alone is not at"
    if got[1:] != want[1:]:
        return (
            "in Follow return the anchors that one call of move_on gives: active, visited, in this "
            "order, whether the robot goes on to FOLLOW or to DEAD_RECKONING"
        )
    return "in Follow RE of the new active anchor decides, FOLLOW only above rules.p_lose"


def _why_state(*case: Any) -> str:  # noqa: ANN401
    """What decides about the next state."""
    state, active, visited, reach, overlap, at, waited, rules = case
    if state == State.SEARCH:
        best = int(reach.argmax())
        words = f"in Search the best RE is {reach[best]:g}, of anchor {best}"
        return f"{words}; rules.p_search = {rules.p_search:g}"
    if state == State.DEAD_RECKONING:
        words = f"in dead reckoning for {waited:g} s (rules.timeout = {rules.timeout:g}), RE of "
        words += f"anchor {active} is {reach[active]:g}"
        return f"{words} (rules.p_follow = {rules.p_follow:g}); the anchors stay"
    if at and active == len(reach) - 1:
        return "in Follow, at the last anchor; active and visited stay"
    why = why_moved(active, visited, reach, overlap, at, rules)
    return f"in Follow, {why}; then RE of the new active anchor decides, against rules.p_lose"


check_transition = exercise(
    transition,
    CASES,
    MISTAKES,
    about="Searching, following, dead reckoning, their ends, exact thresholds, and 90 at random.",
    example=CASES["Search, none reachable"],
    invoke=INVOKE,
    form=_formed,
    difference=lambda got, want, *case: came_back(got, want, _why_state(*case)),
    broken=_broken,
)
