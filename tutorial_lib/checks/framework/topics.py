"""Cases in the order of their difficulty, each with what it teaches."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from inspect import signature
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.alterations import altered, telling
from tutorial_lib.checks.framework.answers import call, patient, unchanged
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.comparison import AGAIN, close, farthest
from tutorial_lib.checks.framework.explanation import meant, stops
from tutorial_lib.checks.framework.wording import kind

Function = Callable[..., Any]
_TOLERANCE = 1e-5  # as single precision has


@dataclass(frozen=True)
class Topic:
    """Cases that show the same thing.

    Attributes:
        about: what they are like.
        words: where to look when an answer to one of them is wrong.
        cases: the arguments of each.
    """

    about: str
    words: str
    cases: Sequence[tuple[Any, ...]]


def hint(words: str, *cases: tuple[Any, ...]) -> tuple[str, Sequence[tuple[Any, ...]]]:
    """Where to look when an answer to one of some cases is wrong, and these cases."""
    return words, cases


def topics(hints: Mapping[str, tuple[str, Sequence[tuple[Any, ...]]]]) -> list[Topic]:
    """Topics, from what each is like and its `hint`."""
    return [Topic(about, words, cases) for about, (words, cases) in hints.items()]


def judge_topics(
    name: str,
    student: Function,
    topics: Sequence[Topic],
    right: Function,
    faults: Mapping[str, Function],
    *,
    form: Function,
    invoke: Function = lambda what, student, *case: call(student, *case),
    same: Function = lambda got, want, *case: close(got, want, tolerance=_TOLERANCE),
    difference: Function = lambda got, want, *case: farthest(got, np.asarray(want, float)),
    draw: Function = lambda student: None,
) -> NDArray[np.uint8] | None:
    """Demand the right answer to every case of topics that stand in the order of their difficulty.

    Of the arguments, which are those of `compare`, two differ: `draw` takes the student's function,
    and of the `faults` the one is named that gives every answer of this function, or every wrong
    one.
    """
    invoke, aliases = patient(invoke)
    for topic in topics:
        what = f"{name}, {topic.about}"
        for case in topic.cases:
            called = partial(invoke, what, student)
            answer = attempt(what, topic.words, called, *case)
            got = _formed(form, what, answer, *case)
            want = right(*case)
            if same(got, want, *case):
                continue
            if not _repeats(called, case, got, form, same):
                raise WrongAnswer(f"{what}: {AGAIN}")
            given = _given(called, topics, form)
            words = _known(given, right, faults, same)
            if not words:
                partly = _partly(given, right, faults, same)
                words = f"{topic.words} ({difference(got, want, *case)}){partly}"
            raise WrongAnswer(f"{what}: {words}", _shown(draw, student, right))
    if aliases:
        raise aliases[0]
    return draw(student)


def _shown(draw: Function, student: Function, right: Function) -> NDArray[np.uint8] | None:
    """The picture of a wrong function; none where it is that of the right one."""
    with suppress(Exception):  # the student's answers may be such that nobody can draw
        picture = draw(student)
        return None if np.array_equal(picture, draw(right)) else picture
    return None


def attempt(what: str, words: str, called: Function, *case: Any) -> Any:  # noqa: ANN401 - whatever students return
    """A student's answer; an error of its code is reported with what was asked and a hint."""
    try:
        return called(*case)
    except (NotImplementedError, WrongAnswer, MemoryError):
        raise
    except Exception as error:
        raise WrongAnswer(f"{what}: {stops(error)}.\n{meant(error) or words}") from None


def _formed(form: Function, what: str, answer: object, *case: Any) -> Any:  # noqa: ANN401
    """An answer of the right form; `WrongAnswer` if it has another, however odd."""
    try:
        return form(what, answer, *case)
    except WrongAnswer:
        raise
    except Exception:
        words = "came back, which isn't the form that the docstring names"
        raise WrongAnswer(f"{what}: {kind(answer)} {words}") from None


def _repeats(called: Function, case: tuple, got: object, form: Function, same: Function) -> bool:
    """Whether a student's function gives its wrong answer again."""
    try:
        again = form("", called(*case), *case)
        return unchanged(got, again) or bool(same(again, got, *case))
    except Exception:
        return False


def _given(called: Function, topics: Sequence[Topic], form: Function) -> list[tuple[tuple, Any]]:
    """The cases and a student's answers to them."""
    given = []
    for case in (case for topic in topics for case in topic.cases):
        with suppress(Exception):
            given.append((case, form("", called(*case), *case)))
    return given


def _known(
    given: list[tuple[tuple, Any]], right: Function, faults: Mapping[str, Function], same: Function
) -> str | None:
    """What to say of the first known mistake that gives all of a student's answers.

    An argument that changes nothing is such a mistake, too.
    """
    for words, fault in faults.items():
        with suppress(Exception):
            if all(same(got, fault(*case), *case) for case, got in given):
                return words
    return altered([(got, right(*case)) for case, got in given]) or _unused(given, right)


def _partly(
    given: list[tuple[tuple, Any]], right: Function, faults: Mapping[str, Function], same: Function
) -> str:
    """What to add of the known mistake that gives all wrong answers, and fewest others.

    Answers that are all 0 or infinite are those of many mistakes, and say nothing.
    """
    fine = [same(got, right(*case), *case) for case, got in given]
    wrong = [got for (_, got), is_right in zip(given, fine, strict=True) if not is_right]
    best, fewest = "", len(given) if telling(wrong) else 0
    for words, fault in faults.items():
        with suppress(Exception):
            unlike = 0
            for (case, got), is_right in zip(given, fine, strict=True):
                if not same(got, fault(*case), *case):
                    unlike += 1
                    if unlike >= fewest or not is_right:  # it cannot be the best any more
                        break
            else:
                if unlike < fewest:
                    best, fewest = f". In some cases: {words}", unlike
    return best


def _unused(given: list[tuple[tuple, Any]], right: Function) -> str | None:
    """What to say of an argument that changes the right answers, but never the student's."""
    matters: dict[int, list[bool]] = {}
    for (case, got), (other, answer) in combinations(given, 2):
        differ = [i for i, two in enumerate(zip(case, other, strict=True)) if not _equal(*two)]
        if len(differ) == 1 and not _equal(right(*case), right(*other)):
            matters.setdefault(differ[0], []).append(_equal(got, answer))
    names = list(signature(right).parameters)
    unused = [names[i] for i, unchanged in matters.items() if len(unchanged) > 1 and all(unchanged)]
    return f"another {unused[0]} never changes your answer; it should" if unused else None


def _equal(first: Any, second: Any) -> bool:  # noqa: ANN401 - arguments and answers of any kind
    if isinstance(first, tuple | list) and isinstance(second, tuple | list):
        return len(first) == len(second) and all(map(_equal, first, second))
    return first is second or np.array_equal(first, second)
