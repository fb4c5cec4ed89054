"""Answers of a follower's rules, for the checks of notebook 04."""

from __future__ import annotations

from typing import Any

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.nb04.forms import came_back, demand, whole
from tutorial_lib.checks.nb04.move_on import why_moved
from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import FollowerSettings, State


def state_and_anchors(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401
    """State and anchors, from an answer of the right form."""
    words = "state, active, visited"
    answer = parts(what, got, 3, f"return {words}")
    fits = all(map(whole, answer)) and int(answer[0]) in list(State)
    demand(fits, what, got, f"{words}: a State and whole numbers")
    return (State(int(answer[0])), *map(int, answer[1:]))


def explained(got: tuple[int, ...], want: tuple[int, ...], *case: Any) -> str:  # noqa: ANN401
    """Both answers in words, and why the right one is right."""
    return came_back(got, want, _why_state(*case))


def changed_wrongly(got: tuple[int, ...], want: tuple[int, ...], *case: Any) -> str:  # noqa: ANN401
    """Which part of the rule of `transition` an answer breaks."""
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


def _why_state(
    state: State,
    active: int,
    visited: int,
    reach: Array,
    overlap: Array,
    at: bool,
    waited: float,
    rules: FollowerSettings,
) -> str:
    """What decides about the next state."""
    if state == State.SEARCH:
        best = int(reach.argmax())
        words = f"in Search the best RE is {reach[best]:g}, of anchor {best}"
        return f"{words}; rules.p_search = {rules.p_search:g}"
    if state == State.DEAD_RECKONING:
        words = f"in dead reckoning for {waited:g} s (rules.timeout = {rules.timeout:g}), RE of"
        words = f"{words} anchor {active} is {reach[active]:g}"
        return f"{words} (rules.p_follow = {rules.p_follow:g}); the anchors stay"
    if at and active == len(reach) - 1:
        return "in Follow, at the last anchor; active and visited stay"
    why = why_moved(active, visited, reach, overlap, at, rules)
    return f"in Follow, {why}; then RE of the new active anchor decides, against rules.p_lose"
