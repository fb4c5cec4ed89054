"""The check of the navigator's loop, in notebook 06."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.framework.wording import number_of
from tutorial_lib.checks.nb06.decide import Decision, decide
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Graph, Vertex
from tutorial_lib.checks.nb06.navigate_words import FAULTS
from tutorial_lib.checks.nb06.navigation_stories import STORIES, Limits, ScriptedRobot, Story
from tutorial_lib.checks.nb06.untouched import explaining, number
from tutorial_lib.topology.planner import DijkstraPlanner

ENDINGS = ("arrived", "refused", "gave up", "late")
Navigated = tuple[str, list[Decision], set[Vertex]]
"""How it ended, all decisions, and the vertices that are excluded."""


def navigate(
    robot: Any,  # noqa: ANN401
    graph: Graph,
    rules: DijkstraPlanner,
    limits: Limits,
    decide: Callable[..., Decision] = decide,
) -> Navigated:
    """Plan, follow, search and replan, step by step.

    Args:
        robot: with `look`, `turn`, `follow` and `active`, as a `ScriptedRobot`.
        graph: of the map.
        rules: of `decide`.
        limits: of the navigation.
        decide: plans.
    """
    return _navigated(robot, graph, rules, limits, decide=decide)


def without(graph: Graph, excluded: set[Vertex]) -> Graph:
    """A graph without some vertices."""
    return {
        v: {w: p for w, p in out.items() if w not in excluded}
        for v, out in graph.items()
        if v not in excluded
    }


def _navigated(
    robot: Any,  # noqa: ANN401
    graph: Graph,
    rules: DijkstraPlanner,
    limits: Limits,
    fault: str = "",
    decide: Callable[..., Decision] = decide,
) -> Navigated:
    """The navigation, with a `fault` if one is named."""
    excluded, plans, lost = set[Vertex](), list[Decision](), 0
    path, searched, started = [], 0, False
    seen = robot.look() if fault == "looks at first only" else None
    interval = {"always looks": 1}.get(fault, limits.interval)
    limits = _limited(limits, fault)
    for step in range(limits.steps):
        turned = {"all steps": step, "looks late": searched + 1}.get(fault, searched)
        turned = 0 if fault == "looks late" and not searched else turned
        turned = searched + 1 if fault == "turns before it looks" else turned
        looks = searched == 0 if fault == "looks once" else turned % interval == 0
        over = fault == "no last look" and searched >= limits.search
        if (not path or fault == "replans all the time") and looks and not over:
            left = graph if fault == "excludes nothing" else without(graph, excluded)
            path, probability, reason = decide(left, *(seen or robot.look()), rules)
            plans.append((path, probability, reason))
            fresh = not excluded if fault == "by excluded" else not lost
            refuses = bool(path and reason) and (fresh or fault == "always refuses")
            refuses &= fault != "refuses the improbable only" or reason == "too improbable"
            refuses |= fault == "refuses without a path" and not path and fresh
            if refuses and fault == "turns on":
                path, refuses = [], False
            if path and reason and not fresh and fault == "never improbable":
                path = []
            if refuses and fault != "dares":
                return "refused", plans, excluded
            if not path and fault == "gives up at once":
                return "gave up", plans, excluded
        if not path:
            count = len(plans) if fault == "counts looks" else searched
            if count >= limits.search and fault != "searches for ever":
                return "gave up", plans, excluded
            robot.turn()
            searched += 1
            continue
        if fault == "follows later" and plans and looks and not started:
            started = True
            robot.turn()
            continue
        started = True
        before = robot.active if fault == "active too early" else 0
        state = robot.follow(path)
        if state == "arrived":
            return "arrived", plans, set() if fault == "forgets in the end" else excluded
        if state != "lost":
            continue
        lost += 1
        place = {
            "first": 1,
            "behind": robot.active - 1,
            "ahead": min(robot.active + 1, len(path) - 1),
        }
        place |= {"active too early": min(before, len(path) - 1)}
        vertex = path[place.get(fault, robot.active)]
        lost -= fault == "goal is free" and vertex == GOAL
        lost -= fault == "only the goal counts" and vertex != GOAL and lost > 1
        if fault == "gives up at the goal" and vertex == GOAL:
            return "gave up", plans, excluded
        if vertex == GOAL and fault == "goal":
            excluded.add(vertex)
        if fault == "forgets":
            excluded = set()
        if vertex not in (HERE, GOAL):
            itself = set() if fault == "not itself" else {vertex}
            excluded |= itself | _beside(graph, vertex, fault)
        if lost > limits.replans - (fault == "too few") + (fault == "too many"):
            return "gave up", plans, excluded
        if fault != "same path":
            path, searched = [], searched if fault == "searched before" else 0
            started = False
    return "gave up" if fault == "never late" else "late", plans, excluded


def _limited(limits: Limits, fault: str) -> Limits:
    """The limits, with the `fault`."""
    changes = {
        "search less": {"search": limits.search - 1},
        "search more": {"search": limits.search + 1},
        "steps less": {"steps": limits.steps - 1},
        "steps more": {"steps": limits.steps + 1},
    }
    return replace(limits, **changes.get(fault, {}))


def _beside(graph: Graph, vertex: Vertex, fault: str) -> set[Vertex]:
    """The vertices beside one: those that it leads to, and that lead back."""
    there, back = set(graph[vertex]), {v for v, out in graph.items() if vertex in out}
    if fault == "two away":
        return {v for near in (there & back) for v in {near} | _beside(graph, near, "")}
    return {"alone": set(), "out": there, "in": back, "either": there | back}.get(
        fault, there & back
    )


def _play(travels: Callable[..., Any], story: Story) -> tuple[Any, list[tuple[Any, ...]]]:
    """What a navigation returns, and the log of the robot."""
    robot, graph = ScriptedRobot(story), {v: dict(out) for v, out in story.graph.items()}
    answer = travels(robot, graph, story.rules, story.limits)
    if graph != story.graph:
        raise WrongAnswer("your function changes the map; plan on a copy, without(graph, excluded)")
    return answer, robot.log


def _invoke(what: str, student: Callable[..., Any], story: Story) -> Any:  # noqa: ANN401
    hints = {
        KeyError: "GOAL and HERE are no vertices of the map; graph[vertex] holds its edges",
        TypeError: "look() and turn() take nothing, follow(path) the path; active is a number",
    }
    return explaining(what, partial(_play, student, story), hints)


class _Example:
    """A robot that arrives after a second."""

    active = 1

    def __init__(self) -> None:
        self._steps = 0

    def look(self) -> tuple[dict[int, float], list[dict[int, float]]]:
        return {0: 0.9}, [{5: 0.99}]

    def turn(self) -> None: ...

    def follow(self, path: list[Vertex]) -> str:
        self._steps += 1
        return "going" if self._steps % 10 else "arrived"


_LINE: Graph = {v: {v + 1: 0.99} for v in range(5)} | {5: {}}


@check(
    navigate,
    (_Example(), _LINE, DijkstraPlanner(), Limits()),
    calls=10,
    endless="navigate: your function has not ended after {seconds:g} seconds. Count the steps in "
    "one place: each round of the loop is one step, and there are limits.steps at most",
)
def check_navigate(student: Callable[..., Any]) -> None:
    """Robots that arrive, search, refuse, are lost here and there, and run out of time."""
    faults = with_faults(_navigated, FAULTS)
    played = {words: partial(_play, rule) for words, rule in faults.items()}
    compare(
        "navigate",
        student,
        {name: (story,) for name, story in STORIES.items()},
        partial(_play, navigate),
        played,
        invoke=_invoke,
        form=_form,
        difference=_differ,
        broken=_broken,
    )


def _form(what: str, got: tuple[Any, list[Any]], *_: object) -> tuple[Any, ...]:
    """The outcome of a navigation in the right form, and the robot's log."""
    words = "return the ending, the list of plans, and the set of what is excluded"
    ending, plans, excluded = parts(what, got[0], 3, words)
    if not isinstance(ending, str) or ending not in ENDINGS:
        raise WrongAnswer(f"{what}: the ending {ending!r} came back; give one of {ENDINGS}")
    if not isinstance(plans, list | tuple) or any(
        not isinstance(plan, list | tuple)
        or len(plan) != 3
        or not isinstance(plan[0], list | tuple)
        for plan in plans
    ):
        raise WrongAnswer(f"{what}: plans is a list of what decide returned, a tuple of 3 each")
    if not isinstance(excluded, set | frozenset | list | tuple) or any(
        isinstance(vertex, list | set | dict) for vertex in excluded
    ):
        raise WrongAnswer(f"{what}: return the set of the vertices that are excluded")
    shown = [
        (list(path), round(number(what, probability, "as a probability"), 9), reason)
        for path, probability, reason in plans
    ]
    return ending, shown, set(excluded), got[1]


def _broken(got: tuple[Any, ...], want: tuple[Any, ...], *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    mine, right = got[3], want[3]
    common = next(
        (i for i, pair in enumerate(zip(mine, right, strict=False)) if len({*pair}) > 1), None
    )
    if common is not None:
        return (
            "one step is one turn or one follow; a search looks, then turns until a path is found"
        )
    if len(mine) != len(right):
        return {
            "arrived": "it goes on until the robot has arrived",
            "refused": "a path with a reason ends it, before it was ever lost",
            "gave up": "give up when lost once more than limits.replans, or after limits.search "
            "steps of turning in one search",
            "late": "each turn and each follow is a step; there are limits.steps of them",
        }[want[0]]
    if got[2] != want[2]:
        return "the vertex at robot.active is excluded, and those joined with it both ways"
    return "return the ending, everything that decide returned, and what is excluded"


def _differ(got: tuple[Any, ...], want: tuple[Any, ...], story: Story) -> str:
    """Where a navigation first goes another way."""
    for call, (mine, right) in enumerate(zip(got[3], want[3], strict=False)):
        if mine == right:
            continue
        when = f"in call {call + 1} of the robot"
        if mine[0] == right[0] == "follow":
            return f"{when} yours follows {list(mine[1:])}; {list(right[1:])} is right"
        before = want[3][call - 1][0] if call else ""
        why = _DUE[before == "follow"][right[0]]
        before = f", after {before}" if before else ""
        return f"{when} yours calls {mine[0]}, but {right[0]} is right{before}: {why}"
    if len(got[3]) != len(want[3]):
        least, rest = min(len(got[3]), len(want[3])), max(got[3], want[3], key=len)
        more = "goes on" if len(got[3]) > len(want[3]) else "ends"
        when = f"after {number_of(least, 'call')}"
        return f"{when} yours {more}, with {rest[least][0]} to come; {_end(want)}"
    if got[0] != want[0]:
        return f"the ending is {want[0]!r}, not {got[0]!r}"
    if got[2] != want[2]:
        return f"excluded is {sorted(got[2])}, but {sorted(want[2])} is right"
    return f"plans has length {len(got[1])}; keep all {len(want[1])} that decide returned"


_DUE = {
    False: {
        "look": "a look is due in the first step of a search, and every limits.interval steps of "
        "turning",
        "turn": "there is no path, and no other look is due yet",
        "follow": "there is a path that it may take",
    },
    True: {
        "look": "it was lost, and a search begins with a look: it stands elsewhere now",
        "turn": "it was lost",
        "follow": "it is on its way: nothing but follow until it arrives or is lost",
    },
}
"""Whether the call before was follow, and the right call: why it is due."""


def _end(want: tuple[Any, ...]) -> str:
    return f"it ends with {want[0]!r} after {number_of(len(want[3]), 'call')}"
