"""How answers to notebook 03 are called for, and what form they must have."""

from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, kind
from tutorial_lib.checks.framework import answers
from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.geometry import Array

_ONE = "Here an array stands where one number belongs; use numpy's functions, not math's"
_SAID = {
    "0-dimensional": _ONE,
    "length-1": _ONE,
}
"""For words of Python's own message, what they mean here."""
calling = partial(answers.calling, said=_SAID)


def one_number(what: str, got: Any, meaning: str) -> float:  # noqa: ANN401 - students' answers
    """An answer that is a single number; `meaning` says of what."""
    got = returned(what, got)
    if isinstance(got, np.ndarray) and got.shape:
        words = f"an array of shape {got.shape} came back; return one number, {meaning}"
        raise WrongAnswer(f"{what}: {words}")
    if not isinstance(got, int | float | np.number | np.ndarray) or np.iscomplexobj(got):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return {meaning}, a number")
    try:
        return float(got)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what}: {got} came back; return {meaning}, a number") from None


def vector(what: str, got: Any, length: int, meaning: str) -> Array:  # noqa: ANN401
    """An answer that is an array of so many numbers; `meaning` says of what."""
    got = returned(what, got)
    asked = f"came back; return {meaning}, a"
    if not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: {kind(got)} {asked} numpy array of shape ({length},)")
    if got.shape != (length,):
        words = f"an array of shape {got.shape} {asked}n array of shape ({length},)"
        raise WrongAnswer(f"{what}: {words}")
    if got.dtype.kind not in "bifu":
        raise WrongAnswer(f"{what}: the array holds {got.dtype}; return numbers, {meaning}")
    return got.astype(float)
