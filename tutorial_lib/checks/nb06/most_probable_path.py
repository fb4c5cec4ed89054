"""The check of the most probable way over a graph, in notebook 06."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.framework.timeout import within_line_limit
from tutorial_lib.checks.nb06.graphs import (
    BY_HAND,
    Graph,
    Vertex,
    Way,
    most_probable_path,
    probability_of,
    random_graph,
)
from tutorial_lib.checks.nb06.path_faults import MISTAKES
from tutorial_lib.viz.figures.panels import side_by_side
from tutorial_lib.viz.figures.planning_graphs import graph_picture

_ENDLESS = (
    "most_probable_path: your function never ends. Each vertex is dealt with once, when it is "
    "taken from the heap for the first time; and no length may be below 0, as -RE is: going round "
    "a circle would make a way shorter, and from where one came would lead round it, too"
)
_LINE: Graph = {0: {1: 0.9}, 1: {2: 0.8}, 2: {3: 0.95}, 3: {}}
_SURE: Graph = {0: {1: 1.0, 2: 0.9}, 1: {0: 1.0, 2: 1.0}, 2: {3: 1.0}, 3: {1: 1.0}}
_LATE: Graph = {0: {1: 0.5, 2: 0.95}, 1: {4: 0.99}, 2: {3: 0.95, 4: 0.6}, 3: {1: 0.95}, 4: {}}
_CASES: dict[str, tuple[Graph, Vertex, Vertex]] = {
    "the graph above": (BY_HAND, "here", "goal"),
    "a chain": (_LINE, 0, 3),
    "edges that are sure": (_SURE, 0, 3),
    "a better way found late": (_LATE, 0, 4),
    "30 vertices": (random_graph(30, 3, 1), 0, 29),
    "60 vertices": (random_graph(60, 4, 2), 5, 17),
    "40 vertices": (random_graph(40, 6, 8), 3, 30),
    "start and goal are one": (_LINE, 2, 2),
    "an edge leads the other way only": (_LINE, 3, 0),
}


@check(most_probable_path, (random_graph(80, 4, 3), 0, 79))
def check_most_probable_path(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """The graph done by hand, chains, cycles, larger graphs, and goals that cannot be reached."""
    return compare(
        "most_probable_path",
        student,
        _CASES,
        most_probable_path,
        MISTAKES,
        ask=_ask,
        form=_path,
        same=_same,
        difference=_apart,
        draw=_graphs,
    )


def _graphs(want: Way, got: Way) -> NDArray[np.uint8]:
    return side_by_side(
        [graph_picture(BY_HAND, way) for way, _ in (want, got)], ["target", "yours"]
    )


def _ask(what: str, student: Callable[..., Any], graph: Graph, *ends: Vertex) -> Any:  # noqa: ANN401
    """A student's answer, if it comes to an end and leaves the graph as it is."""
    given = {v: dict(out) for v, out in graph.items()}
    try:
        got = within_line_limit(student, given, *ends, otherwise=_ENDLESS)
    except (KeyError, IndexError) as error:
        words = "where the goal cannot be reached there is no way back from it; return [], 0.0"
        words = words if not most_probable_path(graph, *ends)[0] else "is there such a vertex?"
        raise WrongAnswer(f"{what}: {type(error).__name__}, {error}; {words}") from None
    if given != graph:
        raise WrongAnswer(f"{what}: your function changes the graph; leave it as it is")
    return got


def _path(what: str, got: Any, *_: object) -> Way:  # noqa: ANN401 - students'
    """A way and its probability, from an answer of the right form."""
    way, probability = parts(what, got, 2, "return the way and its probability")
    if not isinstance(way, tuple | list):
        raise WrongAnswer(f"{what}: {way!r} came back as the way; return a list of vertices")
    if not isinstance(probability, float | int | np.number):
        kind = type(probability).__name__
        raise WrongAnswer(f"{what}: a {kind} came back as the probability; return a number")
    return list(way), float(probability)


def _same(got: Way, want: Way, graph: Graph, *_: Vertex) -> bool:
    """Whether two answers are as good; of ways that are as probable either will do."""
    if not math.isclose(got[1], want[1], abs_tol=1e-9):
        return False
    if got[0] == want[0]:
        return True
    steps = list(pairwise(got[0]))
    there = bool(steps) and all(w in graph.get(v, {}) for v, w in steps)
    ends = there and got[0][0] == want[0][0] and got[0][-1] == want[0][-1] if want[0] else False
    return ends and math.isclose(probability_of(graph, got[0]), want[1], abs_tol=1e-9)


def _apart(got: Way, want: Way, graph: Graph, *_: Vertex) -> str:
    """What is wrong with an answer."""
    way, told = got
    if not want[0]:
        return f"{way}, {told:.3g} came back; no way leads there: return [], 0.0"
    shown = f"{_spoken(want[0])} has probability {want[1]:.4g}"
    if not way:
        return f"yours finds no way; {shown}"
    if way[0] != want[0][0] or way[-1] != want[0][-1]:
        return f"the way begins with the start and ends with the goal, as in {_spoken(want[0])}"
    gaps = [(v, w) for v, w in pairwise(way) if w not in graph.get(v, {})]
    if gaps:
        return f"yours goes from {gaps[0][0]} to {gaps[0][1]}, where no edge leads"
    if not math.isclose(probability_of(graph, way), told, abs_tol=1e-9):
        return f"along {_spoken(way)} the product of RE is {probability_of(graph, way):.4g}; " + (
            f"yours says {told:.4g}"
        )
    return f"yours takes {_spoken(way)} with {told:.4g}; {shown}"


def _spoken(way: list[Vertex]) -> str:
    return " > ".join(map(str, way))
