"""The check of the most probable path over a graph, in notebook 06."""

import heapq
import math
from collections.abc import Callable
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, parts
from tutorial_lib.checks.nb06.forms import explaining, number, vertices
from tutorial_lib.checks.nb06.graphs import BY_HAND, Graph, Vertex, random_graph
from tutorial_lib.viz.figures.panels import stacked
from tutorial_lib.viz.figures.planning_graphs import graph_picture

Found = tuple[list[Vertex], float]
"""Vertices from start to goal, and the probability that all steps succeed."""


def most_probable_path(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    """The most probable path over a graph, and its probability; [] and 0 where there is none."""
    count, heap, done = 0, [(0.0, 0, start)], set()
    least, before = {start: 0.0}, {start: start}
    while heap:
        length, _, vertex = heapq.heappop(heap)
        if vertex in done:
            continue
        done.add(vertex)
        if vertex == goal:
            break
        for other, p in graph[vertex].items():
            through = length - math.log(p)
            if other not in done and through < least.get(other, math.inf):
                count += 1  # decides between equal lengths: vertices may have no order
                least[other], before[other] = through, vertex
                heapq.heappush(heap, (through, count, other))
    path = _traced(before, start, goal)
    if not path:
        return [], 0.0
    steps = [graph[v][w] for v, w in pairwise(path)]
    return path, math.prod(steps)


def _traced(before: dict[Vertex, Vertex], start: Vertex, goal: Vertex) -> list[Vertex]:
    """The path to the goal, back along what comes before each vertex; [] where nothing does."""
    if goal not in before:
        return []
    path = [goal]
    while path[-1] != start:
        path.append(before[path[-1]])
    return path[::-1]


_LINE: Graph = {0: {1: 0.9}, 1: {2: 0.8}, 2: {3: 0.95}, 3: {}}
_SURE: Graph = {0: {1: 1.0, 2: 0.9}, 1: {0: 1.0, 2: 1.0}, 2: {3: 1.0}, 3: {1: 1.0}}
_LATE: Graph = {0: {1: 0.5, 2: 0.95}, 1: {4: 0.99}, 2: {3: 0.95, 4: 0.6}, 3: {1: 0.95}, 4: {}}
_LITTLE: Graph = {0: {1: 0.9, 2: 0.9}, 1: {3: 0.9}, 2: {3: 0.900003}, 3: {}}
CASES = {
    "the graph above": case(BY_HAND, "here", "goal"),
    "a chain": case(_LINE, 0, 3),
    "edges that are sure": case(_SURE, 0, 3),
    "a better path found late": case(_LATE, 0, 4),
    "30 vertices": case(random_graph(30, 3, 1), 0, 29),
    "30 other vertices": case(random_graph(30, 3, 40), 0, 29),
    "60 vertices": case(random_graph(60, 4, 2), 5, 17),
    "40 vertices": case(random_graph(40, 6, 8), 3, 30),
    "start and goal are one": case(_LINE, 2, 2),
    "an edge in the opposite direction only": case(_LINE, 3, 0),
    "one step": case({0: {1: 0.25}, 1: {}}, 0, 1),
    "a vertex without edges": case({0: {}, 1: {0: 0.9}}, 0, 1),
    "start and goal are one, on a cycle": case(_SURE, 1, 1),
    "back to the start is surer": case({0: {1: 0.5}, 1: {0: 1.0, 2: 0.5}, 2: {}}, 0, 2),
    "very doubtful edges": case({0: {1: 1e-5, 2: 1e-9}, 1: {2: 1e-3}, 2: {}}, 0, 2),
    "a chain whose vertices stand in reverse order": case(
        {12: {}} | {v: {v + 1: 0.95} for v in range(11, -1, -1)}, 0, 12
    ),
    "two paths that differ by little": case(_LITTLE, 0, 3),
    "two paths that differ by little, the better one first": case(
        {0: {1: 0.9, 2: 0.9}, 1: {3: 0.900003}, 2: {3: 0.9}, 3: {}}, 0, 3
    ),
    "a long chain": case({v: {v + 1: 0.99} for v in range(60)} | {60: {}}, 0, 60),
} | {
    f"a graph drawn at random ({seed})": case(random_graph(8 + seed, 2, 20 + seed), 0, 7 + seed)
    for seed in range(6)
}
MISTAKES = """
edges have a direction: graph[v][w] leads from v to w, not back
    graph[vertex].items()
        -> ({v: out[vertex] for v, out in graph.items() if vertex in out} | graph[vertex]).items()
    graph[v][w] for -> graph[v].get(w) or graph[w][v] for
an edge of RE 1 is an edge: its length is 0, and 0 is false in Python
    other not in done -> p != 1 and other not in done
a doubtful edge is an edge, too: there may be no other one, however small RE is
    other not in done -> p >= 0.01 and other not in done
where start and goal are the same vertex, the probability is 1: nothing can go wrong
    math.prod(steps) -> math.prod(steps) if steps else 0.0
vertex 0 is a vertex, too: compare with None, or with the start, since 0 is false in Python
    return path, -> return [v for v in path if v != 0],
in the heap the length stands first, (length, vertex): it sorts by what stands first
    (0.0, 0, start) -> (start, 0, 0.0)
    length, _, vertex = -> vertex, _, length =
    (through, count, other) -> (other, 0, through)
    other not in done and through -> through
in the heap, put the length before the vertex: out comes what is least by what stands first
    (0.0, 0, start) -> (start, 0, 0.0)
    length, _, vertex = -> vertex, _, length =
    (through, count, other) -> (other, 0, through)
1 - RE only resembles -log RE, and only near 1; take the logarithm, and exp of its sum
    - math.log(p) -> + (1.0 - p)
    math.prod(steps) -> math.exp(-least[goal])
RE is no cost: the smaller it is, the worse; take -log RE, and exp of minus its sum
    - math.log(p) -> + p
    math.prod(steps) -> math.exp(-least[goal])
that is the path of the fewest steps; add up -log RE, not 1 for each step
    - math.log(p) -> + 1.0
    math.prod(steps) -> math.exp(-least[goal])
that is the path whose weakest edge is strongest; all edges must hold: add, do not take max
    length - math.log(p) -> max(length, -math.log(p))
    math.prod(steps) -> math.exp(-least[goal])
where start and goal are the same vertex, the path is that vertex, with probability 1
    if not path -> if start == goal or not path
a heap is in order for heapq only, which takes its least with heapq.heappop(heap); heap.pop(0)
breaks the order of what is left
    heapq.heappop(heap) -> heap.pop(0)
what is appended stands in no order: heapq.heappush(heap, (length, vertex)) keeps the heap
    heapq.heappush(heap, (through, count, other)) -> heap.append((through, count, other))
where no path leads to the goal, the probability is 0.0
    return [], 0.0 -> return [], 1.0
the path is right, but with base 10: take math.log and math.exp
    math.prod(steps) -> math.exp(math.log10(math.prod(steps)))
the path is right, but its probability came back with a minus
    math.prod(steps) -> -math.prod(steps)
that is the path of the fewest steps; a longer one may be more probable
    - math.log(p) -> + 1.0
1 - RE only resembles -log RE, and only near 1; take the logarithm
    - math.log(p) -> + (1.0 - p)
RE is no cost: the smaller it is, the worse; take -log RE
    - math.log(p) -> + p
yours goes on along the best next edge, and back where that leads nowhere, as with -RE, which is
below 0: each further step makes a path cheaper. Compare whole paths, by -log RE
    - math.log(p) -> - p
1 / RE is no sum of logarithms; take -log RE
    - math.log(p) -> + 1.0 / p
that is the path whose weakest edge is strongest; all edges must hold, so costs add up
    length - math.log(p) -> max(length, -math.log(p))
paths that differ by little look alike in yours: round no length, and compare them as they are
    length - math.log(p) -> length - round(math.log(p), 3)
the cost of a vertex is that of the whole path to it, not only of the last step
    length - math.log(p) -> -math.log(p)
yours stops when it first sees the goal; go on until the goal is taken from the heap
    while heap: -> while heap and (start == goal or goal not in before):
a vertex is settled when it is taken from the heap, not when it is put there; a better path may be
found in between
    through < least.get(other, math.inf) -> other not in least
a worse path, found later, overwrites where a vertex was reached from; compare costs first
    and through < least.get(other, math.inf) -> and True
the path leads backwards, from goal to start; reverse it
    return path, -> return path[::-1],
the path is right, but the probability is that of the last step alone; multiply all
    math.prod(steps) -> math.prod(steps[-1:])
the path is right, but the probability is that of the first step alone; multiply all
    math.prod(steps) -> math.prod(steps[:1])
the start is missing from the path
    return path, -> return path[1:],
the goal is missing from the path
    return path, -> return path[:-1],
that is the cost, -log of the probability; invert it: exp(-cost)
    math.prod(steps) -> -math.log(math.prod(steps))
the path is right, but that is the sum of RE; multiply
    math.prod(steps) -> sum(steps)
the path is right, but that is the mean of RE; multiply
    math.prod(steps) -> sum(steps) / max(len(steps), 1)
the path is right, but that is the least RE on it; multiply
    math.prod(steps) -> min(steps, default=1.0)
the path is right, but that is the logarithm of its probability; take exp
    math.prod(steps) -> math.log(math.prod(steps))
the path is right, but that is the number of its steps; return the product of RE
    math.prod(steps) -> float(len(steps))
the path is right, but that is what is missing to 1; return the product of RE
    math.prod(steps) -> 1.0 - math.prod(steps)
the path is right, but that is the exponential of the cost; the probability is exp(-cost)
    math.prod(steps) -> 1.0 / math.prod(steps)
"""


def _few_rounds(rounds: int) -> Callable[..., Found]:
    """Bellman and Ford's rounds over all edges, but not enough of them."""

    def answer(graph: Graph, start: Vertex, goal: Vertex) -> Found:
        found, before = {start: 1.0}, {start: start}
        for _ in range(rounds):
            for v in graph:
                for w, p in graph[v].items():
                    if found.get(v, 0.0) * p > found.get(w, 0.0):
                        found[w], before[w] = found[v] * p, v
        path = _traced(before, start, goal)
        return path, probability_of(graph, path) if path else 0.0

    return answer


def _best_next(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    """Always the best next edge."""
    path = [start]
    while path[-1] != goal:
        edges = {w: p for w, p in graph[path[-1]].items() if w not in path}
        if not edges:
            return [], 0.0
        path.append(max(edges, key=edges.__getitem__))
    return path, probability_of(graph, path)


OTHERS = {
    "one round over all edges is not enough: go on until nothing changes": _few_rounds(1),
    "a few rounds over all edges are not enough: go on until nothing changes": _few_rounds(3),
    "yours always takes the best next edge, which may lead to poor ones. Compare whole paths": (
        _best_next
    ),
}
_ENDLESS = (
    "most_probable_path: your function has not ended after {seconds:g} seconds. Which loop is it? "
    "The search goes round a cycle for ever if a length is below 0, as -RE is, or if a vertex is "
    "pushed again although its new length is not smaller: RE may be 1, and -log 1 is 0. The loop "
    "back along the predecessors must end at the start, also where start and goal are one"
)


def probability_of(graph: Graph, path: list[Vertex]) -> float:
    """The product of RE along a path."""
    return math.prod(graph[v][w] for v, w in pairwise(path))


_SWAPPED = "in the heap there are pairs (length, vertex), the length first"
_graph = lru_cache(maxsize=64)(partial(graph_picture, BY_HAND))


def _graphs(want: Found, got: Found) -> NDArray[np.uint8]:
    pictures = [_graph(tuple(path)) for path, _ in (want, got)]
    return stacked(pictures, ["expected", "yours"], width=460, gap=4)


def _invoke(what: str, student: Callable[..., Any], graph: Graph, *ends: Vertex) -> Any:  # noqa: ANN401
    """A student's answer, if it comes to an end and leaves the graph as it is."""
    given = {v: dict(out) for v, out in graph.items()}
    unreachable = "a goal that cannot be reached has no predecessor; return [], 0.0"
    usual = "each vertex needs a length and a predecessor before they are looked up; the start has "
    words = usual + "no predecessor" if most_probable_path(graph, *ends)[0] else unreachable
    hints: dict[type[Exception], str | Callable[[Any], str]] = {
        KeyError: lambda error: _SWAPPED if isinstance(error.args[0], float) else words,
        IndexError: words,
        ValueError: "every RE is above 0, and every path has a vertex; what is it that has none?",
        TypeError: _SWAPPED,
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
    if f"{probability:.4g}" == f"{want[1]:.4g}":
        shown = f"{_spoken(want[0])} has probability {want[1]:.9g}"
        return f"yours takes {_spoken(path)} with {probability:.9g}; {shown}"
    return f"yours takes {_spoken(path)} with {probability:.4g}; {shown}"


def _spoken(path: list[Vertex]) -> str:
    return " > ".join(map(str, path))


check_most_probable_path = exercise(
    most_probable_path,
    CASES,
    MISTAKES,
    about="The graph done by hand, chains, cycles, larger graphs, goals that cannot be reached.",
    example=case(random_graph(80, 4, 3), 0, 79),
    others=OTHERS,
    calls=10,  # of hundreds: Bellman and Ford's rounds are slower, but right, and are used below
    endless=_ENDLESS,
    invoke=_invoke,
    form=_path,
    same=_same,
    difference=_apart,
    broken=_broken,
    draw=_graphs,
)
