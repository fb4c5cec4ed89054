"""Calls that must leave their arguments alone, for the checks of notebook 06."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.checks.framework.check import WrongAnswer


def untouched(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
    """A student's answer, if the arguments are as they were.

    Raises:
        WrongAnswer: when one was changed, or nothing came back.
    """
    given = copy.deepcopy(arguments)
    got = student(*given)
    for number, (old, new) in enumerate(zip(arguments, given, strict=True), 1):
        if old == new:
            continue
        inner = isinstance(old, dict) and old.keys() == new.keys()
        words = "the copy shares its inner dictionaries with the map; copy those, too"
        words = words if inner else "it is needed again for the next plan; make a new one"
        raise WrongAnswer(f"{what}: your function changes its argument {number}; {words}")
    return returned(what, got)
