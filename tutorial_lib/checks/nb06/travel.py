"""The check of replanning, in notebook 06."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Vertex

Plan = Callable[[set[Vertex]], list[Vertex]]
"""Plans around excluded vertices; returns no vertices when it refuses."""
Drive = Callable[[list[Vertex]], int | None]
"""Drives along a path; returns which place of it could not be reached, None on arrival."""


def travel(plan: Plan, drive: Drive, replans: int) -> tuple[bool, set[Vertex]]:
    """Plan, drive, and replan when lost; whether the goal was reached, and what is excluded.

    Args:
        plan: plans around excluded vertices.
        drive: drives along a path.
        replans: how often to replan.
    """
    return _travelled(plan, drive, replans)


def _travelled(plan: Plan, drive: Drive, replans: int, fault: str = "") -> tuple[bool, set[Vertex]]:
    """The navigation, with a `fault` if one is named."""
    excluded: set[Vertex] = set()
    rounds = {"too few": replans, "too many": replans + 2, "once": 1}.get(fault, replans + 1)
    path: list[Vertex] = []
    for number in range(rounds):
        if not (fault == "same path" and number):
            path = plan(set(excluded))
        if not path and fault != "drives on nothing":
            return False, excluded
        stopped = drive(path)
        if stopped is None:
            return True, excluded
        place = stopped - 1 if fault == "behind" else stopped
        vertex = path[place] if path else GOAL
        if fault == "forgets":
            excluded = set()
        if fault == "whole path":
            excluded |= {v for v in path if v not in (HERE, GOAL)}
        elif fault == "all ahead":
            excluded |= {v for v in path[stopped:] if v != GOAL}
        elif (vertex not in (HERE, GOAL) or fault == "goal") and fault != "excludes nothing":
            excluded.add(stopped if fault == "place" else vertex)
    return False, excluded


class _Story:
    """A scripted navigation: what `plan` and `drive` return, and a log of their calls."""

    def __init__(self, paths: Sequence[list[Vertex]], stops: Sequence[int | None]) -> None:
        self.paths, self.stops, self.log = list(paths), list(stops), []

    def plan(self, excluded: set[Vertex]) -> list[Vertex]:
        """The first path without excluded vertices."""
        if not isinstance(excluded, set | frozenset | list | tuple):
            raise WrongAnswer(f"plan got {excluded!r}; give it the set of what is excluded")
        self.log.append(("plan", tuple(sorted(excluded))))
        if len(self.log) > 40:
            raise WrongAnswer("your function never ends; count the plans")
        return next((list(path) for path in self.paths if not set(path) & set(excluded)), [])

    def drive(self, path: list[Vertex]) -> int | None:
        """The next stop."""
        if not path:
            raise WrongAnswer("plan returned [], a refusal, and yours drives all the same; give up")
        self.log.append(("drive", tuple(path)))
        return self.stops.pop(0) if self.stops else 1


_A, _B, _C = [HERE, 1, 2, 3, GOAL], [HERE, 1, 4, 3, GOAL], [HERE, 5, 6, GOAL]
_CASES: dict[str, tuple[list[list[Vertex]], list[int | None], int]] = {
    "it arrives at once": ([_A, _B], [None], 5),
    "lost once, then it arrives": ([_A, _B, _C], [2, None], 5),
    "lost twice, at different places": ([_A, _B, _C], [2, 3, None], 5),
    "refused at once": ([], [], 5),
    "refused after it was lost": ([_A, _B], [3, None], 5),
    "the goal itself cannot be reached": ([_A, _B], [4, 4, None], 5),
    "no second plan allowed": ([_A, _B, _C], [2, None], 0),
    "two replans, all in vain": ([_A, _B, _C, [HERE, 7, GOAL]], [2, 2, 1, None], 2),
    "lost at the first vertex": ([_C, _A], [1, None], 5),
}
_FAULTS = {
    "exclude the vertex that could not be reached, path[stopped], not the one before it": "behind",
    "exclude every vertex that could not be reached so far, not only the last one": "forgets",
    "only one vertex could not be reached; excluding the whole path leaves no other": "whole path",
    "only path[stopped] was tried in vain; what comes after it was never tried": "all ahead",
    "what could not be reached must be excluded, or the next plan is the same": "excludes nothing",
    "stopped is an index along the path; exclude the vertex there, path[stopped]": "place",
    "the goal is no vertex of the map; when it cannot be reached, replan, but exclude nothing": (
        "goal"
    ),
    "a lost robot needs a new plan; yours drives along the old one": "same path",
    "after the first plan there may be `replans` more; yours makes one too few": "too few",
    "after the first plan there may be `replans` more; yours makes one too many": "too many",
    "yours plans only once": "once",
}


def _play(
    travels: Callable[..., Any], paths: list[list[Vertex]], stops: list[int | None], replans: int
) -> tuple[Any, list[Any]]:
    """The outcome of a navigation, and the log of calls."""
    story = _Story(paths, stops)
    return travels(story.plan, story.drive, replans), story.log


def _invoke(what: str, student: Callable[..., Any], *case: Any) -> tuple[Any, list[Any]]:  # noqa: ANN401
    try:
        return _play(student, *case)
    except WrongAnswer as wrong:
        raise WrongAnswer(f"{what}: {wrong}") from None


@check(travel, (lambda excluded: [HERE, 1, GOAL], lambda path: None, 3))
def check_travel(student: Callable[..., Any]) -> None:
    """Nine navigations: to the goal at once, after being lost, refused, and in vain."""
    faults = with_faults(_travelled, _FAULTS)
    played = {words: partial(_play, rule) for words, rule in faults.items()}
    compare(
        "travel",
        student,
        _CASES,
        partial(_play, travel),
        played,
        invoke=_invoke,
        form=_ending,
        difference=_differ,
    )


def _ending(what: str, got: tuple[Any, list[Any]], *_: object) -> tuple[Any, ...]:
    """The outcome of a navigation in the right form, and the log of calls."""
    words = "return whether it arrived, and the set of what is excluded"
    arrived, excluded = parts(what, got[0], 2, words)
    if not isinstance(arrived, bool | np.bool_):
        raise WrongAnswer(f"{what}: {arrived!r} came back; return True on arrival, False otherwise")
    if not isinstance(excluded, set | frozenset | list | tuple):
        raise WrongAnswer(f"{what}: return the set of the vertices that are excluded")
    return (bool(arrived), set(excluded)), got[1]


def _differ(got: tuple[Any, ...], want: tuple[Any, ...], *_: object) -> str:
    for yours, right in zip(got[1], want[1], strict=False):
        if yours != right:
            kind, argument = yours
            if (kind, right[0]) == ("plan", "plan"):
                return f"yours excludes {list(argument)}; {list(right[1])} is right"
            return f"yours calls {kind} with {list(argument)}, where {right[0]} was to be called"
    if len(got[1]) != len(want[1]):
        return f"yours calls plan and drive {len(got[1])} times, but {len(want[1])} is right"
    arrived = "it arrives" if want[0][0] else "it does not arrive"
    return f"{got[0]} came back; {arrived}, and excluded is {want[0][1] or 'empty'}"
