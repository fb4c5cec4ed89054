"""Calls on copies of the arguments, so that no answer spoils the cases of the next one."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

from tutorial_lib.checks.framework.answers import calling


def calling_on_copies(hints: Mapping[type[Exception], str]) -> Callable[..., Any]:
    """As `calling`, but the function gets copies: what it changes is reported, and then forgotten.

    Args:
        hints: what to say of kinds of errors in this exercise.
    """
    invoke = calling(hints)

    def on_copies(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        return invoke(what, student, *copy.deepcopy(arguments))

    return on_copies
