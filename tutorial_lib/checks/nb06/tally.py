"""The check of counting which edges hold, in notebook 06."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Graph, Vertex
from tutorial_lib.checks.nb06.untouched import untouched
from tutorial_lib.geometry import Array, relative

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
    """How often each edge was tried, and how often it was passed.

    Args:
        trips: each a path, and the place of it that could not be reached; None on arrival.
    """
    return _tallied(trips)


def _tallied(trips: Sequence[Trip], fault: str = "") -> Tally:
    """The tally, with a `fault` if one is named."""
    counts: Tally = {}
    for path, stopped in trips:
        for place, edge in enumerate(pairwise(path), 1):
            arrived = stopped is None
            passed = arrived or place < stopped
            tried = arrived or place <= stopped
            if fault == "blames all":
                passed, tried = arrived, True
            if fault == "blames what was not tried":
                tried = True
            if fault == "passes the last":
                passed = tried
            if fault == "one too late":
                passed, tried = tried, arrived or place <= stopped + 1
            if fault == "one too early":
                passed, tried = arrived or place < stopped - 1, arrived or place < stopped
            if fault == "only arrivals":
                tried = passed = arrived
            if fault == "only failures":
                tried, passed = not arrived and place <= stopped, not arrived and place < stopped
            if fault == "both ways":
                edge = (min(edge), max(edge))
            if tried:
                before = (0, 0) if fault == "last trip" else counts.get(edge, (0, 0))
                counts[edge] = (before[0] + 1, before[1] + int(passed))
    if fault == "exchanged":
        return {edge: (passed, tried) for edge, (tried, passed) in counts.items()}
    if fault == "failed":
        return {edge: (tried, tried - passed) for edge, (tried, passed) in counts.items()}
    return counts


_CASES: dict[str, tuple[list[Trip]]] = {
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
}
_FAULTS = {
    "the edges before the one where it was lost were passed; do not blame them": "blames all",
    "what comes after the place where it was lost was never tried": "blames what was not tried",
    "the edge to path[stopped] was tried, but not passed": "passes the last",
    "the robot was lost on the edge that leads to path[stopped], not on the one after it": (
        "one too late"
    ),
    "the robot was lost on the edge that leads to path[stopped], not on the one before it": (
        "one too early"
    ),
    "trips that failed count, too": "only arrivals",
    "trips that arrived count, too": "only failures",
    "edges have a direction: (2, 3) and (3, 2) are two edges": "both ways",
    "count over all trips; yours forgets those before": "last trip",
    "first how often it was tried, then how often it was passed": "exchanged",
    "the second number is how often it was passed, not how often it failed": "failed",
}


@check(tally, ([([HERE, *range(200), GOAL], 150)] * 20,))
def check_tally(student: Callable[..., Any]) -> None:
    """Trips that arrived, trips that were lost at the start, under way and at the end, and none."""
    faults = with_faults(_tallied, _FAULTS)
    compare(
        "tally",
        student,
        _CASES,
        tally,
        faults,
        invoke=untouched,
        form=_counts,
        difference=_unlike,
    )


def _unlike(got: Tally, want: Tally, *_: object) -> str:
    """The first edge with other numbers."""
    edge = next(edge for edge in [*want, *got] if got.get(edge) != want.get(edge))
    yours, right = got.get(edge, "nothing"), want.get(edge, "nothing")
    return f"edge {edge} has {yours}; {right} is right"


def _counts(what: str, got: Any, *_: object) -> Tally:  # noqa: ANN401 - students'
    if not isinstance(got, dict):
        kind = type(got).__name__
        raise WrongAnswer(f"{what}: a {kind} came back; return a dictionary with edges as keys")
    for edge, numbers in got.items():
        if not isinstance(edge, tuple) or len(edge) != 2:
            raise WrongAnswer(f"{what}: the key {edge!r}; an edge is a pair of vertices")
        if not isinstance(numbers, tuple | list) or len(numbers) != 2:
            raise WrongAnswer(f"{what}: {numbers!r} for edge {edge}; give (tried, passed)")
    return {edge: (int(tried), int(passed)) for edge, (tried, passed) in got.items()}
