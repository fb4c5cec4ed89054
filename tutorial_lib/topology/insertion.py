"""How a trajectory joins a map (Meng 2020, III-E)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.topology.anchors import Anchors
from tutorial_lib.topology.comparison import Ask, searched, weakest_aligned
from tutorial_lib.topology.linking import ahead_of, outdated, reusable
from tutorial_lib.topology.retrieval import likeness, most_alike
from tutorial_lib.topology.topomap import Added, TopoMap
from tutorial_lib.topology.vertices import Numbers

_PASSING = 2
"""Anchors from one that sees what is before a vertex, to one that sees what is after it."""


def add_trajectory(topomap: TopoMap, anchors: Anchors) -> Added:
    """Join a trajectory to a map.

    Each anchor is compared with the vertices most alike, both ways. Where a vertex will do, it
    takes the anchor's place; the others become vertices. Edges are kept from `p_edge` on, and those
    along the trajectory always, since they were driven.

    Raises:
        InputError: when RE tells no probabilities, or its targets cannot be put on a map.
    """
    return Insertion(topomap, anchors).insert()


class Insertion:
    """One trajectory on its way into a map; V vertices are there, A anchors come.

    The columns of the matrices are the vertices and, behind them, the anchors themselves, so that a
    trajectory that comes by the same place twice is joined to itself.

    Attributes:
        out: (A, V + A) RE from anchors to columns, not a number where nobody asked.
        back: (A, V + A) RE from columns to anchors.
    """

    def __init__(self, topomap: TopoMap, anchors: Anchors, candidates: int | None = None) -> None:
        """Compare a trajectory with a map, which stays as it is until `insert`.

        Args:
            topomap: the map.
            anchors: of the trajectory.
            candidates: vertices to begin with, in place of those of the map's settings.
        """
        self.map, self.anchors, self.settings = topomap, anchors, topomap.settings
        self.candidates = topomap.settings.candidates if candidates is None else candidates
        vertices = topomap.vertices
        self.queries = vertices.queries
        self.prepared = vertices.reachability.prepare(anchors.contexts)
        if len(self.prepared) != len(anchors):
            raise InputError(
                f"reachability: prepared {len(self.prepared)} of {len(anchors)} anchors; give all"
            )
        self.count = len(vertices)
        self.before, self.after = self._neighbours()
        onward, back = self._seeds()
        self.out = self._searched(self._ask_out, onward)
        self.back = self._searched(self._ask_back, back)
        self._complete()

    def insert(self) -> Added:
        """Reuse, make vertices, and join them."""
        anchors, topomap = self.anchors, self.map
        trail, reused = self._reuse()
        fresh = np.flatnonzero(~reused)
        trail[fresh] = topomap.make_vertices(
            *anchors.some(fresh),
            np.full(len(fresh), len(topomap.trails)),
            fresh,
            self.prepared[fresh],
        )
        topomap.trails.append(trail.tolist())
        self._join(trail, fresh)
        self._follow(trail)
        gone = self._outdated(trail)
        topomap.remove(gone)
        return Added(trail, reused, gone, topomap.vertices.queries - self.queries)

    def _neighbours(self) -> tuple[Numbers, Numbers]:
        """(V + A,) the column before and after each on its trajectory, -1 for none."""
        before, after = np.full((2, self.count + len(self.anchors)), -1)
        for vertex in self.map.alive:
            trail, place = self.map.trail_of(int(vertex))
            before[vertex] = trail[place - 1] if place else -1
            after[vertex] = trail[place + 1] if place + 1 < len(trail) else -1
        own = np.arange(self.count, len(before))
        before[own[1:]], after[own[:-1]] = own[:-1], own[1:]
        return before, after

    def _seeds(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(A, V + A) pairs to ask about first, from and to the anchors."""
        worth = np.zeros(self.count + len(self.anchors), dtype=bool)
        worth[self.map.alive] = worth[self.count :] = True
        own = np.arange(len(self.anchors))
        pairs = np.tile(worth, (len(own), 1))
        # Consecutive anchors are joined anyway.
        pairs[:, self.count :] &= np.abs(own[:, None] - own) > 1
        if self.candidates >= worth.sum() or not self.map.embeds:
            return pairs, pairs.copy()
        seen, shown = self.map.embed(self.anchors.observations, self.prepared)
        index = self.map.index
        all_seen = np.concatenate([index.seen, seen]) if self.count else seen
        all_shown = np.concatenate([index.shown, shown]) if self.count else shown
        return (
            _best(likeness(seen, all_shown), pairs, self.candidates),
            _best(likeness(all_seen, shown).T, pairs, self.candidates),
        )

    def _searched(self, ask: Ask, seeds: NDArray[np.bool_]) -> Array:
        least = min(self.settings.p_edge, self.settings.p_reuse)
        return searched(ask, seeds, self.before, self.after, least)

    def _complete(self) -> None:
        """Ask what is missing about vertices that can be got to, or from, in place of an anchor."""
        least, vertices = self.settings.p_reuse, slice(0, self.count)
        before, after = neighbours(len(self.anchors))
        into, onward = self.out[before, vertices] > least, self.back[after, vertices] > least
        anchors, columns = np.nonzero(onward & np.isnan(self.out[before, vertices]))
        self.out[before[anchors], columns] = self._ask_out(before[anchors], columns)
        anchors, columns = np.nonzero(into & np.isnan(self.back[after, vertices]))
        self.back[after[anchors], columns] = self._ask_back(after[anchors], columns)

    def _ask_out(self, anchors: Numbers, columns: Numbers) -> Array:
        """RE from anchors to columns."""
        vertices, told = self.map.vertices, np.empty(len(anchors))
        own = columns >= self.count
        seen = self.anchors.observations
        told[~own] = vertices.into(seen, anchors[~own], columns[~own])
        told[own] = vertices.ask(seen, anchors[own], self.prepared, columns[own] - self.count)
        return told

    def _ask_back(self, anchors: Numbers, columns: Numbers) -> Array:
        """RE from columns to anchors."""
        vertices, told = self.map.vertices, np.empty(len(anchors))
        own = columns >= self.count
        told[~own] = vertices.onward(columns[~own], self.prepared, anchors[~own])
        seen = self.anchors.observations
        told[own] = vertices.ask(seen, columns[own] - self.count, self.prepared, anchors[own])
        return told

    def _reuse(self) -> tuple[Numbers, NDArray[np.bool_]]:
        """(A,) the vertex that takes the place of each anchor, -1 for none, and whether there is.

        Before the first anchor comes the first, and after the last the last: who stood there can go
        on from the vertex, or come near by it.
        """
        taken, chosen = np.full(len(self.anchors), -1), list[int]()
        out, back = np.nan_to_num(self.out), np.nan_to_num(self.back)
        for anchor, (before, after) in enumerate(zip(*neighbours(len(taken)), strict=True)):
            into, onward = out[before, : self.count], back[after, : self.count]
            into = self._from_before(int(taken[before]) if anchor else -1, into, onward)
            allowed = ahead_of(self.map.trajectory, self.map.place, chosen)
            taken[anchor] = reusable(into, onward, allowed, self.settings.p_reuse)
            if taken[anchor] >= 0:
                chosen.append(int(taken[anchor]))
        return taken, taken >= 0

    def _from_before(self, before: int, into: Array, onward: Array) -> Array:
        """RE (V,) to vertices from what the anchor before is now."""
        if before < 0:
            return into
        worth = np.flatnonzero((onward > self.settings.p_reuse) & (into > self.settings.p_reuse))
        told = np.zeros(self.count)
        told[worth] = self.map.vertices.between(np.full(len(worth), before), worth)
        return told

    def _join(self, trail: Numbers, fresh: Numbers) -> None:
        """Edges between new vertices and all others, scored by aligned sequences."""
        least = self.settings.p_edge
        out, back = (
            weakest_aligned(told, self.before, self.after, self.settings.sequence)
            for told in (self.out, self.back)
        )
        column = np.concatenate([np.arange(self.count), trail])
        new = np.isin(np.arange(len(trail)), fresh)
        # An anchor that was given up for a vertex is no end of an edge.
        there = np.concatenate([np.ones(self.count, dtype=bool), new])
        for anchor, other in np.argwhere((out > least) & there & new[:, None]):
            self.map.connect(int(trail[anchor]), int(column[other]), out[anchor, other])
        # Pairs of anchors are in both matrices.
        old = np.arange(len(column)) < self.count
        for anchor, other in np.argwhere((back > least) & old & new[:, None]):
            self.map.connect(int(column[other]), int(trail[anchor]), back[anchor, other])

    def _follow(self, trail: Numbers) -> None:
        """Edges along the trajectory, which were driven whatever RE may say."""
        told = self.map.vertices.between(trail[:-1], trail[1:])
        for source, target, probability in zip(trail[:-1], trail[1:], told, strict=True):
            if source != target:
                self.map.connect(int(source), int(target), probability, driven=1)

    def _outdated(self, trail: Numbers) -> Numbers:
        """Vertices that look different by now: those around them were seen again, they were not."""
        before, after, out = self.before[: self.count], self.after[: self.count], self.out.copy()
        seen = out[:, : self.count] > self.settings.p_edge
        near = outdated(seen, ~seen, before, after, _PASSING)
        near = near[~np.isin(near, trail)]
        rows, columns = np.nonzero(np.isnan(out[:, near]))
        out[rows, near[columns]] = self._ask_out(rows, near[columns])
        gone = outdated(
            seen, out[:, : self.count] < self.settings.p_outdated, before, after, _PASSING
        )
        return np.intersect1d(gone, near)


def neighbours(anchors: int) -> tuple[Numbers, Numbers]:
    """(A,) the anchor before and the one after each; at the ends it is the anchor itself."""
    own = np.arange(anchors)
    return np.maximum(own - 1, 0), np.minimum(own + 1, anchors - 1)


def _best(alike: Array, pairs: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """The `count` of each row's `pairs` (A, C) that are most alike."""
    best = most_alike(np.where(pairs, alike, -np.inf), count)
    found = np.zeros_like(pairs)
    found[np.arange(len(pairs))[:, None], best] = True
    return found & pairs
