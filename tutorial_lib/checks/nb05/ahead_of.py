"""The check of which vertices lie ahead of those reused, in notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import calling, mask
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.topology.mapping import edge_rules

Case = tuple[NDArray, NDArray, list[int]]


def _random_case(seed: int) -> Case:
    """Vertices of some trajectories, in no order; those reused follow no rule."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 14))
    trajectory, place = rng.integers(0, 3, count), rng.permutation(count)
    reused = rng.choice(count, int(rng.integers(0, 4)), replace=False)
    return trajectory, place, reused.tolist()


_CASES: dict[str, Case] = {
    name: (np.array(trajectory, dtype=int), np.array(place, dtype=int), reused)
    for name, trajectory, place, reused in (
        ("nothing was reused yet", [0, 0, 0, 1, 1], [0, 1, 2, 0, 1], []),
        ("one was reused", [0, 0, 0, 1, 1], [0, 1, 2, 0, 1], [1]),
        ("one of each trajectory", [0, 0, 0, 1, 1, 1], [0, 1, 2, 0, 1, 2], [1, 3]),
        ("two of the same trajectory", [0, 0, 0, 0, 1], [0, 1, 2, 3, 0], [1, 2]),
        ("one, then one of another", [0, 0, 0, 0, 1, 1], [0, 1, 2, 3, 0, 1], [2, 5, 3]),
        ("indices in no order", [2, 0, 2, 0, 2, 0], [5, 4, 1, 0, 3, 2], [4, 5]),
        ("the farthest was reused first", [0, 0, 0, 0], [0, 1, 2, 3], [2, 0]),
        ("vertex 0 was reused", [0, 0, 1], [0, 1, 0], [0]),
        ("the last one was reused", [0, 0, 1], [0, 1, 0], [1]),
    )
} | {f"a map drawn at random ({seed})": _random_case(seed) for seed in range(12)}


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
    "of other trajectories all may be taken; yours allows only the one that was reused": _behind(
        lambda t, p, v: (t == t[v]) & (p > p[v])
    ),
    "of the same trajectory those that lie ahead may be taken": _behind(lambda t, p, v: t != t[v]),
    "not only the next one: all that lie ahead on the trajectory may be taken": _behind(
        lambda t, p, v: (t != t[v]) | (p == p[v] + 1)
    ),
    "only the reused vertex itself is forbidden in yours; those behind it are, too": _behind(
        lambda t, p, v: np.arange(len(p)) != v
    ),
    "ahead is where the place is greater; yours goes backwards": _behind(
        lambda t, p, v: (t != t[v]) | (p < p[v])
    ),
    "all vertices that were reused count, not only the last one": _behind(
        lambda t, p, v: (t != t[v]) | (p > p[v]), slice(-1, None)
    ),
    "all vertices that were reused count, not only the first one": _behind(
        lambda t, p, v: (t != t[v]) | (p > p[v]), slice(0, 1)
    ),
    "the vertices in reused are in the order of reuse: all of them count, not only the greatest": (
        lambda t, p, reused: edge_rules.ahead_of(t, p, [max(reused)] if reused else [])
    ),
    "of each trajectory all that were reused count, not only the last: the farthest decides": (
        lambda t, p, reused: edge_rules.ahead_of(
            t, p, list({int(t[v]): v for v in reused}.values())
        )
    ),
    "as long as nothing was reused, all vertices may be taken": lambda t, p, reused: (
        edge_rules.ahead_of(t, p, reused) & bool(reused)
    ),
    "a vertex's index says nothing about its place along its trajectory: compare place": _behind(
        lambda t, p, v: (t != t[v]) | (np.arange(len(p)) > v)
    ),
    "reused holds indices of vertices: trajectory[vertex], not trajectories": _behind(
        lambda t, p, v: (t != v) | (p > p[v])
    ),
    "of trajectories of which nothing was reused all vertices may be taken": (
        lambda t, p, reused: (
            edge_rules.ahead_of(t, p, reused) & np.isin(t, t[np.array(reused, dtype=int)])
        )
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
    """Maps of several trajectories: nothing reused yet, one vertex, several, and no order."""
    invoke = calling(
        {
            IndexError: "reused may be empty, and holds indices of vertices",
            ValueError: "reused may be empty; then all vertices may be taken",
        }
    )
    compare(
        "ahead_of",
        student,
        _CASES,
        edge_rules.ahead_of,
        _FAULTS,
        invoke=invoke,
        form=_per_vertex,
        difference=_why,
    )


def _per_vertex(what: str, got: object, trajectory: NDArray, *_: object) -> NDArray[np.bool_]:
    return mask(what, got, trajectory.shape)


def _why(
    got: NDArray[np.bool_],
    want: NDArray[np.bool_],
    trajectory: NDArray,
    place: NDArray,
    reused: list[int],
) -> str:
    """The first vertex about which an answer is wrong."""
    vertex = int(np.flatnonzero(got != want)[0])
    its = f"vertex {vertex} (trajectory {trajectory[vertex]}, place {place[vertex]})"
    if not reused:
        return f"yours forbids {its}, but nothing was reused: all may be taken"
    own = [v for v in reused if trajectory[v] == trajectory[vertex]]
    if want[vertex]:
        places = f"reused were places {[int(place[v]) for v in own]}, all before it"
        why = places if own else "none of its trajectory was reused"
        return f"yours forbids {its}, but {why}"
    bar = max(own, key=lambda v: place[v])
    words = f"vertex {bar} at place {place[bar]} of the same trajectory was reused"
    return f"yours allows {its}, but {words}; only greater places lie ahead"
