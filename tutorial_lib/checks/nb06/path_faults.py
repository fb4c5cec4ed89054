"""Known mistakes in finding the most probable path, and the answers that they give."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise

from tutorial_lib.checks.nb06.graphs import Found, Graph, Vertex, most_probable_path, probability_of


def _searched(
    graph: Graph, start: Vertex, goal: Vertex, cost: Callable[[float], float], fault: str = ""
) -> Found:
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


def _back(graph: Graph, before: dict[Vertex, Vertex], start: Vertex, goal: Vertex) -> Found:
    """The path back from the goal, reversed."""
    if goal not in before:
        return [], 0.0
    path = [goal]
    while path[-1] != start:
        path.append(before[path[-1]])
    return path[::-1], probability_of(graph, path[::-1])


def _cost(probability: float) -> float:
    return -math.log(probability)


def _restated(change: Callable[..., Found]) -> Callable[..., Found]:
    """The right path, returned in another form."""

    def answer(graph: Graph, start: Vertex, goal: Vertex) -> Found:
        path, probability = most_probable_path(graph, start, goal)
        if not path:
            return path, probability
        return change(path, probability, [graph[v][w] for v, w in pairwise(path)])

    return answer


def _best_next(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    """Always the best next edge."""
    path, probability = [start], 1.0
    while path[-1] != goal:
        edges = {w: p for w, p in graph[path[-1]].items() if w not in path}
        if not edges:
            return [], 0.0
        path.append(max(edges, key=edges.__getitem__))
        probability *= edges[path[-1]]
    return path, probability


def _not_itself(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    return ([], 0.0) if start == goal else most_probable_path(graph, start, goal)


def _sure_of_nothing(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    path, probability = most_probable_path(graph, start, goal)
    return path, probability if path else 1.0


def _by_cost(
    cost: Callable[[float], float], total: Callable[..., float] = math.fsum, fault: str = ""
) -> Callable[..., Found]:
    """The best path by another cost, and the exponential of minus this cost."""

    def answer(graph: Graph, start: Vertex, goal: Vertex) -> Found:
        path, _ = _searched(graph, start, goal, cost, fault)
        if not path:
            return path, 0.0
        return path, math.exp(-total([cost(graph[v][w]) for v, w in pairwise(path)] or [0.0]))

    return answer


def _few_rounds(rounds: int) -> Callable[..., Found]:
    """Bellman and Ford's rounds over all edges, but not enough of them."""

    def answer(graph: Graph, start: Vertex, goal: Vertex) -> Found:
        found, before = {start: 1.0}, {start: start}
        for _ in range(rounds):
            for v in graph:
                for w, p in graph[v].items():
                    if found.get(v, 0.0) * p > found.get(w, 0.0):
                        found[w], before[w] = found[v] * p, v
        return _back(graph, before, start, goal)

    return answer


def _either_way(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    """Edges driven in both directions, also in that in which they do not lead."""
    both: Graph = {v: dict(out) for v, out in graph.items()}
    for v, out in graph.items():
        for w, p in out.items():
            both[w].setdefault(v, p)
    return most_probable_path(both, start, goal)


def _without(unlikely: Callable[[float], bool]) -> Callable[..., Found]:
    """The best path over what is left when some edges are taken away."""

    def answer(graph: Graph, start: Vertex, goal: Vertex) -> Found:
        left = {v: {w: p for w, p in out.items() if not unlikely(p)} for v, out in graph.items()}
        return most_probable_path(left, start, goal)

    return answer


def _vertex_first(graph: Graph, start: Vertex, goal: Vertex) -> Found:
    """A heap of (vertex, length)."""
    least, before, heap, done = {start: 0.0}, {start: start}, [(start, 0.0)], set()
    while heap:
        vertex, reached = heapq.heappop(heap)
        if vertex == goal:
            break
        if vertex in done:
            continue
        done.add(vertex)
        for other, probability in graph[vertex].items():
            through = reached + _cost(probability)
            if through < least.get(other, math.inf):
                least[other], before[other] = through, vertex
                heapq.heappush(heap, (other, through))
    return _back(graph, before, start, goal)


FAULTS: dict[str, Callable[..., Found]] = {
    "edges have a direction: graph[v][w] leads from v to w, not back": _either_way,
    "an edge of RE 1 is an edge: its length is 0, and 0 is false in Python": _without(
        lambda p: p == 1
    ),
    "a doubtful edge is an edge, too: there may be no other one, however small RE is": _without(
        lambda p: p < 0.01
    ),
    "where start and goal are the same vertex, the probability is 1: nothing can go wrong": (
        lambda graph, start, goal: (
            ([start], 0.0) if start == goal else most_probable_path(graph, start, goal)
        )
    ),
    "vertex 0 is a vertex, too: compare with None, or with the start, since 0 is false in Python": (
        lambda graph, start, goal: _restated(
            lambda path, p, steps: ([v for v in path if v != 0], p)
        )(graph, start, goal)
    ),
    "one round over all edges is not enough: go on until nothing changes": _few_rounds(1),
    "a few rounds over all edges are not enough: go on until nothing changes": _few_rounds(3),
    "in the heap the length stands first, (length, vertex): it sorts by what stands first": (
        _vertex_first
    ),
    "1 - RE only resembles -log RE, and only near 1; take the logarithm, and exp of its sum": (
        _by_cost(lambda p: 1.0 - p)
    ),
    "RE is no cost: the smaller it is, the worse; take -log RE, and exp of minus its sum": (
        _by_cost(lambda p: p)
    ),
    "that is the path of the fewest steps; add up -log RE, not 1 for each step": _by_cost(
        lambda p: 1.0
    ),
    "that is the path whose weakest edge is strongest; all edges must hold: add, do not take max": (
        _by_cost(_cost, max, "weakest")
    ),
    "where start and goal are the same vertex, the path is that vertex, with probability 1": (
        _not_itself
    ),
    "where no path leads to the goal, the probability is 0.0": _sure_of_nothing,
    "yours always takes the best next edge, which may lead to poor ones. Compare whole paths": (
        _best_next
    ),
    "the path is right, but with base 10: take math.log and math.exp": (
        lambda *case: _restated(lambda path, p, steps: (path, math.exp(math.log10(p))))(*case)
    ),
    "the path is right, but its probability came back with a minus": (
        lambda *case: _restated(lambda path, p, steps: (path, -p))(*case)
    ),
    "that is the path of the fewest steps; a longer one may be more probable": partial(
        _searched, cost=lambda p: 1.0
    ),
    "1 - RE only resembles -log RE, and only near 1; take the logarithm": partial(
        _searched, cost=lambda p: 1.0 - p
    ),
    "RE is no cost: the smaller it is, the worse; take -log RE": partial(
        _searched, cost=lambda p: p
    ),
    "yours goes on along the best next edge, and back where that leads nowhere, as with -RE, which "
    "is below 0: each further step makes a path cheaper. Compare whole paths, by -log RE": partial(
        _searched, cost=lambda p: -p
    ),
    "1 / RE is no sum of logarithms; take -log RE": partial(_searched, cost=lambda p: 1.0 / p),
    "that is the path whose weakest edge is strongest; all edges must hold, so costs add up": (
        partial(_searched, cost=_cost, fault="weakest")
    ),
    "the cost of a vertex is that of the whole path to it, not only of the last step": partial(
        _searched, cost=_cost, fault="greedy"
    ),
    "yours stops when it first sees the goal; go on until the goal is taken from the heap": (
        partial(_searched, cost=_cost, fault="first sight")
    ),
    "a vertex is settled when it is taken from the heap, not when it is put there; a better path "
    "may be found in between": partial(_searched, cost=_cost, fault="pushed"),
    "a worse path, found later, overwrites where a vertex was reached from; compare costs first": (
        partial(_searched, cost=_cost, fault="overwrites")
    ),
    "the path leads backwards, from goal to start; reverse it": _restated(
        lambda path, p, steps: (path[::-1], p)
    ),
    "the path is right, but the probability is that of the last step alone; multiply all": (
        _restated(lambda path, p, steps: (path, steps[-1] if steps else 1.0))
    ),
    "the path is right, but the probability is that of the first step alone; multiply all": (
        _restated(lambda path, p, steps: (path, steps[0] if steps else 1.0))
    ),
    "the start is missing from the path": _restated(lambda path, p, steps: (path[1:], p)),
    "the goal is missing from the path": _restated(lambda path, p, steps: (path[:-1], p)),
    "that is the cost, -log of the probability; invert it: exp(-cost)": _restated(
        lambda path, p, steps: (path, -math.log(p))
    ),
    "the path is right, but that is the sum of RE; multiply": _restated(
        lambda path, p, steps: (path, math.fsum(steps))
    ),
    "the path is right, but that is the mean of RE; multiply": _restated(
        lambda path, p, steps: (path, math.fsum(steps) / max(len(steps), 1))
    ),
    "the path is right, but that is the least RE on it; multiply": _restated(
        lambda path, p, steps: (path, min(steps, default=1.0))
    ),
    "the path is right, but that is the logarithm of its probability; take exp": _restated(
        lambda path, p, steps: (path, math.log(p))
    ),
    "the path is right, but that is the number of its steps; return the product of RE": _restated(
        lambda path, p, steps: (path, float(len(steps)))
    ),
    "the path is right, but that is what is missing to 1; return the product of RE": _restated(
        lambda path, p, steps: (path, 1.0 - p)
    ),
    "the path is right, but that is the exponential of the cost; the probability is exp(-cost)": (
        _restated(lambda path, p, steps: (path, 1.0 / p))
    ),
}
