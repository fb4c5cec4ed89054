"""Known mistakes in inserting a trajectory into a map, for the check of notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.nb05.small_map import SmallMap, Through, connect, extend, insert, through
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping import edge_rules
from tutorial_lib.topology.mapping.vertices import Indices

Change = Callable[[SmallMap, SmallMap, Indices, Array], None]
"""Makes a mistake in the new map, given the old one, the trajectory and the scores."""


def _through(from_anchor: bool = False, backwards: bool = False, same: bool = False) -> Through:
    """Another choice of what is before and after."""

    def rule(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
        into, onward = through(grown, own, own.tolist() if from_anchor else path, i)
        after = own[i] if same else own[min(i + 1, len(own) - 1)]
        if same:
            into, onward = into, grown.reach[grown.vertices, after]
        return into, grown.reach[after, grown.vertices] if backwards else onward

    return rule


def _all_allowed(trajectory: Indices, *_: object) -> NDArray[np.bool_]:
    return np.ones(len(trajectory), dtype=bool)


def _last_only(trajectory: Indices, place: Indices, reused: list[int]) -> NDArray[np.bool_]:
    return edge_rules.ahead_of(trajectory, place, reused[-1:])


def _then(change: Change) -> Callable[..., None]:
    """The right insertion, followed by a mistake."""

    def rule(grown: SmallMap, own: Indices, scores: Array, p_reuse: float) -> None:
        old = SmallMap(*(getattr(grown, name) for name in SmallMap.__dataclass_fields__))
        for name in ("edge_reach", "driven", "trajectory", "place", "before", "after"):
            setattr(old, name, getattr(grown, name).copy())
        insert(grown, own, scores, p_reuse)
        change(grown, old, own, scores)

    return rule


def _new(grown: SmallMap, old: SmallMap) -> list[int]:
    return [vertex for vertex in grown.vertices if vertex not in old.vertices]


def _one_direction(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    for vertex in _new(grown, old):
        grown.edge_reach[old.vertices, vertex] = 0.0
    _follow(grown)


def _not_among_themselves(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    new = _new(grown, old)
    grown.edge_reach[np.ix_(new, new)] = 0.0
    _follow(grown)


def _only_driven(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    grown.edge_reach[:] = old.edge_reach
    _follow(grown)


def _by_reach(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    connect(grown, own, grown.paths[-1], grown.reach)


def _follow(grown: SmallMap) -> None:
    """The steps of the last path are edges all the same."""
    for source, target in pairwise(grown.paths[-1]):
        if source != target:
            steps = grown.edge_reach[source, target], grown.reach[source, target]
            grown.edge_reach[source, target] = max(steps)


def _own_anchors_driven(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    grown.driven[:] = old.driven
    grown.driven[own[:-1], own[1:]] = True


def _both_ways(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    grown.driven |= grown.driven.T


def _no_driven_reach(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    grown.edge_reach[:] = old.edge_reach
    new = _new(grown, old)
    everything = grown.vertices
    grown.edge_reach[np.ix_(new, everything)] = scores[np.ix_(new, everything)]
    grown.edge_reach[np.ix_(everything, new)] = scores[np.ix_(everything, new)]
    np.fill_diagonal(grown.edge_reach, 0.0)


def _from_0(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    for place, vertex in enumerate(_new(grown, old)):
        grown.place[vertex] = place


def _nothing_new(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    path = grown.paths[-1]
    for name in ("vertices", "edge_reach", "driven", "trajectory", "place", "before", "after"):
        setattr(grown, name, getattr(old, name))
    grown.paths = [*old.paths, path]


def _keeps_all(grown: SmallMap, own: Indices, scores: Array, p_reuse: float) -> None:
    extend(grown, own, own.tolist())
    connect(grown, own, own.tolist(), scores)


FAULTS: dict[str, Callable[..., None]] = {
    "your trajectory never reuses a vertex: call reusable for each anchor": _keeps_all,
    "if the anchor before was replaced, the robot stands on the vertex that replaced it: take RE "
    "from that one, not from the anchor": partial(insert, through=_through(from_anchor=True)),
    "onward is RE from the vertex to the anchor after: row the vertex, column the anchor": partial(
        insert, through=_through(backwards=True)
    ),
    "onward leads to the anchor after, own[i + 1], not to the anchor itself": partial(
        insert, through=_through(same=True)
    ),
    "never backwards: ask ahead_of which vertices may be taken": partial(
        insert, ahead_of=_all_allowed
    ),
    "ahead_of needs all vertices that were reused so far, not only the last one": partial(
        insert, ahead_of=_last_only
    ),
    "join in both directions: from the new vertices and to them": _then(_one_direction),
    "the new vertices are joined with each other, too": _then(_not_among_themselves),
    "new vertices are joined with all others, not only along the trajectory": _then(_only_driven),
    "edges have the RE in scores; only driven steps take at least that in reach": _then(_by_reach),
    "driven steps lead over the vertices of the path, not over anchors that were replaced": _then(
        _own_anchors_driven
    ),
    "a trajectory is driven in one direction only": _then(_both_ways),
    "a driven step that is no new pair needs its RE in edge_reach, too: at least reach": _then(
        _no_driven_reach
    ),
    "the place counts all anchors of the trajectory, also those that were replaced": _then(_from_0),
    "the path is right, but the map did not grow: add the new vertices": _then(_nothing_new),
}
