"""What a check is, and what it says."""

from __future__ import annotations

import html
import time
from base64 import b64encode
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

SLOWEST = 20.0
"""How many times slower than the reference a solution may be and still be used."""
_COLOURS = {"passed": "#009e73", "failed": "#d55e00", "not attempted": "#969ba5"}
_ROUNDS = 5

Function = Callable[..., Any]


class WrongAnswer(Exception):  # noqa: N818 - it is an answer, not an error of ours
    """Raised by a check: what is wrong, in the student's own terms.

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
        """Estimator a student's function."""
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


def expect_close(
    what: str,
    got: object,
    want: ArrayLike,
    tolerance: float = 1e-6,
    mistakes: Mapping[str, ArrayLike] | None = None,
    picture: NDArray[np.uint8] | None = None,
) -> None:
    """Demand that an answer is close to what is wanted; shape first, then values.

    Args:
        what: was computed, for the message.
        got: the student's answer.
        want: the right one.
        tolerance: that may lie between them.
        mistakes: for known mistakes, what to say and the answer that they give.
        picture: target and yours.

    Raises:
        WrongAnswer: with the most helpful message.
    """
    want = np.asarray(want, dtype=float)
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    if want.ndim and not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: a {type(got).__name__} came back; return a numpy array")
    try:
        values = np.asarray(got, dtype=float)
    except (TypeError, ValueError):
        kind = type(got).__name__
        raise WrongAnswer(f"{what}: a {kind} is no array of numbers; return an array") from None
    if values.shape != want.shape:
        raise WrongAnswer(f"{what}: shape {values.shape}, but {want.shape} is needed")
    if np.allclose(values, want, atol=tolerance, rtol=0):
        return
    for message, mistaken in (mistakes or {}).items():
        mistaken = np.broadcast_to(np.asarray(mistaken, dtype=float), want.shape)
        if np.allclose(values, mistaken, atol=tolerance, rtol=0, equal_nan=True):
            raise WrongAnswer(f"{what}: {message}", picture)
    if np.isnan(values).any():
        raise WrongAnswer(f"{what}: some of it is not a number; is something divided by zero?")
    with np.errstate(invalid="ignore"):  # inf - inf, where both agree
        apart = np.nan_to_num(np.abs(values - want))
    worst = np.unravel_index(apart.argmax(), want.shape)
    place = f" at {tuple(int(i) for i in worst)}" if want.shape else ""
    raise WrongAnswer(
        f"{what}: {values[worst]:.4g}{place}, but {want[worst]:.4g} is right", picture
    )


def call(student: Function, *arguments: Any) -> Any:  # noqa: ANN401 - whatever students return
    """Call a student's function, and demand that it leaves its arguments alone.

    Raises:
        WrongAnswer: when an argument was changed.
    """
    before = [np.array(argument, copy=True) for argument in arguments]
    answer = student(*arguments)
    for number, (old, new) in enumerate(zip(before, arguments, strict=True), 1):
        if not np.array_equal(old, new):
            raise WrongAnswer(f"your function changes its argument {number}; make a new array")
    return answer


def _seconds(function: Function, example: tuple) -> float:
    """The shortest of several calls."""
    spans = []
    for _ in range(_ROUNDS):
        begun = time.perf_counter()
        function(*example)
        spans.append(time.perf_counter() - begun)
    return min(spans)
