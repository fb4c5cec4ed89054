"""The check of counting which edges hold, in notebook 06."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, kind
from tutorial_lib.checks.nb06.forms import number, untouched
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Graph, Vertex
from tutorial_lib.se2 import Array, relative

_FALSE_FROM, _FALSE_TO = (-0.9, 7.3, -1.7), (-6.0, 1.0, 3.0)
"""Poses in the notebook's building, with a corner and some vertices between them."""
Trip = tuple[list[Vertex], int | None]
"""A path, and the place of it that could not be reached."""
Tally = dict[tuple[Vertex, Vertex], tuple[int, int]]
"""For each edge, how often it was tried and how often it was passed."""


def with_false_edge(graph: Graph, poses: Array, probability: float) -> Graph:
    """A graph with an edge that no robot can follow: the bug of the bug hunt.

    Args:
        graph: of the map of the notebook's building.
        poses: (V, 3) of its vertices.
        probability: of the false edge.
    """
    vertices = np.array(sorted(graph))
    joined = {v: dict(out) for v, out in graph.items()}
    ends = []
    for pose in (_FALSE_FROM, _FALSE_TO):
        off = relative(np.asarray(pose), poses[vertices])
        ends.append(int(vertices[np.hypot(np.hypot(off[:, 0], off[:, 1]), off[:, 2]).argmin()]))
    joined[ends[0]][ends[1]] = probability
    return joined


def tally(trips: Sequence[Trip]) -> Tally:
    """How often each edge was tried, and how often it was passed."""
    counts: Tally = {}
    for path, stopped in trips:
        last = len(path) if stopped is None else stopped
        for place, edge in enumerate(pairwise(path), 1):
            if place <= last:
                tried, passed = counts.get(edge, (0, 0))
                counts[edge] = (tried + 1, passed + (place < last))
    return counts


def _random_trips(seed: int) -> list[Trip]:
    """Six trips between five vertices."""
    rng, trips = np.random.default_rng(seed), []
    for _ in range(6):
        path = [HERE, *rng.integers(1, 6, int(rng.integers(1, 6))).tolist(), GOAL]
        path = [v for i, v in enumerate(path) if not i or v != path[i - 1]]
        place = int(rng.integers(1, len(path)))
        trips.append((path, None if rng.random() < 0.4 else place))
    return trips


CASES: dict[str, tuple[list[Trip]]] = {
    "one arrival": ([([HERE, 3, 4, GOAL], None)],),
    "one failure": ([([HERE, 3, 4, 5, 6, GOAL], 3)],),
    "lost before the first vertex": ([([HERE, 3, 4, GOAL], 1)],),
    "lost before the goal": ([([HERE, 3, GOAL], 2)],),
    "five trips": (
        [
            ([HERE, 1, 2, 3, GOAL], None),
            ([HERE, 1, 2, 7, 3, GOAL], 3),
            ([HERE, 3, 2, 1, GOAL], None),
            ([HERE, 2, 7, GOAL], 2),
            ([HERE, 1, 2, 3, 2, 7, GOAL], 5),
        ],
    ),
    "no trip": ([],),
    "in sight of the goal, and lost": ([([HERE, GOAL], 1)],),
    "in sight of the goal, and arrived": ([([HERE, GOAL], None)],),
    "the same trip twice": ([([HERE, 3, 4, GOAL], 2), ([HERE, 3, 4, GOAL], None)],),
    "twice over an edge in one trip": ([([HERE, 1, 2, 1, 2, GOAL], None)],),
    "lost when it comes to an edge again": ([([HERE, 1, 2, 1, 2, GOAL], 4)],),
    "over vertex 0": ([([HERE, 0, 3, GOAL], None), ([HERE, 3, 0, 2, GOAL], 3)],),
    "there and back": ([([HERE, 1, 2, 1, GOAL], 3), ([HERE, 2, 1, GOAL], 2)],),
    **{f"trips drawn at random ({seed})": (_random_trips(seed),) for seed in range(6)},
}
MISTAKES = """
the edges before the one where it was lost were passed; do not blame them
    if place <= last -> if True
    place < last -> stopped is None
what comes after the place where it was lost was never tried
    if place <= last -> if True
the edge to path[stopped] was tried, but not passed
    place < last -> True
the robot was lost on the edge that leads to path[stopped], not on the one after it
    else stopped -> else stopped + 1
the robot was lost on the edge that leads to path[stopped], not on the one before it
    else stopped -> else stopped - 1
the edges from HERE count as well
    place <= last -> place <= last and edge[0] != HERE
the edge to path[stopped] was tried as well, in vain: it counts as tried
    place <= last -> place < last
an edge that no trip tried is left out; yours has (0, 0) for it
    if place <= last -> if True
    tried + 1 -> tried + (place <= last)
stopped is 1 where the first edge could not be driven; only None is an arrival
    stopped is None -> stopped in (None, 1)
a vertex may stand on a path twice: compare places, not vertices, with stopped
    else stopped -> else path[1:].index(path[stopped]) + 1
vertex 0 is a vertex like the others, and false in Python
    place <= last -> place <= last and all(edge)
the edges from vertex 0 count as well; 0 is false in Python
    place <= last -> place <= last and edge[0]
the edges to GOAL count as well
    place <= last -> place <= last and edge[1] != GOAL
on arrival the last edge was passed, too
    len(path) if -> len(path) - 1 if
passed is counted over all trips, as tried is: add
    passed + (place < last) -> int(place < last)
the second number is how often it was passed, not its share
    return counts -> return {edge: (both[0], both[1] // both[0]) for edge, both in counts.items()}
an edge that was tried and never passed is the one we look for: it stays
    return counts -> return {edge: both for edge, both in counts.items() if both[1]}
trips that failed count, too
    place <= last -> stopped is None
trips that arrived count, too
    place <= last -> place <= last and stopped
an edge is a pair (from, to); yours are turned round
    return counts -> return {edge[::-1]: both for edge, both in counts.items()}
a trip may pass an edge more than once; each time counts
    place <= last -> place <= last and edge not in list(pairwise(path))[: place - 1]
edges from HERE and to GOAL count as well
    place <= last -> place <= last and min(edge) >= 0
edges have a direction: (2, 3) and (3, 2) are two edges
    pairwise(path) -> map(tuple, map(sorted, pairwise(path)))
count over all trips; yours forgets those before
    counts.get(edge, (0, 0)) -> (0, 0)
first how often it was tried, then how often it was passed
    return counts -> return {edge: both[::-1] for edge, both in counts.items()}
the second number is how often it was passed, not how often it failed
    return counts -> return {edge: (both[0], both[0] - both[1]) for edge, both in counts.items()}
"""
_HINTS: dict[type[Exception], str] = {
    IndexError: "there may be no trip, and a path has one edge less than vertices",
    TypeError: "stopped is None on arrival, otherwise a number; path is a list of vertices",
}


def _unlike(got: Tally, want: Tally, trips: Sequence[Trip]) -> str:
    """The first edge with other numbers, and the trips that count for it."""
    edge = next(edge for edge in [*want, *got] if got.get(edge) != want.get(edge))
    yours, right = got.get(edge, "nothing"), want.get(edge, "nothing")
    if edge not in want:
        return f"edge {edge} has {yours}, but was never tried: no robot came as far; leave it out"
    ends = []
    for path, stopped in trips:
        places = [i for i, step in enumerate(pairwise(path), 1) if step == edge]
        if places:
            end = "arrived" if stopped is None else f"stopped at place {stopped}"
            ends.append(f"it leads to place {places[0]} of {path}, which {end}")
    return f"edge {edge} has {yours}; (tried, passed) = {right} is right: {'; '.join(ends[:2])}"


def _counts(what: str, got: Any, *_: object) -> Tally:  # noqa: ANN401 - students'
    if not isinstance(got, dict):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return a dictionary with edges as keys")
    counts = {}
    for edge, numbers in got.items():
        if not isinstance(edge, tuple) or len(edge) != 2:
            raise WrongAnswer(f"{what}: the key {edge!r}; an edge is a pair of vertices")
        if not isinstance(numbers, tuple) or len(numbers) != 2:
            words = "give a tuple of two, (tried, passed)"
            raise WrongAnswer(f"{what}: {numbers!r} for edge {edge}; {words}")
        plain = [int(n) if isinstance(n, bool) else n for n in numbers]
        both = [number(what, n, f"for edge {edge}") for n in plain]
        if not all(n.is_integer() for n in both):
            raise WrongAnswer(f"{what}: {numbers!r} for edge {edge}; count, in whole numbers")
        counts[edge] = (int(both[0]), int(both[1]))
    return counts


check_tally = exercise(
    tally,
    CASES,
    MISTAKES,
    about="Trips that arrived, that were lost at the start, under way and at the end, and none.",
    example=case([([HERE, *range(200), GOAL], 150)] * 20),
    invoke=untouched(tally, _HINTS),
    form=_counts,
    difference=_unlike,
)
