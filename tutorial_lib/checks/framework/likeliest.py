"""Name the mistake that explains a student's wrong answers best, even if not all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.comparison import equal, first_difference

Function = Callable[..., Any]
_NOTHING = object()
_ENOUGH = 0.6
"""Share of the wrong answers that a mistake must explain to be named."""


def compare_likeliest(
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
    draw: Callable[[Any, Any], NDArray] | None = None,
) -> NDArray | None:
    """Demand the right answer to every case; arguments as for `comparison.compare`.

    Of the known mistakes the one is named that gives most of the wrong answers, and fewest where
    the student is right; none if it explains less than `_ENOUGH` of them.

    Raises:
        WrongAnswer: for the first case with a wrong answer that the mistake explains, or for the
            first at all.
    """
    named = {f"{name}, {why}": case for why, case in cases.items()}
    got = [form(what, invoke(what, student, *case), *case) for what, case in named.items()]
    wanted = [form(what, right(*case), *case) for what, case in named.items()]
    picture = draw(wanted[0], got[0]) if draw else None
    everything = list(zip(named.items(), got, wanted, strict=True))
    wrong = [not same(mine, want, *case) for (_, case), mine, want in everything]
    if not any(wrong):
        return picture
    best, words, where = _ENOUGH * sum(wrong), "", wrong.index(True)
    for said, answers in _answers(faults, named, form):
        hits = [
            answer is not _NOTHING and same(mine, answer, *case)
            for ((_, case), mine, _), answer in zip(everything, answers, strict=True)
        ]
        explained = [hit and off for hit, off in zip(hits, wrong, strict=True)]
        score = sum(explained) - sum(
            not hit and not off for hit, off in zip(hits, wrong, strict=True)
        )
        if any(explained) and score > best - 1e-9 and (score > best or not words):
            best, words, where = score, said, explained.index(True)
    (what, case), mine, want = everything[where]
    raise WrongAnswer(f"{what}: {words or difference(mine, want, *case)}", picture)


def _answers(
    faults: Mapping[str, Function], named: Mapping[str, Sequence[Any]], form: Function
) -> Iterator[tuple[str, list[Any]]]:
    """What to say of each mistake, and its answer to every case; `_NOTHING` where it has none."""
    for words, fault in faults.items():
        answers = [_NOTHING] * len(named)
        for i, (what, case) in enumerate(named.items()):
            with suppress(IndexError, ValueError, WrongAnswer):
                answers[i] = form(what, fault(*case), *case)
        yield words, answers
