"""Calls that must leave sets, dictionaries and graphs alone, for the checks of notebook 09."""

import copy
from collections.abc import Callable, Mapping
from functools import partial
from inspect import signature
from typing import Any

from tutorial_lib.checks.engine import WrongAnswer, calling
from tutorial_lib.checks.framework.answers import returned, unchanged


def keeping(
    right: Callable[..., Any], words: str, hints: Mapping[type[Exception], str] | None = None
) -> Callable[..., Any]:
    """A way to call a student's function that demands that its arguments stay as they are.

    Args:
        right: the rule; its parameters name the arguments.
        words: what to do instead of changing one.
        hints: what to say of kinds of errors in this exercise.
    """
    names, call = list(signature(right).parameters), calling(hints)

    def invoke(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        given = copy.deepcopy(arguments)
        got = call(what, partial(student, *given))
        for name, old, new in zip(names, arguments, given, strict=False):
            if not unchanged(old, new):
                raise WrongAnswer(f"{what}: your function changes its argument {name}; {words}")
            if isinstance(new, set) and got is new:
                raise WrongAnswer(
                    f"{what}: what came back is your argument {name} itself; return a new set, "
                    "also where nothing changes"
                )
        return returned(what, got)

    return invoke
