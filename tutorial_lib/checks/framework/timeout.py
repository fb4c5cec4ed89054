"""A limit for functions that never end."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

from tutorial_lib.checks.framework.check import WrongAnswer


def within_line_limit(
    function: Callable[..., Any], *arguments: object, otherwise: str, lines: int = 500_000
) -> Any:  # noqa: ANN401 - whatever the function returns
    """Return what a function returns, if it does so within a number of lines of Python.

    A limit in seconds would come too late for a loop that fills the memory.

    Args:
        function: of a student.
        arguments: for it.
        otherwise: what to say when it exceeds the limit.
        lines: how many it may run, including those of the functions that it calls.

    Raises:
        WrongAnswer: when it exceeds the limit.
    """
    left, before = lines, sys.gettrace()

    def count(frame: FrameType, event: str, argument: object) -> Callable[..., Any]:
        nonlocal left
        left -= event == "line"
        if left < 0:
            raise WrongAnswer(otherwise)
        return count

    sys.settrace(count)
    try:
        return function(*arguments)
    finally:
        sys.settrace(before)
