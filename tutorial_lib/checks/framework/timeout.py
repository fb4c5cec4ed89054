"""An end to functions that never end."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

from tutorial_lib.checks.framework.check import WrongAnswer


def within_line_limit(
    function: Callable[..., Any], *arguments: object, otherwise: str, lines: int = 500_000
) -> Any:  # noqa: ANN401 - whatever the function returns
    """What a function returns, if it has done so after some lines of Python.

    A loop that appends to a list would fill the memory before any clock strikes.

    Args:
        function: of a student.
        arguments: for it.
        otherwise: what to say when it goes on.
        lines: that it may run, those of the functions that it calls included.

    Raises:
        WrongAnswer: when it goes on.
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
