"""A check, its result, and how a wrong answer is reported."""

from __future__ import annotations

import html
import time
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

SLOWEST = 20.0
"""How many times slower than the reference a solution may be and still be used."""
_COLOURS = {"passed": "#009e73", "failed": "#d55e00", "not attempted": "#969ba5"}
_ROUNDS = 5

Function = Callable[..., Any]


class WrongAnswer(Exception):  # noqa: N818 - it is an answer, not an error of ours
    """Raised by a check: what is wrong, in the student's terms.

    Attributes:
        picture: (H, W, 3) target and yours, or None.
    """

    def __init__(self, message: str, picture: NDArray[np.uint8] | None = None) -> None:
        super().__init__(message)
        self.picture = picture


@dataclass(frozen=True, repr=False)
class Result:
    """The outcome of a check, as text and as HTML."""

    exercise: str
    status: Literal["passed", "failed", "not attempted"]
    message: str
    picture: NDArray[np.uint8] | None = None

    def __str__(self) -> str:
        return f"{self.exercise}: {self.status}. {self.message}"

    __repr__ = __str__

    def _repr_html_(self) -> str:
        colour = _COLOURS[self.status]
        text = html.escape(self.message).replace("\n", "<br>")
        page = (
            f'<div style="border-left:6px solid {colour};padding:6px 12px">'
            f'<b>{self.exercise}</b> <span style="color:{colour}">{self.status}</span><br>{text}'
        )
        if self.picture is not None:
            data = b64encode(cv2.imencode(".png", self.picture[..., ::-1])[1]).decode()
            page += f'<br><img alt="target and yours" src="data:image/png;base64,{data}">'
        return page + "</div>"


class Check:
    """A check of one exercise: call it for its `Result`, or `use` it in a notebook."""

    def __init__(self, name: str, judge: Function, reference: Function, example: tuple) -> None:
        """See `check`."""
        self.name, self.judge, self.reference, self.example = name, judge, reference, example
        self.__doc__ = judge.__doc__

    def __call__(self, student: Function) -> Result:
        """Judge a student's function."""
        try:
            picture = self.judge(student)
        except NotImplementedError:
            message = "Not attempted yet; the cells below use the reference."
            return Result(self.name, "not attempted", message)
        except WrongAnswer as wrong:
            return Result(self.name, "failed", str(wrong), wrong.picture)
        except Exception as error:
            message = f"Your function raised {type(error).__name__}: {error}"
            return Result(self.name, "failed", message)
        return Result(self.name, "passed", "Correct; the cells below use yours.", picture)

    def use(self, student: Function) -> Function:
        """Show the result, and give back the function that the cells below should use.

        That is the student's when it passes and is at most `SLOWEST` times slower than the
        reference, and the reference otherwise.
        """
        from IPython.display import display

        result, chosen = self(student), self.reference
        if result.status == "passed":
            ratio = _seconds(student, self.example) / _seconds(self.reference, self.example)
            chosen = student if ratio <= SLOWEST else self.reference
            if chosen is self.reference:
                slow = f"Correct, but {ratio:.0f} times slower than the reference, which is used."
                result = Result(self.name, "passed", slow, result.picture)
        display(result)
        return chosen


def check(reference: Function, example: tuple) -> Callable[[Function], Check]:
    """Make a check of a judging function.

    The judge takes the student's function, raises `WrongAnswer` where it finds something wrong, and
    may return a picture of target and yours.

    Args:
        reference: what is used below when the student's function is not.
        example: arguments to measure both with.
    """

    def decorate(judge: Function) -> Check:
        return Check(judge.__name__.removeprefix("check_"), judge, reference, example)

    return decorate


def _seconds(function: Function, example: tuple) -> float:
    """The shortest of several calls."""
    spans = []
    for _ in range(_ROUNDS):
        begun = time.perf_counter()
        function(*example)
        spans.append(time.perf_counter() - begun)
    return min(spans)
