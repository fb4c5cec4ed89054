"""The check of the ends of a plan, in notebook 06."""

import math  # noqa: F401 - edits of the rule use it
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, kind
from tutorial_lib.checks.nb06.forms import number, untouched
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, SMALL_MAP, Graph, Vertex, random_graph


def join_ends(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    p_here: float,
    p_goal: float,
) -> Graph:
    """A graph with edges from `HERE` and to `GOAL`; see the exercise."""
    joined = {v: dict(out) for v, out in graph.items()} | {HERE: {}, GOAL: {}}
    for v, p in from_here.items():
        if v in graph and p > p_here:
            joined[HERE][v] = p
    reach: dict[Vertex, list[float]] = {}
    for image in to_goals:
        for v, p in image.items():
            reach.setdefault(v, []).append(p)
    for v, every in reach.items():
        p = max(every)
        if v in joined and p > p_goal:
            joined[v][GOAL] = p
    return joined


def _random_case(seed: int) -> tuple[Any, ...]:
    """A map of ten vertices, seen from here and seeing two images; two vertices are not on it."""
    rng = np.random.default_rng(seed)
    seen, *images = rng.uniform(0.0, 1.0, (3, 12)).round(2).tolist()
    to_goals = [{v - (v == 11) * (11 - HERE): p for v, p in enumerate(image)} for image in images]
    least = rng.uniform(0.1, 0.9, 2).round(2).tolist()
    return random_graph(10, 2, seed), dict(enumerate(seen)), to_goals, *least


_FROM = {0: 0.95, 1: 0.5, 2: 0.3, 4: 0.51}
_TO = {2: 0.99, 3: 0.5, 4: 0.985, 0: 0.1}
CASES = {
    "one goal image": case(SMALL_MAP, _FROM, [_TO], 0.5, 0.985),
    "one threshold": case(SMALL_MAP, _FROM, [_TO], 0.4, 0.4),
    "the goal is in sight": case(SMALL_MAP, _FROM, [{HERE: 0.99, 2: 0.7, 4: 0.995}], 0.5, 0.6),
    "three goal images": case(
        SMALL_MAP, _FROM, [{2: 0.7, 3: 0.99}, {2: 0.995, 1: 0.6}, {2: 0.9, 4: 0.5}], 0.5, 0.55
    ),
    "a vertex that is not on the map": case(
        SMALL_MAP, {0: 0.9, 7: 0.99}, [{2: 0.99, 7: 0.999}], 0.5, 0.9
    ),
    "the goal is hardly in sight": case(SMALL_MAP, _FROM, [{HERE: 0.7, 2: 0.99}], 0.5, 0.985),
    "nothing can be reached": case(SMALL_MAP, {0: 0.2}, [{1: 0.3}], 0.5, 0.9),
    "p_here above p_goal": case(SMALL_MAP, {0: 0.95, 1: 0.8}, [{2: 0.8, 3: 0.6}], 0.9, 0.5),
    "the first image gives the most": case(SMALL_MAP, {0: 0.9}, [{2: 0.99}, {2: 0.7}], 0.5, 0.6),
    "the goal is in sight of one image of two": case(
        SMALL_MAP, {0: 0.9}, [{HERE: 0.95}, {HERE: 0.3, 2: 0.9}], 0.5, 0.6
    ),
    "RE in sight equals p_goal": case(SMALL_MAP, {0: 0.9}, [{HERE: 0.9, 1: 0.9}], 0.5, 0.9),
    "no vertex is seen from here": case(SMALL_MAP, {}, [{2: 0.99}], 0.5, 0.9),
    "no goal image": case(SMALL_MAP, {0: 0.9}, [], 0.5, 0.9),
    "an empty map": case({}, {0: 0.9}, [{HERE: 0.9, 0: 0.9}], 0.5, 0.5),
    "thresholds of 0": case(SMALL_MAP, {0: 0.0, 1: 0.1}, [{2: 0.0, 3: 0.1}], 0.0, 0.0),
    "RE with many digits": case(
        SMALL_MAP, {0: 0.98765, 1: 0.50004, 3: 0.49996}, [{2: 0.98504, 3: 0.98496}], 0.5, 0.985
    ),
    "vertex 0 sees the goal": case(SMALL_MAP, {1: 0.9}, [{0: 0.95}], 0.5, 0.9),
} | {f"numbers drawn at random ({seed})": _random_case(seed) for seed in range(8)}
MISTAKES = """
edges lead from HERE to a vertex, and from a vertex to GOAL, not back
    joined[HERE][v] -> joined[v][HERE]
    joined[v][GOAL] -> joined[GOAL][v]
greater than the threshold, not equal to it
    p > p_here -> p >= p_here
    p > p_goal -> p >= p_goal
from HERE RE must be greater than p_here, not equal to it
    p > p_here -> p >= p_here
to GOAL RE must be greater than p_goal, not equal to it
    p > p_goal -> p >= p_goal
what is below the threshold is no edge
    p > p_here -> True
    p > p_goal -> True
p_here is for the edges from HERE, p_goal for those to GOAL; yours exchanges them
    joined = {v -> p_here, p_goal = p_goal, p_here; joined = {v
the edges from HERE have a threshold of their own, p_here
    p > p_here -> p > p_goal
the edges to GOAL have a threshold of their own, p_goal
    p > p_goal -> p > p_here
one goal image is enough: of several take the highest RE, not the last
    max(every) -> every[-1]
of several images that a vertex sees take the highest RE, not that of the last image
    max(every) -> next((q for q in reversed(every) if q > p_goal), 0.0)
of several images that a vertex sees take the highest RE, not that of the first image
    max(every) -> next((q for q in every if q > p_goal), 0.0)
of several images that a vertex sees take the highest RE, not the one that comes first
    max(every) -> every[0]
of several images that a vertex sees take the highest RE, not the least
    max(every) -> min(every)
one goal image is enough: take the highest RE; chances are not combined
    max(every) -> 1.0 - math.prod(1.0 - q for q in every)
one goal image above p_goal is enough; yours demands that all are
    p = max(every) -> p = max(every) if len(every) == len(to_goals) and min(every) > p_goal else 0.0
edges lead from a vertex to GOAL, joined[v][GOAL]; GOAL leads nowhere
    joined[v][GOAL] -> joined[GOAL][v]
edges lead from HERE to a vertex, joined[HERE][v], not back
    joined[HERE][v] -> joined[v][HERE]
edges lead from HERE to a vertex, not back as well
    joined[HERE][v] = p -> joined[HERE][v] = joined[v][HERE] = p
new edges hold RE, as the map's do; -log RE is taken by the planner
    joined[HERE][v] = p -> joined[HERE][v] = -math.log(p)
    joined[v][GOAL] = p -> joined[v][GOAL] = -math.log(p)
all vertices above p_goal are joined to GOAL, not only the best one
    reach.items() -> sorted(reach.items(), key=lambda item: -max(item[1]))[:1]
HERE is joined to all vertices above p_here, not only to the best one
    from_here.items() -> sorted(from_here.items(), key=lambda item: item[1])[-1:]
vertex 0 is a vertex of the map like the others; 0 is false in Python
    v in graph and -> v and v in graph and
    v in joined and -> v and v in joined and
vertex 0 is a vertex like the others, from HERE as well; 0 is false in Python
    v in graph and -> v and v in graph and
vertex 0 is a vertex like the others, on the way to GOAL as well; 0 is false in Python
    v in joined and -> v and v in joined and
a new edge holds its RE, not 1: above the threshold it is not sure yet
    joined[HERE][v] = p -> joined[HERE][v] = 1.0
    joined[v][GOAL] = p -> joined[v][GOAL] = 1.0
one goal image is enough: take the highest RE of them; the chances of several are not combined
    max(every) -> 1.0 - math.prod(1.0 - q for q in every) if max(every) > p_goal else 0.0
edges hold RE here; -log RE is taken by the planner
    return joined
        -> return {v: {w: -math.log(p) for w, p in out.items()} for v, out in joined.items()}
one goal image is enough; yours demands all of them
    max(every) -> min(every) if len(every) == len(to_goals) else 0.0
one goal image is enough; do not average over them
    max(every) -> sum(every) / len(every)
one goal image is enough; do not multiply
    max(every) -> math.prod(every)
all goal images count, not only the first one
    in to_goals -> in to_goals[:1]
a goal in sight needs no map: to_goals may contain HERE, too
    v in joined and -> v in graph and
only HERE may be in to_goals without being on the map; yours joins nothing from the map
    v in joined and -> v == HERE and
the edges to GOAL are made from to_goals, not from from_here
    in to_goals -> in [from_here]
the map's own edges stay, however doubtful they are: the thresholds are for the new ones
    dict(out) -> {w: p for w, p in out.items() if p > p_here}
the new graph has the map's edges, too
    dict(out) -> {}
the edge from HERE to GOAL leads to GOAL: p_goal counts
    p > p_goal -> p > (p_here if v == HERE else p_goal)
a vertex that is not in the graph must not come back through an edge to it
    v in graph and -> True and
    v in joined and -> True and
    joined[v][GOAL] -> joined.setdefault(v, {})[GOAL]
"""


def _graph(what: str, got: Any, *_: object) -> Graph:  # noqa: ANN401 - students'
    """An answer that is a graph with both ends."""
    if not isinstance(got, dict) or not all(isinstance(out, dict) for out in got.values()):
        words = "return a dictionary of dictionaries, as the graph is"
        raise WrongAnswer(f"{what}: {kind(got)} came back; {words}")
    for vertex, name in ((HERE, "HERE"), (GOAL, "GOAL")):
        if vertex not in got:
            raise WrongAnswer(
                f"{what}: {name} is missing; it is a vertex of the new graph, even with no edges"
            )
    return {
        v: {w: number(what, p, f"as RE from {v} to {w}") for w, p in out.items()}
        for v, out in got.items()
    }


def _broken(got: Graph, want: Graph, graph: Graph, *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    if any(got.get(v, {}).get(w) != p for v, out in graph.items() for w, p in out.items()):
        return "the map's own vertices and edges stay as they are"
    if got.keys() != want.keys():
        return "the new graph has the vertices of the map, HERE and GOAL, and no others"
    if any(got[v].keys() != out.keys() for v, out in want.items()):
        return (
            "an edge from HERE or to GOAL needs an RE above its threshold, and a vertex that is on "
            "the map (or HERE, in to_goals)"
        )
    return "a new edge holds RE as it is, the greatest of all goal images"


def _unlike(got: Graph, want: Graph, *case: Any) -> str:  # noqa: ANN401
    """The first edge that is missing, too many or wrong, and why."""
    graph, from_here, to_goals, p_here, p_goal = case
    names = {HERE: "HERE", GOAL: "GOAL"}
    for vertex in want:
        if vertex not in got:
            return f"vertex {vertex} is missing, which was on the map"
        for other in [*want[vertex], *got[vertex]]:
            step = f"from {names.get(vertex, vertex)} to {names.get(other, other)}"
            yours, right = got[vertex].get(other), want[vertex].get(other)
            if yours == right:
                continue
            given = [from_here.get(other)] if vertex == HERE and other != GOAL else []
            if other == GOAL:
                given = [image.get(vertex) for image in to_goals]
            shown = ", ".join(f"{p:.6g}" for p in given if p is not None)
            least = f"p_goal is {p_goal:g}" if other == GOAL else f"p_here is {p_here:g}"
            why = f"RE is {shown}, and {least}" if shown else "the map has it" if right else ""
            if yours is None:
                return f"the edge {step} is missing: {why}"
            if right is None:
                strange = {vertex, other} - {*graph, HERE, GOAL}
                why = f"{strange.pop()} is no vertex of the map" if strange else why
                return f"there must be no edge {step}: {why or 'nothing says so'}"
            near = abs(yours - right) < 0.009
            why += "; is it rounded? RE stays as it is" if near else "; an edge holds its RE"
            return f"the edge {step} has {yours:.6g}, but {right:.6g} is right: {why}"
    extra = [vertex for vertex in got if vertex not in want]
    return f"vertices {extra} are not on the map, and are no vertices of the new graph"


_NONE = "there may be no goal image: an empty list has no element, and max() of nothing fails"
_SHARED = (
    "the new graph shares inner dictionaries with the map; copy those of all vertices: who changes "
    "the new graph must not change the map"
)
check_join_ends = exercise(
    join_ends,
    CASES,
    MISTAKES,
    about="One goal image and several, thresholds, a goal in sight, vertices that are not there.",
    example=case(random_graph(80, 4, 3), dict.fromkeys(range(80), 0.9), [{5: 0.99}], 0.5, 0.9),
    invoke=untouched(join_ends, {IndexError: _NONE, ValueError: _NONE}, _SHARED),
    form=_graph,
    difference=_unlike,
    broken=_broken,
)
