"""The check of which vertices lie ahead of those reused, in notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import mask
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.topology.mapping import edge_rules

_CASES = {
    name: (np.array(trajectory), np.array(place), reused)
    for name, trajectory, place, reused in (
        ("nothing was reused yet", [0, 0, 0, 1, 1], [0, 1, 2, 0, 1], []),
        ("one was reused", [0, 0, 0, 1, 1], [0, 1, 2, 0, 1], [1]),
        ("one of each trajectory", [0, 0, 0, 1, 1, 1], [0, 1, 2, 0, 1, 2], [1, 3]),
        ("two of the same trajectory", [0, 0, 0, 0, 1], [0, 1, 2, 3, 0], [1, 2]),
        ("one, then one of another", [0, 0, 0, 0, 1, 1], [0, 1, 2, 3, 0, 1], [2, 5, 3]),
        ("indices in no order", [2, 0, 2, 0, 2, 0], [5, 4, 1, 0, 3, 2], [4, 5]),
    )
}


def _behind(
    keep: Callable[[Any, Any, int], Any], counted: slice = slice(None)
) -> Callable[..., Any]:
    """Another rule: `keep` returns which vertices a reused one leaves allowed."""

    def rule(trajectory: NDArray, place: NDArray, reused: list[int]) -> NDArray[np.bool_]:
        allowed = np.ones(len(place), dtype=bool)
        for vertex in reused[counted]:
            allowed &= keep(trajectory, place, vertex)
        return allowed

    return rule


_FAULTS: dict[str, Callable[..., Any]] = {
    "the vertex itself may not follow itself: its place must be greater": _behind(
        lambda t, p, v: (t != t[v]) | (p >= p[v])
    ),
    "vertices of other trajectories may be taken, wherever they lie": _behind(
        lambda t, p, v: p > p[v]
    ),
    "of the same trajectory those that lie ahead may be taken": _behind(lambda t, p, v: t != t[v]),
    "ahead is where the place is greater; yours goes backwards": _behind(
        lambda t, p, v: (t != t[v]) | (p < p[v])
    ),
    "all vertices that were reused count, not only the last one": _behind(
        lambda t, p, v: (t != t[v]) | (p > p[v]), slice(-1, None)
    ),
    "all vertices that were reused count, not only the first one": _behind(
        lambda t, p, v: (t != t[v]) | (p > p[v]), slice(0, 1)
    ),
    "a vertex's index says nothing about its place along its trajectory: compare place": _behind(
        lambda t, p, v: (t != t[v]) | (np.arange(len(p)) > v)
    ),
    "reused holds indices of vertices: place[vertex], not places": _behind(
        lambda t, p, v: (t != t[v]) | (p > v)
    ),
    "yours forbids what may be taken and allows the rest: invert it": lambda *case: (
        ~edge_rules.ahead_of(*case)
    ),
    "a vertex must lie ahead of all that were reused, not of one of them: and, not or": (
        lambda t, p, reused: (
            np.any([(t != t[v]) | (p > p[v]) for v in reused], axis=0)
            if reused
            else np.ones(len(p), dtype=bool)
        )
    ),
}


@check(edge_rules.ahead_of, _CASES["one of each trajectory"])
def check_ahead_of(student: Callable[..., Any]) -> None:
    """Six maps: nothing reused yet, one vertex, several, and indices in no order."""
    compare("ahead_of", student, _CASES, edge_rules.ahead_of, _FAULTS, form=_per_vertex)


def _per_vertex(what: str, got: object, trajectory: NDArray, *_: object) -> NDArray[np.bool_]:
    return mask(what, got, trajectory.shape)
