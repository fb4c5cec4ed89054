"""Judge answers case by case, and name the mistake that explains most of the wrong ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.comparison import Function, equal, first_difference

ALIKE = 0.75
"""Share of the wrong answers that a known mistake must explain to be named."""
_NONE = object()


def case_by_case(
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
    draw: Callable[[Any, Any], NDArray[np.uint8]] | None = None,
) -> NDArray[np.uint8] | None:
    """Demand the right answer to every case; the arguments are those of `comparison.compare`.

    The first case with a wrong answer is reported, with what is wrong there. Of the known mistakes
    that give the same wrong answer to it, the one is named that explains most of the others, if
    those are `ALIKE` at least: few students make exactly the mistake that was foreseen.

    Returns:
        Target and yours, if drawn.

    Raises:
        WrongAnswer: for the first case with a wrong answer.
    """
    named = {f"{name}, {why}": case for why, case in cases.items()}
    picture = None
    for what, case in named.items():
        mine = form(what, invoke(what, student, *case), *case)
        want = form(what, right(*case), *case)
        picture = draw(want, mine) if draw and picture is None else picture
        if same(mine, want, *case):
            continue

        def answers(function: Function, invoke: Function) -> list[Any]:
            return [_answer(function, invoke, form, what, case) for what, case in named.items()]

        wanted = answers(right, _plainly)
        got = answers(student, invoke)
        first = list(named).index(what)
        words = _best(first, got, wanted, faults, answers, same, list(named.values()))
        said = difference(mine, want, *case)
        raise WrongAnswer(f"{what}: {words} ({said})" if words else f"{what}: {said}", picture)
    return picture


def _plainly(what: str, function: Function, *case: Any) -> Any:  # noqa: ANN401
    return function(*case)


def _answer(
    function: Function, invoke: Function, form: Function, what: str, case: Sequence[Any]
) -> Any:  # noqa: ANN401
    """An answer of the right form, or `_NONE`."""
    with suppress(Exception):
        return form(what, invoke(what, function, *case), *case)
    return _NONE


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

    mine, best, most = wrong(got), "", ALIKE
    for words, fault in faults.items():
        theirs = answers(fault, _plainly)
        if not agree(got[first], theirs[first], cases[first]):
            continue
        either = mine | wrong(theirs)
        share = sum(agree(got[i], theirs[i], cases[i]) for i in either) / len(either)
        if share > most or (share == most == ALIKE):
            best, most = words, share
    return best
