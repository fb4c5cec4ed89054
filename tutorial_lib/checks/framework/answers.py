"""Calls of students' functions, and what form their answers must have."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.explanation import explained
from tutorial_lib.geometry import Array

_COPIED = (np.ndarray, list, nx.Graph)


def call(student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401 - whatever students return
    """Call a student's function, and demand that it leaves its arguments alone.

    It gets copies of arrays, lists and graphs: what it changes does not spoil the next case.

    Raises:
        WrongAnswer: when an argument was changed.
    """
    given = [copy.deepcopy(a) if isinstance(a, _COPIED) else a for a in arguments]
    before = [np.array(argument, copy=True) for argument in arguments]
    answer = student(*given)
    for number, (old, new) in enumerate(zip(before, given, strict=True), 1):
        if not np.array_equal(old, new, equal_nan=old.dtype.kind == "f"):
            raise WrongAnswer(f"your function changes its argument {number}; make a new array")
    return answer


def calling(
    hints: Mapping[type[Exception], str] | None = None, said: Mapping[str, str] | None = None
) -> Callable[..., Any]:
    """A way to call a student's function that explains its errors.

    Args:
        hints: what to say of kinds of errors in this exercise.
        said: what words of Python's own message mean here; they go first.
    """

    def invoke(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        try:
            with np.errstate(all="ignore"):
                return call(student, *arguments)
        except (WrongAnswer, NotImplementedError):
            raise
        except Exception as error:
            raise WrongAnswer(f"{what}: {explained(error, hints, said)}") from error

    return invoke


def beside(run: Callable[..., Any]) -> Callable[..., Any]:
    """A way to call a function of the library, with the student's, where the student's runs.

    For arguments that cannot be sent to another process, as a network that is trained.
    """

    def invoke(student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        elsewhere = getattr(student, "run_beside", None)  # of marking's stand-in
        return elsewhere(run, *arguments) if elsewhere else run(student, *arguments)

    return invoke


def returned(what: str, got: Any) -> Any:  # noqa: ANN401 - whatever students return
    """An answer that is not None.

    Raises:
        WrongAnswer: when it is.
    """
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    return got


def parts(what: str, got: object, count: int, words: str) -> list[Any]:
    """The `count` parts of an answer; `words` says what to return.

    Raises:
        WrongAnswer: when it has not so many.
    """
    got = returned(what, got)
    if not isinstance(got, tuple | list) or len(got) != count:
        raise WrongAnswer(f"{what}: {words}")
    return list(got)


def numbers(what: str, got: object, shape: tuple[int, ...]) -> Array:
    """An answer as an array of this shape, or as a number if the shape is ().

    Raises:
        WrongAnswer: when it is none.
    """
    got = returned(what, got)
    kind = type(got).__name__
    if shape and not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: a {kind} came back; return a numpy array")
    try:
        if isinstance(got, str):
            raise TypeError
        values = np.asarray(got, dtype=float)
    except (TypeError, ValueError):
        words = "is no array of numbers; return an array" if shape else "is no number; return one"
        raise WrongAnswer(f"{what}: a {kind} {words}") from None
    if values.shape != shape:
        raise WrongAnswer(f"{what}: shape {values.shape}, but {shape} is needed")
    return values


def mask(what: str, got: object, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """An answer of True and False, as an array of this shape.

    Raises:
        WrongAnswer: when it is none.
    """
    got = returned(what, got)
    if not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: a {type(got).__name__} came back; return a numpy array")
    if got.dtype != bool:
        raise WrongAnswer(f"{what}: return True or False for each, not numbers ({got.dtype})")
    if got.shape != shape:
        raise WrongAnswer(f"{what}: shape {got.shape}, but {shape} is needed")
    return got
