"""Answers of a follower's rules, for the checks of notebook 04."""

from __future__ import annotations

from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.nb04.forms import calling
from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import FollowerSettings, State

INVOKE = calling(
    {
        IndexError: "after the last anchor there is none: stay there",
        ValueError: "there may be a single anchor on the path",
        AttributeError: "state is one of State.SEARCH, State.FOLLOW, ...; rules has the thresholds",
        TypeError: "active and visited are whole numbers, reach and overlap arrays (L,)",
        NameError: "is it spelt right, and is its cell run?",
    }
)
"""How students' rules are called."""


def two_anchors(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401 - students'
    """The active and the last visited anchor, from an answer of the right form."""
    words = "active, visited"
    answer = parts(what, got, 2, f"return {words}")
    _demand(all(map(whole, answer)), what, got, f"{words}: two whole numbers")
    return tuple(int(number) for number in answer)


def state_and_anchors(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401
    """State and anchors, from an answer of the right form."""
    words = "state, active, visited"
    answer = parts(what, got, 3, f"return {words}")
    fits = all(map(whole, answer)) and int(answer[0]) in list(State)
    _demand(fits, what, got, f"{words}: a State and whole numbers")
    return (State(int(answer[0])), *map(int, answer[1:]))


def explained(got: tuple[int, ...], want: tuple[int, ...], *case: Any) -> str:  # noqa: ANN401
    """Both answers in words, and why the right one is right."""
    mine, right = map(spoken, (got, want))
    why = _why_moved(*case) if len(want) == 2 else _why_state(*case)
    return f"{mine} came back, {right} is right: {why}"


def moved_wrongly(got: tuple[int, ...], want: tuple[int, ...], *case: Any) -> str:  # noqa: ANN401
    """Which part of the rule of `move_on` an answer breaks."""
    if got[1] != want[1]:
        at = "at makes the active anchor the one last visited, unless a later one was"
        closest = "of the three anchors around the active one the closest counts, by its overlap"
        return at if case[4] else f"{closest}, if that is above rules.visited; never an earlier one"
    if got[0] > want[0]:
        return (
            "stay: advance by one at most, if the next one is both reachable and near, or if the "
            "active one was visited"
        )
    if want[1] >= case[0]:
        return "once the active anchor was visited, now or earlier, the robot moves on"
    return "the next anchor is above both of the thresholds in rules: that is enough to move on"


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


def spoken(answer: tuple[int, ...]) -> str:
    """An answer in words."""
    names = ("active", "visited")[-len(answer) :] if len(answer) == 2 else ("", "active", "visited")
    return ", ".join(
        part.name if isinstance(part, State) else f"{name} {part}"
        for name, part in zip(names, answer, strict=True)
    )


def _why_moved(
    active: int, visited: int, reach: Array, overlap: Array, at: bool, rules: FollowerSettings
) -> str:
    """What moves a follower on, or does not."""
    last = len(reach) - 1
    near = range(max(active - 1, 0), min(active + 1, last) + 1)
    closest = max(near, key=lambda place: overlap[place])
    above = "above" if overlap[closest] > rules.visited else "not above"
    words = f"of {near[0]} to {near[-1]} the closest is {closest}, its overlap {overlap[closest]:g}"
    words += f" is {above} rules.visited = {rules.visited:g}"
    words += f"; the robot is at {active}" if at else ""
    if active == last:
        return f"{words}; {active} is the last anchor, so it stays active"
    words += f"; the next one has RE {reach[active + 1]:g} (rules.p_follow = {rules.p_follow:g})"
    return f"{words} and overlap {overlap[active + 1]:g} (rules.near = {rules.near:g})"


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
    why = _why_moved(active, visited, reach, overlap, at, rules)
    return f"in Follow, {why}; then RE of the new active anchor decides, against rules.p_lose"


def whole(number: object) -> bool:
    """Whether an answer is a whole number."""
    return isinstance(number, int | np.integer) and not isinstance(number, bool)


def _demand(fits: bool, what: str, got: object, words: str) -> None:
    if not fits:
        raise WrongAnswer(f"{what}: {got} came back; return {words}")
