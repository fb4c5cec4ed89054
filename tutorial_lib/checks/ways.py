"""The check of the most probable way over a graph, in notebook 06."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable
from functools import partial
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.check import WrongAnswer, check
from tutorial_lib.topology.linking import weight
from tutorial_lib.viz.panels import side_by_side
from tutorial_lib.viz.ways import graph_picture

Vertex = Any
Graph = dict[Vertex, dict[Vertex, float]]
"""For each vertex, those that an edge leads to, with RE."""
Way = tuple[list[Vertex], float]
"""Vertices from start to goal, and how probably all steps come true."""

BY_HAND: Graph = {
    "here": {"A": 0.70, "B": 0.90, "D": 0.95, "E": 0.72},
    "A": {"goal": 0.80, "B": 0.99},
    "B": {"C": 0.90, "A": 0.75, "D": 0.85},
    "C": {"goal": 0.90},
    "D": {"C": 0.80, "B": 0.91},
    "E": {"goal": 0.995},
    "goal": {},
}
"""A small graph, to plan on with a pencil."""


def most_probable_way(graph: Graph, start: Vertex, goal: Vertex) -> Way:
    """The most probable way over a graph, and its probability; [] and 0 where there is none.

    Args:
        graph: for each vertex, those that an edge leads to, with RE.
        start: a vertex.
        goal: a vertex.
    """
    drawn = nx.DiGraph()
    drawn.add_nodes_from(graph)
    edges = ((v, w, float(weight(p))) for v, out in graph.items() for w, p in out.items())
    drawn.add_weighted_edges_from(edges)
    try:
        way = nx.dijkstra_path(drawn, start, goal)
    except nx.NetworkXNoPath:
        return [], 0.0
    return way, probability_of(graph, way)


def probability_of(graph: Graph, way: list[Vertex]) -> float:
    """The product of RE along a way."""
    return math.prod(graph[v][w] for v, w in pairwise(way))


class PatientGraph(dict):
    """A graph that loses patience with whoever reads it again and again."""

    def __init__(self, graph: Graph, left: int) -> None:
        super().__init__(graph)
        self.left = left

    def __getitem__(self, vertex: Hashable) -> dict[Vertex, float]:
        self._read()
        return super().__getitem__(vertex)

    def get(self, vertex: Hashable, otherwise: Any = None) -> Any:  # noqa: ANN401 - as dict's
        """As dict's."""
        self._read()
        return super().get(vertex, otherwise)

    def _read(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise WrongAnswer(
                "most_probable_way: your function never ends. Each vertex is dealt with once, when "
                "it is taken from the heap for the first time; and no cost may be below 0"
            )


def random_graph(count: int, degree: int, seed: int) -> Graph:
    """A graph of `count` numbered vertices, each with an edge to `degree` others."""
    rng = np.random.default_rng(seed)
    graph: Graph = {vertex: {} for vertex in range(count)}
    for vertex in graph:
        others = rng.choice(count - 1, degree, replace=False)
        for other in (int(o) + (o >= vertex) for o in others):
            graph[vertex][int(other)] = round(float(rng.uniform(0.4, 0.999)), 3)
    return graph


_LINE: Graph = {0: {1: 0.9}, 1: {2: 0.8}, 2: {3: 0.95}, 3: {}}
_SURE: Graph = {0: {1: 1.0, 2: 0.9}, 1: {0: 1.0, 2: 1.0}, 2: {3: 1.0}, 3: {1: 1.0}}
_LATE: Graph = {0: {1: 0.5, 2: 0.95}, 1: {4: 0.99}, 2: {3: 0.95, 4: 0.6}, 3: {1: 0.95}, 4: {}}
_CASES: tuple[tuple[str, Graph, Vertex, Vertex], ...] = (
    ("the graph above", BY_HAND, "here", "goal"),
    ("a chain", _LINE, 0, 3),
    ("edges that are sure", _SURE, 0, 3),
    ("a better way found late", _LATE, 0, 4),
    ("30 vertices", random_graph(30, 3, 1), 0, 29),
    ("60 vertices", random_graph(60, 4, 2), 5, 17),
    ("40 vertices", random_graph(40, 6, 8), 3, 30),
    ("start and goal are one", _LINE, 2, 2),
    ("an edge leads the other way only", _LINE, 3, 0),
)


@check(most_probable_way, (random_graph(80, 4, 3), 0, 79))
def check_most_probable_way(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """The graph done by hand, chains, cycles, larger graphs, and goals that cannot be reached."""
    answers, right = [], [most_probable_way(*case[1:]) for case in _CASES]
    for name, graph, start, goal in _CASES:
        answers.append(_asked(f"most_probable_way, {name}", student, graph, start, goal))
    ways = (right[0][0], answers[0][0])
    picture = side_by_side([graph_picture(BY_HAND, way) for way in ways], ["target", "yours"])
    for case, got, want in zip(_CASES, answers, right, strict=True):
        if _same(case[1], got, want):
            continue
        what = f"most_probable_way, {case[0]}"
        for words, mistake in _MISTAKES.items():
            wrong = [mistake(*c[1:]) for c in _CASES]
            if all(_same(c[1], a, w) for c, a, w in zip(_CASES, answers, wrong, strict=True)):
                raise WrongAnswer(f"{what}: {words}", picture)
        raise WrongAnswer(f"{what}: {_apart(case[1], got, want)}", picture)
    return picture


def _asked(what: str, student: Callable[..., Any], graph: Graph, *ends: Vertex) -> Way:
    """A student's answer, if it has the right form."""
    given = PatientGraph({v: dict(out) for v, out in graph.items()}, 40 * len(graph) ** 2)
    try:
        got = student(given, *ends)
    except (KeyError, IndexError) as error:
        words = "where the goal cannot be reached there is no way back from it; return [], 0.0"
        words = words if not most_probable_way(graph, *ends)[0] else "is there such a vertex?"
        raise WrongAnswer(f"{what}: {type(error).__name__}, {error}; {words}") from None
    if dict(given) != graph:
        raise WrongAnswer(f"{what}: your function changes the graph; leave it as it is")
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    if not isinstance(got, tuple | list) or len(got) != 2:
        raise WrongAnswer(f"{what}: return the way and its probability")
    way, probability = got
    if not isinstance(way, tuple | list):
        raise WrongAnswer(f"{what}: {way!r} came back as the way; return a list of vertices")
    if not isinstance(probability, float | int | np.number):
        kind = type(probability).__name__
        raise WrongAnswer(f"{what}: a {kind} came back as the probability; return a number")
    return list(way), float(probability)


def _same(graph: Graph, got: Way, want: Way) -> bool:
    """Whether two answers are as good; of ways that are as probable either will do."""
    if not math.isclose(got[1], want[1], abs_tol=1e-9):
        return False
    if got[0] == want[0]:
        return True
    steps = list(pairwise(got[0]))
    there = bool(steps) and all(w in graph.get(v, {}) for v, w in steps)
    ends = there and got[0][0] == want[0][0] and got[0][-1] == want[0][-1] if want[0] else False
    return ends and math.isclose(probability_of(graph, got[0]), want[1], abs_tol=1e-9)


def _apart(graph: Graph, got: Way, want: Way) -> str:
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


def _searched(
    graph: Graph, start: Vertex, goal: Vertex, cost: Callable[[float], float], fault: str = ""
) -> Way:
    """Dijkstra by any cost, with a `fault` if one is named."""
    count, heap, before, done = 0, [(0.0, 0, start)], {start: start}, set()
    least = {start: 0.0}
    while heap:
        reached, _, vertex = heapq.heappop(heap)
        if vertex in done:
            continue
        done.add(vertex)
        if vertex == goal:
            break
        for other, probability in graph[vertex].items():
            if fault == "weakest":
                through = max(reached, cost(probability))
            else:
                through = cost(probability) if fault == "greedy" else reached + cost(probability)
            known = other in least if fault == "pushed" else through >= least.get(other, math.inf)
            if other in done or (known and fault != "overwrites"):
                continue
            count += 1
            least[other], before[other] = through, vertex
            heapq.heappush(heap, (through, count, other))
        if fault == "first sight" and goal in before:
            break
    return _back(graph, before, start, goal)


def _back(graph: Graph, before: dict[Vertex, Vertex], start: Vertex, goal: Vertex) -> Way:
    """The way back from the goal, turned round."""
    if goal not in before:
        return [], 0.0
    way = [goal]
    while way[-1] != start:
        way.append(before[way[-1]])
    return way[::-1], probability_of(graph, way[::-1])


def _cost(probability: float) -> float:
    return -math.log(probability)


def _told(change: Callable[..., Way]) -> Callable[..., Way]:
    """The right way, told in another form."""

    def answer(graph: Graph, start: Vertex, goal: Vertex) -> Way:
        way, probability = most_probable_way(graph, start, goal)
        if not way:
            return way, probability
        return change(way, probability, [graph[v][w] for v, w in pairwise(way)])

    return answer


_MISTAKES: dict[str, Callable[..., Way]] = {
    "that is the way of the fewest steps; a longer one may be more probable": partial(
        _searched, cost=lambda p: 1.0
    ),
    "1 - RE only resembles -log RE, and only near 1; take the logarithm": partial(
        _searched, cost=lambda p: 1.0 - p
    ),
    "RE is no cost: the smaller it is, the worse; take -log RE": partial(
        _searched, cost=lambda p: p
    ),
    "-RE is below 0, so that each further step makes a way cheaper; take -log RE": partial(
        _searched, cost=lambda p: -p
    ),
    "1 / RE is no sum of logarithms; take -log RE": partial(_searched, cost=lambda p: 1.0 / p),
    "that is the way whose weakest edge is strongest; all edges must hold, so costs add up": (
        partial(_searched, cost=_cost, fault="weakest")
    ),
    "the cost of a vertex is that of the whole way to it, not only of the last step": partial(
        _searched, cost=_cost, fault="greedy"
    ),
    "yours stops when it first sees the goal; go on until the goal is taken from the heap": (
        partial(_searched, cost=_cost, fault="first sight")
    ),
    "a vertex is settled when it is taken from the heap, not when it is put there; a better way "
    "may be found in between": partial(_searched, cost=_cost, fault="pushed"),
    "a worse way, found later, overwrites where a vertex was reached from; compare costs first": (
        partial(_searched, cost=_cost, fault="overwrites")
    ),
    "the way leads backwards, from goal to start; turn it round": _told(
        lambda way, p, steps: (way[::-1], p)
    ),
    "the start is missing from the way": _told(lambda way, p, steps: (way[1:], p)),
    "the goal is missing from the way": _told(lambda way, p, steps: (way[:-1], p)),
    "that is the cost, -log of the probability; turn it back: exp(-cost)": _told(
        lambda way, p, steps: (way, -math.log(p))
    ),
    "the way is right, but that is the sum of RE; multiply": _told(
        lambda way, p, steps: (way, math.fsum(steps))
    ),
    "the way is right, but that is the mean of RE; multiply": _told(
        lambda way, p, steps: (way, math.fsum(steps) / max(len(steps), 1))
    ),
    "the way is right, but that is the least RE on it; multiply": _told(
        lambda way, p, steps: (way, min(steps, default=1.0))
    ),
    "the way is right, but that is the exponential of the cost; the probability is exp(-cost)": (
        _told(lambda way, p, steps: (way, 1.0 / p))
    ),
}
