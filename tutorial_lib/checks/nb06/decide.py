"""The check of setting out or refusing, in notebook 06."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb06.graphs import (
    GOAL,
    HERE,
    SMALL_MAP,
    Graph,
    Vertex,
    most_probable_path,
    random_graph,
)
from tutorial_lib.checks.nb06.join_ends import join_ends
from tutorial_lib.checks.nb06.untouched import untouched
from tutorial_lib.topology.planner import DijkstraPlanner

Decision = tuple[list[Vertex], float, str]
"""A way, its probability, and why not to set out; empty if one should."""
REASONS = ("", "too improbable", "not on the map", "no way")


def decide(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    rules: DijkstraPlanner,
) -> Decision:
    """The best way, its probability, and why not to set out; see `join_ends`.

    Args:
        graph: of a map.
        from_here: RE from here to vertices.
        to_goals: for each picture of the goal, RE to it.
        rules: `p_query`, `p_goal` and `least`.
    """
    return _decided(graph, from_here, to_goals, rules)


def _decided(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    rules: DijkstraPlanner,
    fault: str = "",
) -> Decision:
    """The decision, with a `fault` if one is named."""

    def found(p_goal: float) -> tuple[list[Vertex], float]:
        p_here = rules.p_goal if fault == "p_goal from here" else rules.p_query
        joined = join_ends(graph, from_here, to_goals, p_here, p_goal)
        way, probability = most_probable_path(joined, HERE, GOAL)
        if fault == "last step" and way:
            return way, joined[way[-2]][GOAL]
        return way, probability

    way, probability = found(rules.p_query if fault in ("trusts", "asks last") else rules.p_goal)
    if fault == "asks last" and way and len(way) > 1:
        edge = max(picture.get(way[-2], 0.0) for picture in to_goals)
        if edge <= rules.p_goal:
            return way, probability, "not on the map"
    if way:
        enough = probability >= rules.least or fault == "dares"
        if fault == "strict":
            enough = probability > rules.least
        if fault == "p_goal for all":
            enough = probability > rules.p_goal
        if not enough and fault == "empty":
            return [], 0.0, "too improbable"
        return way, probability, "" if enough else "too improbable"
    if fault == "never why":
        return [], 0.0, "no way"
    way, probability = found(rules.p_query)
    if fault == "seen somewhere" and any(max(told.values()) > rules.p_goal for told in to_goals):
        return way, probability, "no way"
    reason = "not on the map" if way or fault == "always unknown" else "no way"
    return ([], 0.0, reason) if fault == "empty" else (way, probability, reason)


_RULES = DijkstraPlanner(least=0.5, p_query=0.5, p_goal=0.985)
_OTHER_RULES = DijkstraPlanner(least=0.8, p_query=0.6, p_goal=0.9)
_LONG: Graph = {v: {v + 1: 0.9} for v in range(8)} | {8: {}}
_APART: Graph = {0: {}, 1: {}}
_FORK: Graph = {0: {1: 0.99, 2: 0.9}, 1: {}, 2: {}}
_HALF: Graph = {0: {1: 0.5}, 1: {}}
_ASKED: dict[str, tuple[Any, ...]] = {
    "a goal of this map": (SMALL_MAP, {0: 0.95}, [{2: 0.99}], _RULES),
    "a goal from elsewhere": (SMALL_MAP, {0: 0.95}, [{2: 0.9, 3: 0.97}], _RULES),
    "a long way": (_LONG, {0: 0.99}, [{8: 0.99}], _RULES),
    "two ends of the way": (_FORK, {0: 0.99}, [{1: 0.98, 2: 0.99}], _RULES),
    "exactly as probable as needed": (_HALF, {0: 1.0}, [{1: 1.0}], _RULES),
    "the map is not reached from here": (SMALL_MAP, {0: 0.4}, [{2: 0.99}], _RULES),
    "the goal is not reached from the map": (SMALL_MAP, {0: 0.95}, [{2: 0.3}], _RULES),
    "a long way to a goal from elsewhere": (_LONG, {0: 0.99}, [{8: 0.9}], _RULES),
    "no way to where it is seen": (_APART, {0: 0.9}, [{0: 0.6, 1: 0.99}], _RULES),
    "the goal is in sight": (SMALL_MAP, {0: 0.95}, [{HERE: 0.999, 2: 0.99}], _RULES),
    "other rules": (SMALL_MAP, {0: 0.7}, [{0: 0.92, 2: 0.95}], _OTHER_RULES),
    "other rules, a goal from elsewhere": (SMALL_MAP, {0: 0.7}, [{2: 0.8}], _OTHER_RULES),
}
_UNDECIDED = {
    "yours sets out to a goal that is nowhere reached with more than rules.p_goal; that is to be "
    "asked of the edges to the goal, not of the way": "trusts",
    "plan with edges to the goal above rules.p_goal first. Yours plans with all of them, and "
    "refuses where the best way ends with a doubtful one though a surer one leads there": (
        "asks last"
    ),
    "p_goal is for the edges to the goal; from here rules.p_query is enough": "p_goal from here",
    "a way that is less probable than rules.least is too improbable": "dares",
    "exactly rules.least is enough": "strict",
    "the whole way must have rules.least, not rules.p_goal; that is for the edges to the goal": (
        "p_goal for all"
    ),
    "return the probability of the whole way, not only that of its last step": "last step",
    "there is a way to a vertex that shows the goal doubtfully; say so: not on the map": (
        "never why"
    ),
    "there is no way with rules.p_goal; whether there is one with rules.p_query tells the reason, "
    "wherever the goal is seen": "seen somewhere",
    "where even with rules.p_query there is no way, the reason is no way": "always unknown",
    "who refuses tells the way and its probability all the same": "empty",
}


@check(decide, (random_graph(80, 4, 3), {0: 0.9, 1: 0.9}, [{5: 0.99}], _RULES))
def check_decide(student: Callable[..., Any]) -> None:
    """Goals near and far, from this world and another, and starts from which nothing is seen."""
    faults = with_faults(_decided, _UNDECIDED)
    compare(
        "decide",
        student,
        _ASKED,
        decide,
        faults,
        ask=untouched,
        form=_decision,
        difference=_unlike,
    )


def _decision(what: str, got: Any, *_: object) -> Decision:  # noqa: ANN401 - students'
    """A decision of the right form, its probability rounded."""
    way, probability, reason = parts(what, got, 3, "return the way, its probability and the reason")
    if reason not in REASONS:
        raise WrongAnswer(f"{what}: the reason {reason!r} came back; give one of {REASONS}")
    return list(way), round(float(probability), 9), reason


def _unlike(got: Decision, want: Decision, *_: object) -> str:
    shown = [f"{d[2] or 'sets out'!r}, way {d[0]} with {d[1]:.3g}" for d in (got, want)]
    return f"yours says {shown[0]}; {shown[1]} is right"
