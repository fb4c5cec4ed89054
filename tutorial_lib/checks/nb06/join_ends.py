"""The check of the ends of a plan, in notebook 06."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, SMALL_MAP, Graph, Vertex, random_graph
from tutorial_lib.checks.nb06.untouched import untouched


def join_ends(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    p_here: float,
    p_goal: float,
) -> Graph:
    """A graph with edges from `HERE` and to `GOAL`.

    Args:
        graph: of a map.
        from_here: RE from here to vertices.
        to_goals: for each goal image, RE to it from vertices, and from `HERE`.
        p_here: above which there is an edge from here.
        p_goal: above which there is an edge to the goal.
    """
    return _joined(graph, from_here, to_goals, p_here, p_goal)


def _joined(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    p_here: float,
    p_goal: float,
    fault: str = "",
) -> Graph:
    """The graph, with a `fault` if one is named."""
    if fault == "exchanged":
        p_here, p_goal = p_goal, p_here
    p_here = p_goal if fault == "p_goal only" else p_here
    p_goal = p_here if fault == "p_here only" else p_goal
    joined = {v: dict(out) for v, out in graph.items()}
    joined |= {HERE: {}, GOAL: {}}

    def connect(v: Vertex, w: Vertex, p: float, least: float) -> None:
        if fault == "backwards":
            v, w = w, v
        if fault == "p_here in sight" and v == HERE:
            least = p_here
        enough = p >= least if fault == "equal" else p > least or fault == "all"
        if ((v in joined and w in joined) or fault == "ghosts") and enough:
            joined.setdefault(v, {})[w] = p

    for vertex, probability in from_here.items():
        connect(HERE, vertex, probability, p_here)
    reach: dict[Vertex, list[float]] = {}
    for image in to_goals[:1] if fault == "first image" else to_goals:
        for vertex, probability in image.items():
            reach.setdefault(vertex, []).append(probability)
    combine: dict[str, Callable[[list[float]], float]] = {
        "last": lambda p: p[-1],
        "least": lambda p: min(p) if len(p) == len(to_goals) else 0.0,
        "mean": lambda p: sum(p) / len(p),
        "product": math.prod,
    }
    for vertex, probabilities in reach.items():
        if fault == "not directly" and vertex == HERE:
            continue
        connect(vertex, GOAL, combine.get(fault, max)(probabilities), p_goal)
    return joined


_FROM = {0: 0.95, 1: 0.5, 2: 0.3, 4: 0.51}
_TO = {2: 0.99, 3: 0.5, 4: 0.985, 0: 0.1}
_CASES: dict[str, tuple[Any, ...]] = {
    "one goal image": (SMALL_MAP, _FROM, [_TO], 0.5, 0.985),
    "one threshold": (SMALL_MAP, _FROM, [_TO], 0.4, 0.4),
    "the goal is in sight": (SMALL_MAP, _FROM, [{HERE: 0.99, 2: 0.7, 4: 0.995}], 0.5, 0.6),
    "three goal images": (
        SMALL_MAP,
        _FROM,
        [{2: 0.7, 3: 0.99}, {2: 0.995, 1: 0.6}, {2: 0.9, 4: 0.5}],
        0.5,
        0.55,
    ),
    "a vertex that is not on the map": (
        SMALL_MAP,
        {0: 0.9, 7: 0.99},
        [{2: 0.99, 7: 0.999}],
        0.5,
        0.9,
    ),
    "the goal is hardly in sight": (SMALL_MAP, _FROM, [{HERE: 0.7, 2: 0.99}], 0.5, 0.985),
    "nothing can be reached": (SMALL_MAP, {0: 0.2}, [{1: 0.3}], 0.5, 0.9),
}
_FAULTS = {
    "edges lead from HERE to a vertex, and from a vertex to GOAL, not back": "backwards",
    "greater than the threshold, not equal to it": "equal",
    "what is below the threshold is no edge": "all",
    "p_here is for the edges from HERE, p_goal for those to GOAL; yours exchanges them": (
        "exchanged"
    ),
    "the edges from HERE have a threshold of their own, p_here": "p_goal only",
    "the edges to GOAL have a threshold of their own, p_goal": "p_here only",
    "one goal image is enough: of several take the highest RE, not the last": ("last"),
    "one goal image is enough; yours demands all of them": "least",
    "one goal image is enough; do not average over them": "mean",
    "one goal image is enough; do not multiply": "product",
    "all goal images count, not only the first one": "first image",
    "a goal in sight needs no map: to_goals may contain HERE, too": "not directly",
    "the edge from HERE to GOAL leads to GOAL: p_goal counts": "p_here in sight",
    "a vertex that is not in the graph must not come back through an edge to it": "ghosts",
}


@check(join_ends, (random_graph(80, 4, 3), dict.fromkeys(range(80), 0.9), [{5: 0.99}], 0.5, 0.9))
def check_join_ends(student: Callable[..., Any]) -> None:
    """One goal image and several, thresholds, a goal in sight, and vertices that are not there."""
    faults = with_faults(_joined, _FAULTS)
    compare(
        "join_ends",
        student,
        _CASES,
        join_ends,
        faults,
        invoke=untouched,
        form=_graph,
        difference=_unlike,
    )


def _graph(what: str, got: Any, *_: object) -> Graph:  # noqa: ANN401 - students'
    """An answer that is a graph with both ends."""
    if not isinstance(got, dict) or not all(isinstance(out, dict) for out in got.values()):
        raise WrongAnswer(f"{what}: return a dictionary of dictionaries, as the graph is")
    for vertex, name in ((HERE, "HERE"), (GOAL, "GOAL")):
        if vertex not in got:
            raise WrongAnswer(
                f"{what}: {name} is missing; it is a vertex of the new graph, even with no edges"
            )
    return got


def _unlike(got: Graph, want: Graph, *_: object) -> str:
    """The first edge that is missing, too many or wrong."""
    names = {HERE: "HERE", GOAL: "GOAL"}
    for vertex in want:
        if vertex not in got:
            return f"vertex {vertex} is missing, which was on the map"
        for other in sorted({*want[vertex], *got[vertex]}):
            step = f"from {names.get(vertex, vertex)} to {names.get(other, other)}"
            yours, right = got[vertex].get(other), want[vertex].get(other)
            if yours is None:
                return f"the edge {step} is missing"
            if right is None:
                return f"there must be no edge {step}"
            if yours != right:
                return f"the edge {step} has {yours:.4g}, but {right:.4g} is right"
    extra = sorted(set(got) - set(want))
    return f"vertices {extra} are not on the map"
