"""How answers to notebook 03 are called for, and what form they must have."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework import answers
from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.geometry import Array

_SAID = {
    "truth value": "A table of true and false is joined to another by &, | and ~, not by and, or "
    "and not; and an if wants a single value",
    "0-dimensional": "Here an array stands where one number belongs; use numpy's functions, not "
    "math's",
    "length-1": "Here an array stands where one number belongs; use numpy's functions, not math's",
}
"""For words of Python's own message, what they mean here."""
calling = partial(answers.calling, said=_SAID)


def one_number(what: str, got: Any, meaning: str) -> float:  # noqa: ANN401 - students' answers
    """An answer that is a single number.

    Args:
        what: was computed.
        got: the answer.
        meaning: of the number, for the message.

    Raises:
        WrongAnswer: when it is anything else.
    """
    got = returned(what, got)
    if isinstance(got, np.ndarray) and got.shape:
        words = f"an array of shape {got.shape} came back"
        raise WrongAnswer(f"{what}: {words}; return one number, {meaning}")
    if not isinstance(got, int | float | np.number | np.ndarray) or np.iscomplexobj(got):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return {meaning}, a number")
    try:
        return float(got)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what}: {got} came back; return {meaning}, a number") from None


def vector(what: str, got: Any, length: int, meaning: str) -> Array:  # noqa: ANN401
    """An answer that is an array of so many numbers.

    Args:
        what: was computed.
        got: the answer.
        length: that it must have.
        meaning: of the numbers, for the message.

    Raises:
        WrongAnswer: when it is anything else.
    """
    got = returned(what, got)
    if not isinstance(got, np.ndarray):
        words = f"{kind(got)} came back; return {meaning}"
        raise WrongAnswer(f"{what}: {words}, a numpy array of shape ({length},)")
    if got.shape != (length,):
        words = f"an array of shape {got.shape} came back; return {meaning}"
        raise WrongAnswer(f"{what}: {words}, an array of shape ({length},)")
    if got.dtype.kind not in "bifu":
        raise WrongAnswer(f"{what}: the array holds {got.dtype}; return numbers, {meaning}")
    return got.astype(float)
