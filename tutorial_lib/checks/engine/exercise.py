"""From a rule, its cases and known mistakes to a check."""

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.engine.edits import mistakes_of
from tutorial_lib.checks.framework.answers import beside
from tutorial_lib.checks.framework.check import Check, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.framework.topics import Topic, judge_topics

Function = Callable[..., Any]
Cases = Mapping[str, Sequence[Any]]


def case(*arguments: Any) -> tuple[Any, ...]:  # noqa: ANN401 - whatever the rule takes
    """The arguments of one call."""
    return arguments


def exercise(
    rule: Function,
    cases: Cases | Sequence[Topic] | Callable[[], Iterable[Cases]],
    mistakes: str = "",
    *,
    about: str,
    example: tuple,
    run: Function | None = None,
    others: Mapping[str, Function] | None = None,
    later: Mapping[str, Any] | None = None,
    calls: int = 1_000,
    endless: str = "",
    **comparing: Any,  # noqa: ANN401 - see `compare`
) -> Check:
    """A check of the exercise that asks for `rule`.

    The module that calls this one is the check's, and names the notebook.

    Args:
        rule: the right answer; the cells below use it where the student's is not there.
        cases: for each, what it is like and the arguments, for `compare`; or topics, each with
            words of its own, for `judge_topics`; or a function that gives groups of cases, each
            of which comes, and is made, once those before it are right.
        mistakes: see `mistakes_of`.
        about: one line on what is checked.
        example: arguments to measure speed with.
        run: (function, *case) calls a function and returns what is judged, where that is more than
            its answer; unless `invoke` does so, too, it runs beside the function.
        others: mistakes that are no edits of the rule: what to say, and functions that make them.
        later: what else is given to `compare` once every case is right: other ``cases``, of which
            no mistakes are known, and how those are compared.
        calls: how often the cells below call it.
        endless: what to say when it does not end.
        **comparing: how answers are called, formed, compared and drawn, see `compare` and
            `judge_topics`.
    """
    caller = sys._getframe(1).f_globals["__name__"]
    known = mistakes_of(rule, mistakes) | dict(others or {})
    right, faults = rule, known
    compared: Function = judge_topics if isinstance(cases, Sequence) else compare
    if run is not None:
        right, faults = partial(run, rule), {words: partial(run, f) for words, f in known.items()}
        there = beside(run)
        comparing.setdefault("invoke", lambda what, student, *given: there(student, *given))

    def judge(student: Function) -> Any:  # noqa: ANN401 - expected and yours, if drawn
        picture = None
        with np.errstate(all="ignore"):
            for group in cases() if callable(cases) else [cases]:
                picture = compared(rule.__name__, student, group, right, faults, **comparing)
            if later:
                unknown = {"right": right, "faults": {}}
                compare(rule.__name__, student, **unknown, **{**comparing, **later})
            return picture

    judge.__name__, judge.__doc__, judge.__module__ = f"check_{rule.__name__}", about, caller
    made = check(rule, example, calls=calls, endless=endless)(judge)
    made.mistakes = known
    return made
