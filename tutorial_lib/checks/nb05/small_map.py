"""A map of indices, small enough to look into, for notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping import edge_rules
from tutorial_lib.topology.mapping.vertices import Indices

Through = Callable[["SmallMap", Indices, list[int], int], tuple[Array, Array]]
"""RE (V,) to each vertex from the anchor before, and from each to the anchor after."""


@dataclass(eq=False)
class SmallMap:
    """A map whose vertices are anchors, named by their index in a table of RE.

    Attributes:
        reach: (N, N) RE between all N anchors that there are.
        vertices: the anchors that are vertices, in the order in which they were added.
        paths: for each trajectory the vertices that it leads over.
        edge_reach: (N, N) RE of the pairs that may be edges, 0 elsewhere.
        driven: (N, N) True where a trajectory goes from vertex to vertex.
        trajectory, place: (N,) the trajectory that a vertex was made for, and its place there from
            0; -1 for anchors that are no vertices.
        before, after: (N,) the vertex next to a vertex on its own trajectory, -1 for none.
    """

    reach: Array
    vertices: list[int]
    paths: list[list[int]]
    edge_reach: Array
    driven: NDArray[np.bool_]
    trajectory: Indices
    place: Indices
    before: Indices
    after: Indices

    @classmethod
    def empty(cls, reach: Array) -> SmallMap:
        """A map without vertices."""
        count = len(reach)
        tables = np.zeros((count, count)), np.zeros((count, count), dtype=bool)
        return cls(reach, [], [], *tables, *np.full((4, count), -1))


def through(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
    """RE (V,) to each vertex from what is before anchor i, and from each to the anchor after.

    Args:
        grown: the map.
        own: anchors of the trajectory.
        path: the vertices of the anchors before i.
        i: of the anchor.
    """
    before, after = path[i - 1] if i else own[0], own[min(i + 1, len(own) - 1)]
    return grown.reach[before, grown.vertices], grown.reach[grown.vertices, after]


def insert(
    grown: SmallMap,
    own: Indices,
    scores: Array,
    p_reuse: float,
    through: Through = through,
    ahead_of: Callable[..., NDArray[np.bool_]] = edge_rules.ahead_of,
    reusable: Callable[..., int] = edge_rules.reusable,
) -> None:
    """Insert a trajectory into a map (Meng 2020, III-E).

    Args:
        grown: the map, which changes.
        own: (A,) the trajectory's anchors, in order.
        scores: (N, N) RE of pairs as edges; with sequences the least of those aligned.
        p_reuse: RE above which a vertex takes an anchor's place.
        through: RE by which vertices are judged.
        ahead_of: which vertices may be taken after others.
        reusable: which of them takes an anchor's place.
    """
    path, reused = [], []
    for i, anchor in enumerate(own):
        into, onward = through(grown, own, path, i)
        allowed = ahead_of(grown.trajectory, grown.place, reused)[grown.vertices]
        found = reusable(into, onward, allowed, p_reuse)
        if found >= 0:
            reused.append(grown.vertices[found])
        path.append(int(anchor) if found < 0 else grown.vertices[found])
    extend(grown, own, path)
    connect(grown, own, path, scores)


def extend(grown: SmallMap, own: Indices, path: list[int]) -> None:
    """Add the anchors that were not replaced as vertices, and the path."""
    ends = [-1, *path, -1]
    for place, anchor in enumerate(int(a) for a in own):
        if path[place] == anchor:
            grown.vertices = [*grown.vertices, anchor]
            grown.trajectory[anchor], grown.place[anchor] = len(grown.paths), place
            grown.before[anchor], grown.after[anchor] = ends[place], ends[place + 2]
    grown.paths = [*grown.paths, path]


def connect(grown: SmallMap, own: Indices, path: list[int], scores: Array) -> None:
    """Join the new vertices with all others, and mark the steps of the trajectory."""
    for vertex in set(own.tolist()) & set(path):
        others = [other for other in grown.vertices if other != vertex]
        grown.edge_reach[vertex, others] = scores[vertex, others]
        grown.edge_reach[others, vertex] = scores[others, vertex]
    for source, target in pairwise(path):
        if source != target:
            grown.driven[source, target] = True
            known = grown.edge_reach[source, target]
            grown.edge_reach[source, target] = max(known, grown.reach[source, target])
