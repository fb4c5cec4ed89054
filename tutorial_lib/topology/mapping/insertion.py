"""How a trajectory is added to a map (Meng 2020, III-E)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.edge_rules import ahead_of, outdated, reusable, reusable_edge
from tutorial_lib.topology.mapping.edge_search import (
    along_trajectories,
    search_edges,
    weakest_aligned,
)
from tutorial_lib.topology.mapping.retrieval import likeness, most_alike
from tutorial_lib.topology.mapping.topomap import Added, TopoMap
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.validation import instance

_PASSING = 2
"""Anchors at most from one that sees the vertex before, to one that sees the vertex after."""


def add_trajectory(topomap: TopoMap, anchors: Anchors) -> Added:
    """Add a trajectory to a map.

    Each anchor is compared with the most similar vertices, in both directions. Where a vertex can
    replace it, that is reused; the other anchors become vertices. Edges are kept above `p_edge`,
    and those along the trajectory always, since they were driven.

    Raises:
        InputError: when RE returns no probabilities, or its targets cannot be stored in a map.
    """
    instance("topomap", topomap, TopoMap)
    return Insertion(topomap, instance("anchors", anchors, Anchors)).insert()


class Insertion:
    """Adds a trajectory of A anchors to a map of V vertices.

    The columns of the matrices are the vertices and, behind them, the anchors themselves, so that a
    trajectory that passes the same place twice is joined to itself.

    Attributes:
        out: (A, V + A) RE from anchors to columns, NaN where it was not queried.
        back: (A, V + A) RE from columns to anchors, likewise.
    """

    def __init__(self, topomap: TopoMap, anchors: Anchors, candidates: int | None = None) -> None:
        """Compare a trajectory with a map, which does not change until `insert`.

        Args:
            topomap: the map.
            anchors: of the trajectory.
            candidates: replaces that of the map's settings.
        """
        self.map, self.anchors, self.settings = topomap, anchors, topomap.settings
        self.candidates = topomap.settings.candidates if candidates is None else candidates
        vertices = topomap.vertices
        self.queries = vertices.queries
        self.prepared = self._prepared()
        self.count = len(vertices)
        self.along = self._along(max(self.settings.sequence, self.settings.reuse_sequence, 1))
        worth, worth_back = self._worth()
        onward, back = self._seeds(worth, worth_back)
        least = min(self.settings.p_edge, self.settings.p_reuse)
        self.out = search_edges(self._query_out, onward, worth, self.along, least)
        self.back = search_edges(self._query_back, back, worth_back, self.along, least)
        self._complete()

    def insert(self) -> Added:
        """Reuse vertices, make new ones, and join them."""
        anchors, topomap = self.anchors, self.map
        vertices = slice(0, self.count)
        out, back = np.nan_to_num(self.out[:, vertices]), np.nan_to_num(self.back[:, vertices])
        replaced = Replacements(topomap, out, back, self._matched())
        path, reused = replaced.path.copy(), replaced.path >= 0
        fresh = np.flatnonzero(~reused)
        path[fresh] = topomap.make_vertices(
            *anchors.subset(fresh),
            np.full(len(fresh), len(topomap.paths)),
            replaced.places[fresh],
            self.prepared[fresh],
        )
        passed = replaced.laid(path)
        topomap.paths.append(passed.tolist())
        self._join(path, fresh)
        self._follow(passed)
        gone = self._outdated(passed)
        topomap.remove(gone)
        return Added(path, reused, gone, topomap.vertices.queries - self.queries)

    def _prepared(self) -> Any:  # noqa: ANN401
        """The anchors as targets, as they were prepared for sparsifying if by the same RE."""
        vertices, anchors = self.map.vertices, self.anchors
        if anchors.prepared is not None and anchors.prepared_by is vertices.reachability:
            return vertices.checked(anchors.prepared, len(anchors))
        return vertices.prepare(anchors.contexts)

    def _along(self, reach: int) -> Indices:
        """(V + A, 2R+1) the columns around each on its trajectory, -1 beyond its ends."""
        topomap, own = self.map, np.arange(len(self.anchors))
        there = along_trajectories(topomap.paths, topomap.trajectory, topomap.place, reach)
        here = along_trajectories([own.tolist()], np.zeros_like(own), own, reach)
        return np.concatenate([there, np.where(here < 0, -1, here + self.count)])

    def _worth(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(A, V + A) pairs that may be queried, from and to the anchors."""
        own = np.arange(len(self.anchors))
        worth = np.zeros((len(own), self.count + len(own)), dtype=bool)
        worth[:, self.map.alive] = True
        back = worth.copy()  # pairs of anchors are in the other matrix
        # From an anchor to the next one is driven.
        worth[:, self.count :] = ~np.isin(own - own[:, None], (0, 1))
        return worth, back

    def _seeds(
        self, worth: NDArray[np.bool_], back: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(A, V + A) pairs to query first: the most similar ones."""
        if self.candidates >= worth.shape[1] or not self.map.embeds:
            return worth, back
        seen = self.map.see(self.anchors.observations)
        shown = self.map.show(self.anchors.observations, self.prepared)
        index = self.map.index
        all_seen = np.concatenate([index.seen, seen]) if self.count else seen
        all_shown = np.concatenate([index.shown, shown]) if self.count else shown
        return (
            _best(likeness(seen, all_shown), worth, self.candidates),
            _best(likeness(all_seen, shown).T, back, self.candidates),
        )

    def _complete(self) -> None:
        """Query the missing direction of vertices that may replace an anchor."""
        least, vertices = self.settings.p_reuse, slice(0, self.count)
        before, after = neighbours(len(self.anchors))
        into, onward = self.out[before, vertices] > least, self.back[after, vertices] > least
        anchors, columns = np.nonzero(onward & np.isnan(self.out[before, vertices]))
        self.out[before[anchors], columns] = self._query_out(before[anchors], columns)
        anchors, columns = np.nonzero(into & np.isnan(self.back[after, vertices]))
        self.back[after[anchors], columns] = self._query_back(after[anchors], columns)

    def _query_out(self, anchors: Indices, columns: Indices) -> Array:
        """RE from anchors to columns."""
        vertices, probabilities = self.map.vertices, np.empty(len(anchors))
        own = columns >= self.count
        seen = self.anchors.observations
        probabilities[~own] = vertices.into(seen, anchors[~own], columns[~own])
        probabilities[own] = vertices.query(
            seen, anchors[own], self.prepared, columns[own] - self.count
        )
        return probabilities

    def _query_back(self, anchors: Indices, columns: Indices) -> Array:
        """RE from vertices to anchors."""
        return self.map.vertices.onward(columns, self.prepared, anchors)

    def scores(self) -> tuple[Array, Array]:
        """The least RE (A, V + A) over aligned sequences, from anchors to columns and back."""
        along = self.along, self.settings.sequence, self.settings.p_edge
        return (
            weakest_aligned(self._query_out, self.out, *along),
            weakest_aligned(self._query_back, self.back, *along),
        )

    def _matched(self) -> NDArray[np.bool_]:
        """(A, V) whether the sequences around an anchor and a vertex are alike, if that matters."""
        least, reach = self.settings.p_reuse, self.settings.reuse_sequence
        if not reach:
            return np.ones((len(self.anchors), self.count), dtype=bool)
        weakest = weakest_aligned(self._query_out, self.out, self.along, reach, least)
        return weakest[:, : self.count] > least

    def _join(self, path: Indices, fresh: Indices) -> None:
        """Edges between new vertices and all others, scored by aligned sequences."""
        least = self.settings.p_edge
        out, back = self.scores()
        column = np.concatenate([np.arange(self.count), path])
        new = np.isin(np.arange(len(path)), fresh)
        # An anchor that was replaced by a vertex is no end of an edge.
        there = np.concatenate([np.ones(self.count, dtype=bool), new])
        for anchor, other in np.argwhere((out > least) & there & new[:, None]):
            self.map.connect(int(path[anchor]), int(column[other]), out[anchor, other])
        for anchor, other in np.argwhere((back > least) & new[:, None]):
            self.map.connect(int(column[other]), int(path[anchor]), back[anchor, other])

    def _follow(self, path: Indices) -> None:
        """Edges along the trajectory, which were driven whatever RE predicts."""
        probabilities = self.map.vertices.between(path[:-1], path[1:])
        for source, target, probability in zip(path[:-1], path[1:], probabilities, strict=True):
            if source != target:
                self.map.connect(int(source), int(target), probability, driven=1)

    def _outdated(self, path: Indices) -> Indices:
        """Vertices that look different by now: those around them were seen again, they were not."""
        middle, out = self.along.shape[1] // 2, self.out.copy()
        before, after = self.along[: self.count, [middle - 1, middle + 1]].T
        seen = out[:, : self.count] > self.settings.p_edge
        near = outdated(seen, ~seen, before, after, _PASSING)
        near = near[~np.isin(near, path)]
        rows, columns = np.nonzero(np.isnan(out[:, near]))
        out[rows, near[columns]] = self._query_out(rows, near[columns])
        gone = outdated(
            seen, out[:, : self.count] < self.settings.p_outdated, before, after, _PASSING
        )
        return np.intersect1d(gone, near)


def _best(alike: NDArray[np.floating], pairs: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """The `count` most similar of each row's `pairs` (A, C)."""
    best = most_alike(np.where(pairs, alike, -np.inf), count)
    found = np.zeros_like(pairs)
    found[np.arange(len(pairs))[:, None], best] = True
    return found & pairs


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
