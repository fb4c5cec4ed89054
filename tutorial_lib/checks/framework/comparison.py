"""Compare a student's answers with the right ones, and name the mistake behind wrong ones."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.checks.framework.alterations import altered
from tutorial_lib.checks.framework.answers import call, patient, unchanged
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.wording import both
from tutorial_lib.geometry import Array

Function = Callable[..., Any]
ALIKE = 0.75
"""Share of the wrong answers that a known mistake must explain to be named."""
SEVERAL = 3
"""Wrong answers that a known mistake must explain to be named where others are right."""
PARTLY = "in some cases"
"""Goes before a mistake that explains all wrong answers, but is not made everywhere."""
AGAIN = (
    "called again with the same arguments, your function gives a different answer; it must not "
    "keep anything from call to call"
)
"""What to say of a function that does not give its answer again."""
_NONE = object()
_KNOWN: dict[tuple[int, ...], tuple[Any, ...]] = {}
"""What rules of the library answer, by their ids; the rule and the case keep theirs."""


def compare(
    name: str,
    student: Function,
    cases: Mapping[str, Sequence[Any]],
    right: Function,
    faults: Mapping[str, Function],
    *,
    invoke: Function = lambda what, student, *case: call(student, *case),
    form: Function = lambda what, answer, *case: answer,
    same: Function = lambda got, want, *case: equal(got, want),
    difference: Function = lambda got, want, *case: first_difference(got, want),
    broken: Function = lambda got, want, *case: "",
    altered: Function = altered,
    draw: Callable[[Any, Any], NDArray[np.uint8]] | None = None,
) -> NDArray[np.uint8] | None:
    """Demand the right answer to every case.

    The first case with a wrong answer is reported, with what is wrong there. Of the known mistakes
    that give the same wrong answer to it, the one is named that explains most of the others, if
    those are `ALIKE` at least, with a "perhaps" if it does not explain all: few students make
    exactly the mistake that was foreseen.

    Args:
        name: of the exercise.
        student: the function to check.
        cases: for each, what it is like and the arguments.
        right: gives the right answer to a case.
        faults: for known mistakes, what to say and a function that makes this mistake.
        invoke: (what, student, *case) calls the student's function.
        form: (what, answer, *case) demands an answer of the right form, and may bring it into the
            form in which answers are compared.
        same: (got, want, *case) tells whether two answers are equally good.
        difference: (got, want, *case) says what is wrong; empty if other words say it all.
        broken: (got, want, *case) says which rule is broken, where no known mistake is named.
        altered: says of pairs of answers and right ones what was done to the right ones.
        draw: (want, got) draws the answers to the first case.

    Returns:
        What is expected and yours, if drawn.

    Raises:
        WrongAnswer: for the first case with a wrong answer.
    """
    named = {f"{name}, {why}": case for why, case in cases.items()}
    picture, (invoke, aliases) = None, patient(invoke)
    for what, case in named.items():
        mine = form(what, invoke(what, student, *case), *case)
        want = form(what, right(*case), *case)
        picture = draw(want, mine) if draw and picture is None else picture
        if same(mine, want, *case):
            continue

        def answers(rule: Function) -> list[Any]:
            return [_known(rule, form, what, case) for what, case in named.items()]

        again = _answer(student, invoke, form, what, case)
        if again is _NONE or not (unchanged(mine, again) or same(again, mine, *case)):
            raise WrongAnswer(f"{what}: {AGAIN}", picture)
        wanted = answers(right)
        got = [_answer(student, invoke, form, what, case) for what, case in named.items()]
        first = list(named).index(what)
        pairs = [(g, w) for g, w in zip(got, wanted, strict=True) if g is not _NONE]
        known = _best(first, got, wanted, faults, answers, same, list(named.values()))
        words = known if known in faults else altered(pairs) or known
        said, words = difference(mine, want, *case), words or broken(mine, want, *case)
        said = f"{words} ({said})" if words and said else words or said
        raise WrongAnswer(f"{what}: {said}", picture)
    if aliases:
        raise aliases[0]
    return picture


def _answer(
    function: Function, invoke: Function, form: Function, what: str, case: Sequence[Any]
) -> Any:  # noqa: ANN401
    """An answer of the right form, or `_NONE`."""
    with suppress(Exception):
        return form(what, invoke(what, function, *case), *case)
    return _NONE


def _known(rule: Function, form: Function, what: str, case: Sequence[Any]) -> Any:  # noqa: ANN401
    """What a rule answers to a case; kept, since every wrong answer is held against all mistakes.

    Rules are the same if they have the same parts: partial ones are made anew.
    """
    key = (*map(id, _parts(rule)), *map(id, case))
    if key not in _KNOWN:
        answer = _answer(rule, lambda _, function, *case: function(*case), form, what, case)
        _KNOWN[key] = answer, rule, case
    return _KNOWN[key][0]


def _parts(rule: Any) -> list[Any]:  # noqa: ANN401
    """A function, or that of a partial one and its arguments."""
    if not isinstance(rule, partial):
        return [rule]
    given = (rule.func, *rule.args, *rule.keywords.values())
    return [part for one in given for part in _parts(one)]


def _best(
    first: int,
    got: list[Any],
    wanted: list[Any],
    faults: Mapping[str, Function],
    answers: Function,
    same: Function,
    cases: list[Sequence[Any]],
) -> str:
    """The known mistake that explains most; empty if none explains enough."""

    def agree(one: Any, other: Any, case: Sequence[Any]) -> bool:  # noqa: ANN401
        if one is _NONE or other is _NONE:
            return one is other
        return bool(same(one, other, *case))

    def wrong(some: list[Any]) -> set[int]:
        zipped = enumerate(zip(some, wanted, cases, strict=True))
        return {i for i, (one, want, case) in zipped if not agree(one, want, case)}

    mine, best, most, partly, fewest = wrong(got), "", ALIKE, "", len(cases)
    for words, fault in faults.items():
        theirs = answers(fault)
        if not agree(got[first], theirs[first], cases[first]):
            continue
        either = mine | wrong(theirs)
        alike = {i for i in either if agree(got[i], theirs[i], cases[i])}
        share = len(alike) / len(either)
        if share > most or (share == most == ALIKE):
            best, most = words if share == 1 else f"perhaps: {words}", share
        if alike == mine and len(mine) >= SEVERAL and len(either) < fewest:
            partly, fewest = f"{PARTLY}: {words}", len(either)
    return best or partly


def equal(got: Any, want: object) -> bool:  # noqa: ANN401 - whatever students return
    """Whether two answers are the same."""
    return np.array_equal(got, want) if isinstance(want, np.ndarray) else bool(got == want)


def close(got: Array, want: ArrayLike, *_: object, tolerance: float = 1e-6) -> bool:
    """Whether two answers of numbers are nearly the same."""
    return np.allclose(got, want, atol=tolerance, rtol=0, equal_nan=True)


def first_difference(got: object, want: object) -> str:
    """Where two answers first differ."""
    mine, right = np.asarray(got), np.asarray(want)
    if not right.shape:
        return f"{got} came back; {want} is right"
    place = tuple(int(i) for i in np.argwhere(mine != right)[0])
    return f"{mine[place]} at {place if len(place) > 1 else place[0]}, but {right[place]} is right"


def farthest(got: Array, want: Array, *_: object) -> str:
    """Where two answers of numbers differ most."""
    if np.isnan(got).any():
        return "some of it is not a number; is something divided by zero?"
    with np.errstate(invalid="ignore"):  # inf - inf, where both agree
        apart = np.nan_to_num(np.abs(got - want))
    worst = np.unravel_index(apart.argmax(), want.shape)
    place = f" at {tuple(int(i) for i in worst)}" if want.shape else ""
    mine, right = both(got[worst], want[worst])
    return f"{mine}{place}, but {right} is right"
