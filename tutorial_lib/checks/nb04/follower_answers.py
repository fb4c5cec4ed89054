"""Answers of a follower's rules, for the checks of notebook 04."""

from __future__ import annotations

from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import hinting, parts
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.topology.following.transitions import State

INVOKE = hinting(IndexError, "after the last anchor there is none: stay there")
"""How students' rules are called."""


def two_anchors(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401 - students'
    """The active and the last visited anchor, from an answer of the right form."""
    words = "active, visited"
    answer = parts(what, got, 2, f"return {words}")
    _demand(all(map(_whole, answer)), what, got, words)
    return tuple(int(number) for number in answer)


def state_and_anchors(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401
    """State and anchors, from an answer of the right form; the state alone at the end.

    Once the robot is lost or done, its anchors no longer matter.
    """
    words = "state, active, visited"
    answer = parts(what, got, 3, f"return {words}")
    _demand(all(map(_whole, answer)) and answer[0] in list(State), what, got, words)
    state = State(answer[0])
    return (state,) if state in (State.LOST, State.DONE) else (state, *map(int, answer[1:]))


def spoken(got: tuple[int, ...], want: tuple[int, ...], *_: object) -> str:
    """Both answers in words."""
    mine, right = (
        ", ".join(part.name if isinstance(part, State) else str(part) for part in answer)
        for answer in (got, want)
    )
    return f"{mine} came back; {right} is right"


def _whole(number: object) -> bool:
    return isinstance(number, int | np.integer)


def _demand(fits: bool, what: str, got: object, words: str) -> None:
    if not fits:
        raise WrongAnswer(f"{what}: {got} came back; return {words}: a State and whole numbers")
