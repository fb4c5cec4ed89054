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


def _cut(first: bool) -> Through:
    """Nothing fits at one end of the trajectory."""

    def rule(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
        into, onward = through(grown, own, path, i)
        return into * (i != (0 if first else len(own) - 1)), onward

    return rule


def _alike(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
    return grown.reach[own[i], grown.vertices], through(grown, own, path, i)[1]


def _reversed(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
    before = path[i - 1] if i else own[0]
    return grown.reach[grown.vertices, before], through(grown, own, path, i)[1]


def _round(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
    return through(grown, own, path, i)[0], grown.reach[grown.vertices, own[(i + 1) % len(own)]]


def _by_scores(into: bool) -> Callable[..., None]:
    """Reuse by RE as edges."""

    def rule(grown: SmallMap, own: Indices, scores: Array, p_reuse: float) -> None:
        def judged(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
            seen = SmallMap(**{**vars(grown), "reach": scores})
            right, other = through(grown, own, path, i), through(seen, own, path, i)
            return (other[0], right[1]) if into else (right[0], other[1])

        insert(grown, own, scores, p_reuse, through=judged)

    return rule


def _same_back(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    for vertex in _new(grown, old):
        others = [v for v in grown.vertices if v != vertex]
        grown.edge_reach[vertex, others] = scores[vertex, others]
        grown.edge_reach[others, vertex] = scores[vertex, others]
    _follow(grown)


def _among_themselves(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    new = _new(grown, old)
    grown.edge_reach[np.ix_(new, old.vertices)] = 0.0
    grown.edge_reach[np.ix_(old.vertices, new)] = 0.0
    _follow(grown)


def _overwritten(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    for source, target in pairwise(grown.paths[-1]):
        grown.edge_reach[source, target] = grown.reach[source, target]


def _surely_driven(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    for source, target in pairwise(grown.paths[-1]):
        grown.edge_reach[source, target] = 1.0


def _path_again(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    path = grown.paths[-1]
    for vertex in path:
        others = [v for v in grown.vertices if v != vertex]
        grown.edge_reach[vertex, others] = scores[vertex, others]
        grown.edge_reach[others, vertex] = scores[others, vertex]
    _follow(grown)


def _new_steps_driven(grown: SmallMap, old: SmallMap, own: Indices, scores: Array) -> None:
    new = _new(grown, old)
    for source, target in pairwise(grown.paths[-1]):
        grown.driven[source, target] = source in new or target in new


FAULTS: dict[str, Callable[..., None]] = {
    "the first anchor may be replaced, too: into is RE from the anchor itself": partial(
        insert, through=_cut(first=True)
    ),
    "the last anchor may be replaced, too: onward is RE to the anchor itself": partial(
        insert, through=_cut(first=False)
    ),
    "into leads from what stands on the path before, not from the anchor itself": partial(
        insert, through=_alike
    ),
    "into is RE to the vertex: row what stands on the path before, column the vertex": partial(
        insert, through=_reversed
    ),
    "the last anchor is its own successor; yours leads on to the first one": partial(
        insert, through=_round
    ),
    "reuse asks reach; scores are for the edges": _by_scores(into=True),
    "reuse asks reach onward, too; scores are for the edges": _by_scores(into=False),
    "the edge back has the RE back, scores[other, vertex]; RE is not symmetric": _then(_same_back),
    "new vertices are joined with the old ones, too": _then(_among_themselves),
    "edge_reach of a driven step is at least reach; where scores has more, that stays": _then(
        _overwritten
    ),
    "a driven step has the RE in reach, if scores has not more; it is not sure": _then(
        _surely_driven
    ),
    "only new vertices are joined; those that were reused have their edges already": _then(
        _path_again
    ),
    "every step of the path is driven, also between vertices that were there": _then(
        _new_steps_driven
    ),
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
    "p_reuse is an argument, and not always 0.99": lambda grown, own, scores, p: insert(
        grown, own, scores, 0.99
    ),
}
