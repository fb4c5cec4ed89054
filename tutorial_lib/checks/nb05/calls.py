"""Calls of students' functions whose errors are explained, for the checks of notebook 05."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from typing import Any

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import WrongAnswer

_USUAL: dict[type[Exception], str] = {
    IndexError: "an index lies beyond the end of an array; do not look there",
    TypeError: "something is not of the type that you use it as; compare with the docstring",
    ValueError: "do the shapes fit, and is there anything to choose from?",
    KeyError: "there is no such key",
    NameError: "is a name misspelt, or set in one branch only?",
    AttributeError: "is a name misspelt? Compare with the docstring",
    ZeroDivisionError: "something is divided by zero",
    RecursionError: "the function calls itself for ever",
}


def explained(hints: Mapping[type[Exception], str] = {}) -> Callable[..., Any]:
    """A way to call a student's function that says what an error in it may mean.

    Args:
        hints: for kinds of errors, what to say of them in this exercise.
    """

    def invoke(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        try:
            return call(student, *arguments)
        except (WrongAnswer, NotImplementedError):
            raise
        except Exception as error:
            raise WrongAnswer(f"{what}: {in_words(error, hints)}") from None

    return invoke


def in_words(error: Exception, hints: Mapping[type[Exception], str]) -> str:
    """An error, the line that raised it, and what it may mean."""
    known = {**_USUAL, **hints}
    other = "try this case by hand, and print what you have just before that line"
    hint = next((known[kind] for kind in type(error).__mro__ if kind in known), other)
    line = traceback.extract_tb(error.__traceback__)[-1].line or ""
    place = f" (in: {line.strip()})" if line else ""
    return f"{type(error).__name__}, {error}{place}; {hint}"
