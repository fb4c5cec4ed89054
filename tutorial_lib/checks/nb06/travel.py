"""The check of replanning, in notebook 06."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, kind, parts
from tutorial_lib.checks.framework.wording import times
from tutorial_lib.checks.nb06.forms import explaining
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Vertex

Plan = Callable[[set[Vertex]], list[Vertex]]
"""Plans around excluded vertices; returns no vertices when it refuses."""
Drive = Callable[[list[Vertex]], int | None]
"""Drives along a path; returns which place of it could not be reached, None on arrival."""


def travel(plan: Plan, drive: Drive, replans: int) -> tuple[bool, set[Vertex]]:
    """Plan, drive, and replan when lost; whether the goal was reached, and what is excluded."""
    excluded = set[Vertex]()
    for _ in range(replans + 1):
        path = plan(set(excluded))
        if not path:
            break
        stopped = drive(path)
        if stopped is None:
            return True, excluded
        vertex = path[stopped]
        excluded |= {vertex} - {HERE, GOAL}
    return False, excluded


class _Story:
    """A scripted navigation: what `plan` and `drive` return, and a log of their calls."""

    def __init__(self, paths: Sequence[list[Vertex]], stops: Sequence[int | None]) -> None:
        self.paths, self.stops, self.log = list(paths), list(stops), []

    def plan(self, excluded: set[Vertex]) -> list[Vertex]:
        """The first path without excluded vertices."""
        if not isinstance(excluded, set | frozenset):
            words = "give it a set of what is excluded, also where there is none: set()"
            raise WrongAnswer(f"plan got {excluded!r}; {words}")
        if not all(isinstance(v, int | np.integer) for v in excluded):
            raise WrongAnswer(f"plan got {excluded!r}; exclude vertices, one by one")
        self.log.append(("plan", tuple(sorted(excluded))))
        if len(self.log) > 40:
            raise WrongAnswer("your function never ends; count the plans")
        return next((list(path) for path in self.paths if not set(path) & set(excluded)), [])

    def drive(self, path: list[Vertex]) -> int | None:
        """The next stop."""
        if path is not None and not isinstance(path, list | tuple):
            raise WrongAnswer(f"drive got {kind(path)}; give it the path that plan made")
        if not path:
            raise WrongAnswer("plan returned [], a refusal, and yours drives all the same; give up")
        self.log.append(("drive", tuple(path)))
        return self.stops.pop(0) if self.stops else 1


_A, _B, _C = [HERE, 1, 2, 3, GOAL], [HERE, 1, 4, 3, GOAL], [HERE, 5, 6, GOAL]
_MANY = [[HERE, v, v + 1, GOAL] for v in range(10, 40, 2)]
CASES: dict[str, tuple[list[list[Vertex]], list[int | None], int]] = {
    "it arrives at once": ([_A, _B], [None], 5),
    "lost once, then it arrives": ([_A, _B, _C], [2, None], 5),
    "lost twice, at different places": ([_A, _B, _C], [2, 3, None], 5),
    "refused at once": ([], [], 5),
    "refused after it was lost": ([_A, _B], [3, None], 5),
    "the goal itself cannot be reached": ([_A, _B], [4, 4, None], 5),
    "no second plan allowed": ([_A, _B, _C], [2, None], 0),
    "two replans, all in vain": ([_A, _B, _C, [HERE, 7, GOAL]], [2, 2, 1, None], 2),
    "lost at the first vertex": ([_C, _A], [1, None], 5),
    "the goal in sight cannot be reached": ([[HERE, GOAL], _A], [1, 1, None], 5),
    "the goal cannot be reached, to the last plan": ([_A, _B], [4, 4, 4], 2),
    "lost, then at the goal, then it arrives": ([_A, _B, _C], [2, 4, None], 3),
    "it arrives with the last plan": ([_A, _B, _C], [2, 3, None], 2),
    "refused with the last plan": ([_A], [2], 1),
    "lost with the only plan": ([_A, _B], [3, None], 0),
    "one replan": ([_A, _B, _C], [2, 3, None], 1),
    "lost at vertex 0": ([[HERE, 0, 2, GOAL], _A, _C], [1, 2, None], 5),
    "lost at vertex 0, under way": ([[HERE, 1, 0, GOAL], _C], [2, None], 5),
    "the goal again and again, then it arrives": ([_A, _B], [4, 4, 4, None], 3),
    "lost at the seventh vertex": ([[HERE, *range(1, 10), GOAL], _C], [7, 1, None], 5),
    "four replans, all in vain": (_MANY, [1] * 5, 4),
    "six replans, and it arrives with the last": (_MANY, [1] * 6 + [None], 6),
    "lost twelve times, then it arrives": (_MANY, [1] * 12 + [None], 15),
}
MISTAKES = """
exclude the vertex that could not be reached, path[stopped], not the one before it
    path[stopped] -> path[stopped - 1]
exclude every vertex that could not be reached so far, not only the last one
    excluded |= -> excluded =
what is excluded stays so: the set lives outside of the loop
    path = plan -> excluded = set(); path = plan
exclude path[stopped]; the one before it was reached, and may be HERE
    {vertex} - {HERE, GOAL} -> {path[stopped - 1]} if vertex != GOAL else set()
exclude path[stopped], the vertex that could not be reached, not the one after it
    {vertex} -> {path[min(stopped + 1, len(path) - 2)] if vertex != GOAL else GOAL}
return what is excluded also on a refusal
    break -> return False, set()
a refusal is the end: the same plan would be refused again
    break -> continue
lost before the goal is not arrived: only None is
    stopped is None -> stopped is None or path[stopped] == GOAL
the last vertex that could not be reached is excluded, too, though no plan follows
    for _ in -> for number in
    excluded |= -> if number < replans: excluded |=
plan when you are about to drive; yours plans once more after the last drive
    excluded = set[Vertex]() -> excluded, path = set(), plan(set())
    path = plan(set(excluded)) -> pass
    - {HERE, GOAL} -> - {HERE, GOAL}; path = plan(set(excluded))
what was reached on the way, and the goal, are not excluded: path[stopped] only
    {vertex} - {HERE, GOAL} -> set(path[1 : stopped + 1])
only one vertex could not be reached; excluding the whole path leaves no other
    {vertex} -> set(path)
the vertices before path[stopped] were reached; exclude path[stopped] only
    {vertex} -> set(path[: stopped + 1])
only path[stopped] was tried in vain; what comes after it was never tried
    {vertex} -> set(path[stopped:])
what could not be reached must be excluded, or the next plan is the same
    {vertex} -> set()
stopped is an index along the path; exclude the vertex there, path[stopped]
    {vertex} - {HERE, GOAL} -> {stopped} if vertex != GOAL else set()
the goal is no vertex of the map; when it cannot be reached, replan, but exclude nothing
    {HERE, GOAL} -> {HERE}
the goal is no vertex of the map; when it cannot be reached, replan. Yours gives up
    stopped is None -> stopped is None or path[stopped] == GOAL
    return True -> return stopped is None
the goal is no vertex of the map; when it cannot be reached, exclude nothing. Yours excludes the
vertex before it
    path[stopped] -> path[stopped - (path[stopped] == GOAL)]
a plan that ends at the goal in vain was a plan, too; count it
    for _ in range(replans + 1) -> while replans >= 0
    excluded |= -> replans -= vertex != GOAL; excluded |=
it arrived: drive returned None
    return True -> return False
on a refusal it did not arrive: return False
    break -> return True, excluded
return all vertices that were excluded, also on arrival
    return True, excluded -> return True, set()
a lost robot needs a new plan; yours drives along the old one
    excluded = set[Vertex]() -> excluded, path = set(), None
    path = plan(set(excluded)) -> path = plan(set()) if path is None else path
after the first plan there may be `replans` more; yours makes one too few
    replans + 1 -> replans
after the first plan there may be `replans` more; yours makes one too many
    replans + 1 -> replans + 2
there may be as many plans after the first as `replans` says, however many; yours makes three
    replans + 1 -> min(replans, 3) + 1
whatever could not be reached is excluded, however much it is; yours stops at four
    {vertex} - {HERE, GOAL} -> {vertex} - {HERE, GOAL} if len(excluded) < 4 else set()
yours plans only once
    replans + 1 -> 1
where `replans` is 0 there is the first plan and no other
    replans + 1 -> max(replans, 1) + 1
exclude path[stopped] alone: those before it were reached
    {vertex} -> set(path[: stopped + 1] if vertex != GOAL else [])
vertex 0 is a vertex of the map like the others; only GOAL is never excluded
    {HERE, GOAL} -> {HERE, GOAL, 0}
"""
_HINTS: dict[type[Exception], str] = {
    TypeError: "plan(excluded) and drive(path) take one argument each; drive returns a number or "
    "None",
    IndexError: "stopped is a place along the path: path[stopped]",
}
_SAID = {
    "NoneType": "drive returned None, on arrival: that is no place. Drive once a round, ask for "
    "None first"
}


def _play(
    travels: Callable[..., Any], paths: list[list[Vertex]], stops: list[int | None], replans: int
) -> tuple[Any, list[Any]]:
    """The outcome of a navigation, and the log of calls."""
    story = _Story(paths, stops)
    return travels(story.plan, story.drive, replans), story.log


def _ending(what: str, got: tuple[Any, list[Any]], *_: object) -> tuple[Any, ...]:
    """The outcome of a navigation in the right form, and the log of calls."""
    words = "return whether it arrived, and the set of what is excluded"
    arrived, excluded = parts(what, got[0], 2, words)
    if not isinstance(arrived, bool | np.bool_):
        raise WrongAnswer(f"{what}: {arrived!r} came back; return True on arrival, False otherwise")
    if not isinstance(excluded, set | frozenset | list | tuple):
        raise WrongAnswer(f"{what}: return the set of the vertices that are excluded")
    if any(isinstance(vertex, list | dict | set) for vertex in excluded):
        raise WrongAnswer(f"{what}: {excluded!r} came back; exclude vertices, one by one")
    return (bool(arrived), set(excluded)), got[1]


def _broken(got: tuple[Any, ...], want: tuple[Any, ...], *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    names = [[called for called, _ in log] for log in (got[1], want[1])]
    if names[0] != names[1]:
        return (
            "plan, drive if there is a path, and so on: at most replans + 1 plans, until it "
            "arrives or refuses"
        )
    if got[1] != want[1]:
        return "each drive gets its plan's whole path, each plan all that was excluded until then"
    return "return whether it arrived, and all that was excluded in the whole navigation"


def _differ(got: tuple[Any, ...], want: tuple[Any, ...], *case: Any) -> str:  # noqa: ANN401
    """What a navigation does otherwise, and what happened just before."""
    for number, (yours, right) in enumerate(zip(got[1], want[1], strict=False)):
        if yours != right:
            called, argument = yours
            before = _told(want[1][:number], case)
            if (called, right[0]) == ("plan", "plan"):
                return f"yours plans without {list(argument)}; {list(right[1])} is right{before}"
            if (called, right[0]) == ("drive", "drive"):
                words = "give drive the path as plan returned it, whole"
                return f"yours drives along {list(argument)}, not {list(right[1])}; {words}{before}"
            words = f"yours calls {called} with {list(argument)}, but {right[0]} was to be called"
            return f"{words}{before}"
    if len(got[1]) != len(want[1]):
        plans = [sum(called == "plan" for called, _ in log) for log in (got[1], want[1])]
        words = f"yours plans {times(plans[0])}, but {times(plans[1])} is right"
        if plans[0] == plans[1]:
            words = "yours drives once more, or once less, than it plans"
        shorter = min(len(got[1]), len(want[1]))
        return f"{words}: there may be {case[2]} replans{_told(want[1][:shorter], case)}"
    arrived = "it arrives" if want[0][0] else "it does not arrive"
    return f"{got[0]} came back; {arrived}, and excluded is {want[0][1] or 'empty'}"


def _told(log: list[Any], case: tuple[Any, ...]) -> str:
    """What happened in the last drive of a log, in words."""
    drives = [path for called, path in log if called == "drive"]
    if not drives:
        return ""
    stops = [*case[1], *([1] * len(drives))]
    stopped = stops[len(drives) - 1]
    if stopped is None:
        return ", after the robot has arrived"
    vertex = "the goal" if drives[-1][stopped] == GOAL else f"vertex {drives[-1][stopped]}"
    return f", after {vertex} could not be reached on {list(drives[-1])}"


check_travel = exercise(
    travel,
    CASES,
    MISTAKES,
    about="Navigations: to the goal at once, after being lost, refused, and in vain.",
    example=case(lambda excluded: [HERE, 1, GOAL], lambda path: None, 3),
    run=_play,
    invoke=lambda what, student, *case: explaining(
        what, partial(_play, student, *case), _HINTS, _SAID
    ),
    form=_ending,
    difference=_differ,
    broken=_broken,
)
