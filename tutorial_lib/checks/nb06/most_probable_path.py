"""The check of the most probable path over a graph, in notebook 06."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.nb06.graphs import (
    BY_HAND,
    Found,
    Graph,
    Vertex,
    most_probable_path,
    probability_of,
    random_graph,
)
from tutorial_lib.checks.nb06.path_faults import FAULTS
from tutorial_lib.checks.nb06.untouched import explaining, number, vertices
from tutorial_lib.viz.figures.panels import side_by_side
from tutorial_lib.viz.figures.planning_graphs import graph_picture

_ENDLESS = (
    "most_probable_path: your function has not ended after {seconds:g} seconds. Which loop is it? "
    "The search goes round a cycle for ever if a length is below 0, as -RE is, or if a vertex is "
    "pushed again although its new length is not smaller: RE may be 1, and -log 1 is 0. The loop "
    "back along the predecessors must end at the start, also where start and goal are one"
)
_LINE: Graph = {0: {1: 0.9}, 1: {2: 0.8}, 2: {3: 0.95}, 3: {}}
_SURE: Graph = {0: {1: 1.0, 2: 0.9}, 1: {0: 1.0, 2: 1.0}, 2: {3: 1.0}, 3: {1: 1.0}}
_LATE: Graph = {0: {1: 0.5, 2: 0.95}, 1: {4: 0.99}, 2: {3: 0.95, 4: 0.6}, 3: {1: 0.95}, 4: {}}
_CASES: dict[str, tuple[Graph, Vertex, Vertex]] = {
    "the graph above": (BY_HAND, "here", "goal"),
    "a chain": (_LINE, 0, 3),
    "edges that are sure": (_SURE, 0, 3),
    "a better path found late": (_LATE, 0, 4),
    "30 vertices": (random_graph(30, 3, 1), 0, 29),
    "60 vertices": (random_graph(60, 4, 2), 5, 17),
    "40 vertices": (random_graph(40, 6, 8), 3, 30),
    "start and goal are one": (_LINE, 2, 2),
    "an edge in the opposite direction only": (_LINE, 3, 0),
    "one step": ({0: {1: 0.25}, 1: {}}, 0, 1),
    "a vertex without edges": ({0: {}, 1: {0: 0.9}}, 0, 1),
    "start and goal are one, on a cycle": (_SURE, 1, 1),
    "back to the start is surer": ({0: {1: 0.5}, 1: {0: 1.0, 2: 0.5}, 2: {}}, 0, 2),
    "very doubtful edges": ({0: {1: 1e-5, 2: 1e-9}, 1: {2: 1e-3}, 2: {}}, 0, 2),
    "a chain whose vertices stand in reverse order": (
        {12: {}} | {v: {v + 1: 0.95} for v in range(11, -1, -1)},
        0,
        12,
    ),
    "a long chain": ({v: {v + 1: 0.99} for v in range(60)} | {60: {}}, 0, 60),
} | {
    f"a graph drawn at random ({seed})": (random_graph(8 + seed, 2, 20 + seed), 0, 7 + seed)
    for seed in range(6)
}


@check(most_probable_path, (random_graph(80, 4, 3), 0, 79), endless=_ENDLESS)
def check_most_probable_path(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """The graph done by hand, chains, cycles, larger graphs, and goals that cannot be reached."""
    return compare(
        "most_probable_path",
        student,
        _CASES,
        most_probable_path,
        FAULTS,
        invoke=_invoke,
        form=_path,
        same=_same,
        difference=_apart,
        broken=_broken,
        draw=_graphs,
    )


def _graphs(want: Found, got: Found) -> NDArray[np.uint8]:
    pictures = [graph_picture(BY_HAND, path) for path, _ in (want, got)]
    return side_by_side(pictures, ["target", "yours"], height=200)


def _invoke(what: str, student: Callable[..., Any], graph: Graph, *ends: Vertex) -> Any:  # noqa: ANN401
    """A student's answer, if it comes to an end and leaves the graph as it is."""
    given = {v: dict(out) for v, out in graph.items()}
    unreachable = "a goal that cannot be reached has no predecessor; return [], 0.0"
    usual = "each vertex needs a length and a predecessor before they are looked up; the start has "
    words = usual + "no predecessor" if most_probable_path(graph, *ends)[0] else unreachable
    hints = {
        KeyError: words,
        IndexError: words,
        ValueError: "every RE is above 0, and every path has a vertex; what is it that has none?",
        TypeError: "in the heap there are pairs (length, vertex), the length first",
    }
    got = explaining(what, partial(student, given, *ends), hints)
    if given != graph:
        raise WrongAnswer(f"{what}: your function changes the graph; leave it as it is")
    return got


def _path(what: str, got: Any, graph: Graph, *_: object) -> Found:  # noqa: ANN401 - students'
    """A path and its probability, from an answer of the right form."""
    path, probability = parts(what, got, 2, "return the path and its probability")
    path = vertices(what, path, set(graph), "as the path")
    return path, number(what, probability, "as the probability")


def _same(got: Found, want: Found, graph: Graph, *_: Vertex) -> bool:
    """Whether two answers are equally good; of paths that are equally probable any will do."""
    if not math.isclose(got[1], want[1], abs_tol=1e-9):
        return False
    if got[0] == want[0]:
        return True
    steps = list(pairwise(got[0]))
    there = bool(steps) and all(w in graph.get(v, {}) for v, w in steps)
    ends = there and got[0][0] == want[0][0] and got[0][-1] == want[0][-1] if want[0] else False
    return ends and math.isclose(probability_of(graph, got[0]), want[1], abs_tol=1e-9)


def _broken(got: Found, want: Found, *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    if got[0] == want[0]:
        return "the probability is the product of RE along the path, with all digits"
    if not want[0]:
        return "where no edges lead from start to goal there is no path"
    if not got[0]:
        return "a path is found if edges lead there, however many; begin each call anew"
    return "the path has edges of the graph, from start to goal, and the greatest product of RE"


def _apart(got: Found, want: Found, graph: Graph, *_: Vertex) -> str:
    """What is wrong with an answer."""
    path, probability = got
    if not want[0]:
        return f"{path}, {probability:.3g} came back; no path leads there: return [], 0.0"
    shown = f"{_spoken(want[0])} has probability {want[1]:.4g}"
    if not path:
        why = "; it is long, and a long path is a path" if len(want[0]) > 8 else ""
        why = "; its probability is small, but not 0" if want[1] < 1e-3 else why
        return f"yours finds no path; {shown}{why}"
    if path[0] != want[0][0] or path[-1] != want[0][-1]:
        return f"the path begins with the start and ends with the goal, as in {_spoken(want[0])}"
    gaps = [(v, w) for v, w in pairwise(path) if w not in graph.get(v, {})]
    if gaps:
        return f"yours goes from {gaps[0][0]} to {gaps[0][1]}, where no edge leads"
    product = probability_of(graph, path)
    if not math.isclose(product, probability, abs_tol=1e-9):
        near = abs(product - probability) < 0.02 * product
        digits = 4 if f"{product:.4g}" != f"{probability:.4g}" else 9
        why = "; is something rounded, or of 32 bits? Keep all digits" if near else ""
        return (
            f"along {_spoken(path)} the product of RE is {product:.{digits}g}; "
            f"yours returns {probability:.{digits}g}{why}"
        )
    return f"yours takes {_spoken(path)} with {probability:.4g}; {shown}"


def _spoken(path: list[Vertex]) -> str:
    return " > ".join(map(str, path))
