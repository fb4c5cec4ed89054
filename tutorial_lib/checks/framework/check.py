"""A check, its result, and how a wrong answer is reported."""

import copy
import html
import re
import time
from base64 import b64encode
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework import guard, my_answers
from tutorial_lib.checks.framework.explanation import place, stops
from tutorial_lib.errors import InputError, words_of
from tutorial_lib.viz.figures.film import png

SLOWEST = 20.0
"""How many times slower than the reference a solution may be and still be used..."""
AFFORDABLE = 1.0
"""...unless all its calls by the cells below take fewer seconds than this."""
ENDLESS = "Your function has not ended after {seconds:g} seconds. Does a loop never end?"
_COLOURS = {"passed": "#007a57", "failed": "#b84a00", "not attempted": "#5f6570"}
_BADGE = "color:#ffffff;padding:0 6px;border-radius:3px;"
"""A word that reads on light and on dark pages brings its background along."""
_ROUNDS = 5

Function = Callable[..., Any]
Status = Literal["passed", "failed", "not attempted"]


class WrongAnswer(Exception):  # noqa: N818 - it is an answer, not an error of ours
    """Raised by a check: what is wrong, in the student's terms.

    Attributes:
        picture: (H, W, 3) expected and yours, or None.
    """

    def __init__(self, message: str, picture: NDArray[np.uint8] | None = None) -> None:
        super().__init__(message)
        self.picture = picture


@dataclass(frozen=True, repr=False)
class Result:
    """The outcome of a check, as text and as HTML."""

    exercise: str
    status: Status
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
            f'<b>{self.exercise}</b> <b style="{_BADGE}background:{colour}">{self.status}</b>'
            f"<br>{text}"
        )
        if self.picture is not None:
            data = b64encode(png(self.picture)).decode()
            page += f'<br><img alt="expected and yours" src="data:image/png;base64,{data}">'
        return page + "</div>"


class Check:
    """A check of one exercise: call it for its `Result`, or `use` it in a notebook.

    Attributes:
        name: of the exercise.
        notebook: its number, as in "02".
        reference: the function that the cells below use when the student's is not there.
        mistakes: of a check that `checks.engine` made, by what is said of them.
    """

    mistakes: Mapping[str, Function] | None = None

    def __init__(
        self, judge: Function, reference: Function, example: tuple, calls: int, endless: str
    ) -> None:
        self.name = judge.__name__.removeprefix("check_")
        found = re.search(r"\.nb(\d\d)\b", judge.__module__)
        self.notebook = found[1] if found else "00"
        self.judge, self.reference, self.example = judge, reference, example
        self.calls, self.endless = calls, endless
        self.__doc__ = judge.__doc__
        self._last: Result | None = None

    def __call__(self, student: Function) -> Result:
        """Judge a student's function, whatever it does."""
        try:
            picture = guard.limited(self.judge, student)
        except NotImplementedError:
            message = "Not attempted yet; the cells below use the library's."
            return Result(self.name, "not attempted", message)
        except WrongAnswer as wrong:
            return Result(self.name, "failed", str(wrong), wrong.picture)
        except KeyboardInterrupt:  # the student's own wish
            raise
        except BaseException as error:
            return Result(self.name, "failed", self._words(error))
        return Result(self.name, "passed", "Correct; the cells below use yours.", picture)

    def _words(self, error: BaseException) -> str:
        """What to say when judging ended with an error."""
        if isinstance(error, guard.TimeUp):
            return (self.endless or ENDLESS).format(seconds=guard.SECONDS)
        if isinstance(error, MemoryError):
            usual = "Does a loop never end, or an array keep growing?"
            return f"Your function fills the memory. {self.endless.partition('. ')[2] or usual}"
        if isinstance(error, SystemExit):
            return "Your function ends the program, as sys.exit() does; return the answer instead."
        if place(error):
            said = stops(error)
            return f"{said[0].upper()}{said[1:]}"
        said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        return f"The check could not use your answer ({said}); compare it with the docstring."

    def use(self, student: Function) -> Function:
        """Show the result, and give back the function that the cells below should use.

        That is the student's when it passes and is quick enough, and the reference otherwise. A
        passed answer is saved in the folder `my_answers`. A function that the check itself gave
        back is not judged: the last result is shown again.
        """
        from IPython.display import display

        if student is self.reference:
            display(self._repeated())
            return student
        result, chosen = self(student), self.reference
        if result.status == "passed":
            words = self._too_slow(student)
            chosen = self.reference if words else student
            saved = my_answers.save(self.notebook, self.name, student)
            result = replace(result, message=f"{words or result.message} {saved}".strip())
        self._last = result
        display(result)
        return chosen

    def mine(self) -> Function:
        """The student's saved answer if it passes, and the reference otherwise.

        It says why one that is saved is not used, and stops no notebook, whatever is in its file.
        """
        student, said = self._saved()
        if student is not None:
            result = self(student)
            if result.status == "passed":
                return student
            said = str(result)
        if said:
            print(f"{said}\nThe library's {self.name} is used.")
        return self.reference

    def _saved(self) -> tuple[Function | None, str]:
        """The saved answer, or None and why there is none."""
        file = my_answers.path(self.notebook, self.name).absolute()
        try:
            return guard.limited(lambda _: my_answers.load(self.notebook, self.name), file), ""
        except (InputError, MemoryError) as error:
            return None, str(error) or words_of(error)
        except guard.TimeUp:
            words = f"{file} has not ended after {guard.SECONDS:g} seconds"
            return None, f"{words}; mend it, or delete it and solve the exercise again"

    def _repeated(self) -> Result:
        """What to show when the reference itself comes to be judged."""
        again = f"Run the cell with your {self.name} again to have it checked."
        if self._last is None:
            message = f"This is the library's function, not yours. {again}"
            return Result(self.name, "not attempted", message)
        message = f"{self._last.message}\n(This is the last result. {again})"
        return replace(self._last, message=message)

    def _too_slow(self, student: Function) -> str:
        """What to say of a correct function that the cells below do not use; empty if they do."""
        mine = _seconds(student, self.example)
        ratio = mine / _seconds(self.reference, self.example)
        if ratio <= SLOWEST or self.calls * mine <= AFFORDABLE:
            return ""
        return f"Correct, but {ratio:.0f} times slower than the library's, which is used below."


def check(
    reference: Function, example: tuple, *, calls: int = 1000, endless: str = ""
) -> Callable[[Function], Check]:
    """Make a check of a judging function.

    The judge takes the student's function, raises `WrongAnswer` where it finds something wrong, and
    may return a picture of what is expected and yours.

    Args:
        reference: what is used below when the student's function is not.
        example: arguments to measure both with.
        calls: how often the cells below call the function with arguments like these.
        endless: what to say when it does not end.
    """
    return lambda judge: Check(judge, reference, example, calls, endless)


def _seconds(function: Function, example: tuple) -> float:
    """The shortest of several calls."""
    spans = []
    for _ in range(_ROUNDS):
        given = copy.deepcopy(example)  # what a call changes is not left to the next one
        begun = time.perf_counter()
        function(*given)
        spans.append(time.perf_counter() - begun)
        if spans[-1] > AFFORDABLE:
            break
    return min(spans)
