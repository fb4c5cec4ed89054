"""Which vertices of a map replace the anchors of a new trajectory (Meng 2020, III-E)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.edge_rules import ahead_of, reusable, reusable_edge
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.vertices import Indices


class Replacements:
    """The vertices that replace anchors, found for one anchor after the other.

    Where no vertex can replace an anchor, an edge of the map on which it lies may (not in the
    paper): both of its vertices then stand for the anchor.

    Attributes:
        path: (A,) the vertex that replaces each anchor, -1 for none; of an edge it is the target.
        sources: (A,) the source of the edge that does, -1 where no edge does.
    """

    def __init__(
        self, topomap: TopoMap, out: Array, back: Array, matched: NDArray[np.bool_]
    ) -> None:
        """Find them; the map does not change.

        Args:
            topomap: the map of V vertices.
            out: (A, V) RE from anchors to vertices, 0 where it was not queried.
            back: (A, V) RE from vertices to anchors, likewise.
            matched: (A, V) which vertices may replace which anchors at all.
        """
        self._map, self._out, self._back = topomap, out, back
        self.path, self.sources = np.full((2, len(out)), -1)
        chosen: list[int] = []
        for anchor, (before, after) in enumerate(zip(*neighbours(len(out)), strict=True)):
            allowed = ahead_of(topomap.trajectory, topomap.place, chosen) & matched[anchor]
            self._replace(anchor, int(before), int(after), allowed)
            found = (self.sources[anchor], self.path[anchor])
            chosen += [int(vertex) for vertex in found if vertex >= 0]

    @property
    def places(self) -> Indices:
        """(A,) the place of each anchor's vertex on the path that is laid."""
        return np.arange(len(self.path)) + np.cumsum(self.sources >= 0)

    def laid(self, path: Indices) -> Indices:
        """(P,) all vertices that the trajectory passes, of (A,) the vertex of each anchor."""
        passed = np.stack([self.sources, path], axis=1).ravel()
        return passed[passed >= 0]

    def _replace(self, anchor: int, before: int, after: int, allowed: NDArray[np.bool_]) -> None:
        """Find what replaces one anchor; at the ends the anchor is its own neighbour."""
        least, onward = self._map.settings.p_reuse, self._back[after]
        into = self._into(anchor, before, allowed & (onward > least))
        self.path[anchor] = reusable(into, onward, allowed, least)
        if self.path[anchor] >= 0:
            return
        edges, probabilities = self._edges_around(anchor, allowed)
        sources = np.zeros(len(allowed), dtype=bool)
        sources[edges[:, 0]] = True
        into = self._into(anchor, before, sources)
        found = reusable_edge(into, onward, edges, probabilities, least)
        if found is not None:
            self.sources[anchor], self.path[anchor] = found

    def _into(self, anchor: int, before: int, worth: NDArray[np.bool_]) -> Array:
        """RE (V,) to vertices from what stands for the anchor `before`, where `worth` it (V,)."""
        vertex = int(self.path[before]) if anchor != before else -1
        if vertex < 0:
            return self._out[before]
        probabilities, targets = np.zeros(len(worth)), np.flatnonzero(worth)
        probabilities[targets] = self._map.vertices.between(np.full(len(targets), vertex), targets)
        return probabilities

    def _edges_around(self, anchor: int, allowed: NDArray[np.bool_]) -> tuple[Indices, Array]:
        """Edges (E, 2) of the map on which an anchor lies, and their probabilities (E,)."""
        least = self._map.settings.p_between
        trajectory, place = self._map.trajectory, self._map.place
        sources = np.flatnonzero(allowed & (self._back[anchor] > least))
        targets = set(np.flatnonzero(allowed & (self._out[anchor] > least)).tolist())
        found = [
            (source, target, edge["probability"])
            for source, target, edge in self._map.graph.out_edges(sources.tolist(), data=True)
            if target in targets
            and "turn" not in edge
            and (trajectory[source] != trajectory[target] or place[source] < place[target])
        ]
        rows = np.array(found, dtype=float).reshape(-1, 3)
        return rows[:, :2].astype(np.intp), rows[:, 2]


def neighbours(anchors: int) -> tuple[Indices, Indices]:
    """(A,) the anchor before and the one after each; at the ends it is the anchor itself."""
    own = np.arange(anchors)
    return np.maximum(own - 1, 0), np.minimum(own + 1, anchors - 1)
