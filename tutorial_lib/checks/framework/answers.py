"""Answers to several cases at once: the mistake that explains all of them is named."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer


def called(student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401 - students'
    """As `check.call`, for arguments in which not every number is one."""
    before = [np.array(argument, copy=True) for argument in arguments]
    answer = student(*arguments)
    for number, (old, new) in enumerate(zip(before, arguments, strict=True), 1):
        if not np.array_equal(old, new, equal_nan=old.dtype.kind == "f"):
            raise WrongAnswer(f"your function changes its argument {number}; make a new array")
    return answer


def mask(what: str, got: object, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """A student's answer of True and False, if it has the right form.

    Raises:
        WrongAnswer: when it has not.
    """
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    if not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: a {type(got).__name__} came back; return a numpy array")
    if got.dtype != bool:
        raise WrongAnswer(f"{what}: return True or False for each, not numbers ({got.dtype})")
    if got.shape != shape:
        raise WrongAnswer(f"{what}: shape {got.shape}, but {shape} is needed")
    return got


def explained(
    name: str,
    cases: Mapping[str, Sequence[Any]],
    answers: Sequence[Any],
    right: Callable[..., Any],
    faults: Mapping[str, Callable[..., Any]],
    picture: NDArray[np.uint8] | None = None,
) -> None:
    """Demand the right answer to all cases.

    Args:
        name: of the exercise.
        cases: by what they are like, the arguments.
        answers: of the student, as many.
        right: gives the right one.
        faults: by what to say of it, functions that answer as a known mistake does; one that
            explains all of the answers is named.
        picture: target and yours.

    Raises:
        WrongAnswer: when an answer is wrong.
    """
    for (why, case), got in zip(cases.items(), answers, strict=True):
        want = right(*case)
        if np.array_equal(got, want):
            continue
        for words, fault in faults.items():
            if all(_same(fault, c, a) for c, a in zip(cases.values(), answers, strict=True)):
                raise WrongAnswer(f"{name}, {why}: {words}", picture)
        raise WrongAnswer(f"{name}, {why}: {_apart(np.asarray(got), np.asarray(want))}", picture)


def _same(fault: Callable[..., Any], case: Sequence[Any], answer: object) -> bool:
    """Whether a mistake gives this answer."""
    try:
        return np.array_equal(fault(*case), np.asarray(answer))
    except (IndexError, ValueError):
        return False


def _apart(got: NDArray, want: NDArray) -> str:
    if not want.shape:
        return f"{got} came back; {want} is right"
    place = tuple(int(i) for i in np.argwhere(got != want)[0])
    return f"{got[place]} at {place if len(place) > 1 else place[0]}, but {want[place]} is right"
