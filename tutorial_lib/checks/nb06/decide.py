"""The check of starting or refusing, in notebook 06."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb06.decide_cases import CASES, RULES
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Graph, Vertex, random_graph
from tutorial_lib.checks.nb06.join_ends import join_ends
from tutorial_lib.checks.nb06.most_probable_path import Found, most_probable_path
from tutorial_lib.checks.nb06.untouched import number, untouched, vertices
from tutorial_lib.topology.planner import DijkstraPlanner

Decision = tuple[list[Vertex], float, str]
"""A path, its probability, and the reason to refuse; empty to start."""
REASONS = ("", "too improbable", "not on the map", "no path")


def decide(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    rules: DijkstraPlanner,
    join_ends: Callable[..., Graph] = join_ends,
    most_probable_path: Callable[..., Found] = most_probable_path,
) -> Decision:
    """The best path, its probability, and the reason to refuse; see `join_ends`.

    Args:
        graph: of a map.
        from_here: RE from here to vertices.
        to_goals: for each goal image, RE to it.
        rules: `p_query`, `p_goal` and `least`.
        join_ends: adds the edges of both ends.
        most_probable_path: plans.
    """
    parts = join_ends, most_probable_path
    return _decided(graph, from_here, to_goals, rules, parts=parts)


def _decided(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    rules: DijkstraPlanner,
    fault: str = "",
    parts: tuple[Callable[..., Graph], Callable[..., Found]] = (join_ends, most_probable_path),
) -> Decision:
    """The decision, with a `fault` if one is named."""
    if fault in _BY_OTHER_RULES:
        return _BY_OTHER_RULES[fault](graph, from_here, to_goals, rules)

    def found(p_goal: float) -> tuple[list[Vertex], float]:
        p_here = rules.p_goal if fault == "p_goal from here" else rules.p_query
        p_here = 0.0 if p_goal == 0.0 else p_here  # the fault "no threshold"
        joined = parts[0](graph, from_here, to_goals, p_here, p_goal)
        path, probability = parts[1](joined, HERE, GOAL)
        if fault == "last step" and path:
            return path, joined[path[-2]][GOAL]
        return path, probability

    if fault == "constants":
        rules = DijkstraPlanner(least=0.5, p_query=0.5, p_goal=0.985)

    def joined_edges(path: list[Vertex]) -> list[float]:
        joined = join_ends(graph, from_here, to_goals, rules.p_query, rules.p_goal)
        return [joined[v][w] for v, w in pairwise(path)]

    path, probability = found(rules.p_query if fault in ("trusts", "asks last") else rules.p_goal)
    if fault == "asks last" and path and len(path) > 1:
        edge = max(reach.get(path[-2], 0.0) for reach in to_goals)
        if edge <= rules.p_goal:
            return path, probability, "not on the map"
    if path or fault == "least first":
        enough = probability >= rules.least or fault == "dares"
        if fault == "each edge":
            enough = min(joined_edges(path)) >= rules.least
        if fault == "strict":
            enough = probability > rules.least
        if fault == "rounded":
            enough = round(probability, 2) >= rules.least
        if fault == "weakest" and path:
            probability = min(joined_edges(path))
            enough = probability >= rules.least
        if fault == "path of the second plan" and not enough:
            path, probability = found(rules.p_query)
        if fault == "p_goal for all":
            enough = probability > rules.p_goal
        if not enough and fault == "empty":
            return [], 0.0, "too improbable"
        return path, probability, "" if enough else "too improbable"
    if fault == "never why":
        return [], 0.0, "no path"
    path, probability = found(0.0 if fault == "no threshold" else rules.p_query)
    if fault == "second chance" and path and probability >= rules.least:
        return path, probability, ""
    if fault == "seen somewhere" and any(
        p > rules.p_goal for reach in to_goals for p in reach.values()
    ):
        return path, probability, "no path"
    reason = "not on the map" if path or fault == "always unknown" else "no path"
    if fault == "exchanged":
        reason = "no path" if path else "not on the map"
    if fault == "improbable, too" and path and probability < rules.least:
        reason = "too improbable"
    return ([], 0.0, reason) if fault == "empty" else (path, probability, reason)


def _planned(graph: Graph, *case: Any) -> Found:  # noqa: ANN401
    return most_probable_path(join_ends(graph, *case), HERE, GOAL)


def _otherwise(
    first: tuple[str, str], second: tuple[str, str] = ("p_query", "p_query"), again: bool = False
) -> Callable[..., Decision]:
    """The decision by other thresholds at both ends; with `again`, least decides on a new plan."""

    def rule(graph: Graph, here: Any, goals: Any, rules: DijkstraPlanner) -> Decision:  # noqa: ANN401
        pairs = [[getattr(rules, name, 0.0) for name in names] for names in (first, second)]
        path, p = _planned(graph, here, goals, *pairs[0])
        if path and (p >= rules.least or not again):
            return path, p, "" if p >= rules.least else "too improbable"
        path, p = _planned(graph, here, goals, *pairs[1])
        return path, p, "not on the map" if path else "no path"

    return rule


def _emptied(*reasons: str) -> Callable[..., Decision]:
    """The decision without the path, for some reasons."""

    def rule(*case: Any) -> Decision:  # noqa: ANN401
        path, p, reason = decide(*case)
        return ([], 0.0, reason) if reason in reasons else (path, p, reason)

    return rule


_USUAL = "p_query", "p_goal"
_BY_OTHER_RULES: dict[str, Callable[..., Decision]] = {
    "goal at both": _otherwise(("p_goal", "p_goal")),
    "ends exchanged": _otherwise(("p_goal", "p_query")),
    "again": _otherwise(_USUAL, again=True),
    "anything to the goal": _otherwise(_USUAL, ("p_query", "none")),
    "goal from here again": _otherwise(_USUAL, ("p_goal", "p_query")),
    "no second path": _emptied("not on the map"),
    "no improbable path": _emptied("too improbable"),
    "refused without path": lambda *case: (
        ([], *decide(*case)[1:]) if decide(*case)[2] == "too improbable" else decide(*case)
    ),
    "refused without probability": lambda *case: (
        (decide(*case)[0], 0.0, "too improbable")
        if decide(*case)[2] == "too improbable"
        else decide(*case)
    ),
    "first image": lambda graph, here, goals, rules: decide(graph, here, goals[:1], rules),
    "never directly": lambda graph, here, goals, rules: decide(
        graph, here, [{v: p for v, p in image.items() if v != HERE} for image in goals], rules
    ),
    "p_query is 0.5": lambda graph, here, goals, rules: decide(
        graph, here, goals, DijkstraPlanner(rules.least, 0.5, rules.p_goal)
    ),
    "p_goal is 0.985": lambda graph, here, goals, rules: decide(
        graph, here, goals, DijkstraPlanner(rules.least, rules.p_query, 0.985)
    ),
    "inner path": lambda *case: (decide(*case)[0][1:-1], *decide(*case)[1:]),
    "half": lambda graph, here, goals, rules: decide(
        graph, here, goals, DijkstraPlanner(0.5, rules.p_query, rules.p_goal)
    ),
}


_FAULTS = {
    "yours starts towards a goal that no vertex reaches with more than rules.p_goal; compare the "
    "edges to the goal with it, not the path": "trusts",
    "plan with edges to the goal above rules.p_goal first. Yours plans with all of them, and "
    "refuses where the best path ends with a doubtful one although a surer one leads there": (
        "asks last"
    ),
    "p_goal is for the edges to the goal; from here rules.p_query is enough": "p_goal from here",
    "from here rules.p_query is enough in the first plan, too; rules.p_goal is for the edges to "
    "the goal": "goal at both",
    "from here rules.p_query, to the goal rules.p_goal; yours exchanges them": "ends exchanged",
    "a path that is too improbable is the end; plan again only where there is none": "again",
    "in the second plan RE to the goal must be above rules.p_query as well": (
        "anything to the goal"
    ),
    "in the second plan rules.p_query counts at both ends, from here as well": (
        "goal from here again"
    ),
    "return the path of the second plan and its probability, though the robot refuses": (
        "no second path"
    ),
    "return a path that is too improbable, and its probability, all the same": (
        "no improbable path"
    ),
    "the path leads from HERE to GOAL; both belong to it": "inner path",
    "rules.least is not always 0.5": "half",
    "rules.p_query is not always 0.5": "p_query is 0.5",
    "rules.p_goal is not always 0.985": "p_goal is 0.985",
    "return the path also where it is too improbable: the user may overrule it": (
        "refused without path"
    ),
    "return the probability also where it is too low: the user wants to see it": (
        "refused without probability"
    ),
    "where the first plan is too improbable, its own path and probability are returned": (
        "path of the second plan"
    ),
    "compare the probability as it is, not rounded, with rules.least": "rounded",
    "the probability of a path is the product of its edges, not the weakest of them": "weakest",
    "all goal images count; yours looks at the first only": "first image",
    "the goal may be in sight: the edge from HERE to GOAL is a path as well": "never directly",
    "a path that is less probable than rules.least is too improbable": "dares",
    "exactly rules.least is enough": "strict",
    "the thresholds stand in rules, and are not always the same: rules.p_query, rules.p_goal and "
    "rules.least": "constants",
    "plan again with rules.p_query at both ends; yours drops every threshold": "no threshold",
    "the two reasons are exchanged: a path with rules.p_query means not on the map": "exchanged",
    "where the second plan finds a path, the reason is not on the map, however improbable it is": (
        "improbable, too"
    ),
    "rules.least is for the whole path, not for each of its edges": "each edge",
    "no path at all is not too improbable: is there a path? That comes first": "least first",
    "the second plan only gives the reason: with edges to the goal below rules.p_goal the robot "
    "does not start, however probable the path is": "second chance",
    "the whole path must have rules.least, not rules.p_goal; that is for the edges to the goal": (
        "p_goal for all"
    ),
    "return the probability of the whole path, not only that of its last step": "last step",
    "there is a path to a vertex from which RE to the goal is doubtful; return the reason: not on "
    "the map": ("never why"),
    "there is no path with rules.p_goal; the reason depends on whether there is one with "
    "rules.p_query, wherever the goal is seen": "seen somewhere",
    "where even with rules.p_query there is no path, the reason is no path": "always unknown",
    "return the path and its probability also when the robot refuses": "empty",
}


@check(decide, (random_graph(80, 4, 3), {0: 0.9, 1: 0.9}, [{5: 0.99}], RULES))
def check_decide(student: Callable[..., Any]) -> None:
    """Goals near and far, here and elsewhere, starts from nowhere, and rules of all kinds."""
    faults = with_faults(_decided, _FAULTS)
    compare(
        "decide",
        student,
        CASES,
        decide,
        faults,
        invoke=partial(untouched, names=["graph", "from_here", "to_goals", "rules"]),
        form=_decision,
        difference=_unlike,
    )


def _decision(what: str, got: Any, graph: Graph, *_: object) -> Decision:  # noqa: ANN401
    """A decision of the right form, its probability rounded."""
    path, probability, reason = parts(
        what, got, 3, "return the path, its probability and the reason"
    )
    if not isinstance(reason, str) or reason not in REASONS:
        raise WrongAnswer(f"{what}: the reason {reason!r} came back; give one of {REASONS}")
    path = vertices(what, path, {*graph, HERE, GOAL}, "as the path")
    return path, round(number(what, probability, "as the probability"), 9), reason


def _unlike(
    got: Decision,
    want: Decision,
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    rules: DijkstraPlanner,
) -> str:
    """What is wrong with a decision, and what leads to the right one."""
    shown = [f"{d[2] or 'start'!r}, path {d[0]} with {d[1]:.3g}" for d in (got, want)]
    joined = join_ends(graph, from_here, to_goals, rules.p_query, rules.p_goal)
    if most_probable_path(joined, HERE, GOAL)[0]:
        why = f"with edges to GOAL above p_goal = {rules.p_goal:g} there is a path, and its "
        why += f"probability decides: least is {rules.least:g}"
    elif want[0]:
        why = f"with p_goal = {rules.p_goal:g} there is no path, but with p_query = "
        why += f"{rules.p_query:g} at both ends there is one"
    else:
        why = f"even with p_query = {rules.p_query:g} at both ends there is no path"
    if want[0] == [HERE, GOAL] != got[0]:
        why = "the goal is in sight, and the edge from HERE to GOAL alone is the best path"
    if got[0] == want[0][1:-1] and want[0]:
        why = "HERE and GOAL belong to the path"
    if got[2] == want[2] and got[0] == want[0]:
        why = "the probability is that of the whole path"
    return f"yours returns {shown[0]}; {shown[1]} is right: {why}"
