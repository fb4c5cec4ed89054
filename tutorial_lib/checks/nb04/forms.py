"""How answers to notebook 04 are called for, and what form they must have."""

from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, kind
from tutorial_lib.checks.framework import answers
from tutorial_lib.checks.framework.answers import as_floats, returned
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.mapping.vertices import Indices

_SAID = {
    "unexpected keyword": "the arguments are given in the order of the docstring",
}
"""For words of Python's own message, what they mean here."""
calling = partial(answers.calling, said=_SAID)
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


def frame_indices(what: str, got: Any, *_: object) -> Indices:  # noqa: ANN401
    """The indices of frames (A,) that a student returned."""
    got = returned(what, got)
    if not isinstance(got, np.ndarray | list | tuple):
        words = "return the indices of the frames, an array or a list"
        raise WrongAnswer(f"{what}: {kind(got)} came back; {words}")
    try:
        numbers = as_floats(got)
    except (TypeError, ValueError):
        words = "return whole numbers, the indices of the frames"
        raise WrongAnswer(f"{what}: the {type(got).__name__} holds other things; {words}") from None
    if np.asarray(got).dtype == bool:
        words = "return the indices, as np.flatnonzero gives them"
        raise WrongAnswer(f"{what}: these are True and False; {words}")
    if numbers.ndim != 1:
        raise WrongAnswer(f"{what}: shape {numbers.shape}, but a flat list of frames is needed")
    if not np.isfinite(numbers).all() or (numbers % 1).any():
        raise WrongAnswer(f"{what}: return whole numbers, the indices of frames")
    if numbers.size and np.asarray(got).dtype.kind == "f":
        words = "these are floats, which select nothing from an array; return whole numbers, int"
        raise WrongAnswer(f"{what}: {words}")
    return numbers.astype(np.intp)


def whole(number: object) -> bool:
    """Whether an answer is a whole number."""
    return isinstance(number, int | np.integer) and not isinstance(number, bool)


def demand(fits: bool, what: str, got: object, words: str) -> None:
    """Refuse an answer that does not fit; `words` says what to return."""
    if not fits:
        raise WrongAnswer(f"{what}: {got} came back; return {words}")


def came_back(got: tuple[int, ...], want: tuple[int, ...], why: str) -> str:
    """Two answers in words, the state and the anchors or these alone, and why one is right."""
    return f"{_spoken(got)} came back, {_spoken(want)} is right: {why}"


def _spoken(answer: tuple[int, ...]) -> str:
    *states, active, visited = answer
    return ", ".join([*(State(s).name for s in states), f"active {active}", f"visited {visited}"])
