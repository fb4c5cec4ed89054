"""Calls that must leave sets, dictionaries and graphs alone, for the checks of notebook 09."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.explanation import explained


def keeping(words: str, hints: Mapping[type[Exception], str] | None = None) -> Callable[..., Any]:
    """A way to call a student's function that demands that its arguments stay as they are.

    Args:
        words: what to do instead of changing one.
        hints: what to say of kinds of errors in this exercise.
    """

    def invoke(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        given = copy.deepcopy(arguments)
        try:
            with np.errstate(all="ignore"):
                got = student(*given)
        except (WrongAnswer, NotImplementedError):
            raise
        except Exception as error:
            raise WrongAnswer(f"{what}: {explained(error, hints)}") from error
        for number, (old, new) in enumerate(zip(arguments, given, strict=True), 1):
            if _plain(old) != _plain(new):
                raise WrongAnswer(f"{what}: your function changes its argument {number}; {words}")
            if isinstance(new, set) and got is new:
                raise WrongAnswer(
                    f"{what}: what came back is your argument {number} itself; return a new set, "
                    "also where nothing changes"
                )
        return returned(what, got)

    return invoke


def _plain(argument: Any) -> Any:  # noqa: ANN401
    """An argument in a form that can be compared."""
    if isinstance(argument, nx.Graph):
        return dict(argument.nodes(data=True)), nx.to_dict_of_dicts(argument)
    if isinstance(argument, np.ndarray):
        return argument.tolist()
    if isinstance(argument, dict):
        return {key: _plain(value) for key, value in argument.items()}
    return argument
