"""The topological map: what was seen where, and what can be reached from it (Meng 2020, III-E)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.edge_rules import MapSettings, Trail, weight
from tutorial_lib.topology.mapping.retrieval import Embedding, Index, likeness, most_alike
from tutorial_lib.topology.mapping.vertices import Numbers, Vertices


class TopoMap:
    """A directed graph of contextified anchors; `insertion.add_trajectory` lets it grow.

    Attributes:
        graph: on networkx. An edge has `probability` (RE), `weight` (-log RE) and `driven`: how
            often a trajectory went along it.
        vertices: what is known of each vertex of the graph.
        settings: when RE is believed.
        trails: for each trajectory its vertices, in order.
        trajectory, place: (V,) the trajectory that each vertex was made for, and its place there.
        index: what the vertices look like, where `reachability` can embed.
    """

    def __init__(self, reachability: Reachability, settings: MapSettings | None = None) -> None:
        """An empty map. Where `reachability` cannot `embed`, every vertex is asked about."""
        self.graph = nx.DiGraph()
        self.vertices = Vertices(reachability)
        self.settings = MapSettings() if settings is None else settings
        self.trails: list[list[int]] = []
        self.trajectory = self.place = np.empty(0, dtype=np.intp)
        self.index = Index()

    def __len__(self) -> int:
        return len(self.graph)

    @property
    def alive(self) -> Numbers:
        """(len,) numbers of the vertices that were not removed."""
        return np.array(sorted(self.graph), dtype=np.intp)

    @property
    def embeds(self) -> bool:
        """Whether the estimator tells what pictures look like."""
        return hasattr(self.vertices.reachability, "embed")

    def see(self, observations: Observation) -> Embedding:
        """(N, R, D) what is seen in N observations."""
        return np.asarray(self.vertices.reachability.embed(observations))

    def show(self, observations: Observation, prepared: Any) -> Embedding:  # noqa: ANN401
        """(N, P, R, D) what N targets show; what is seen there, if RE embeds no targets."""
        reachability = self.vertices.reachability
        if hasattr(reachability, "embed_targets"):
            return reachability.embed_targets(prepared)
        return self.see(observations)[:, None]

    def nearby(self, observations: Observation, count: int) -> Numbers:
        """(N, C) numbers of vertices that may be reached from N observations, C <= count."""
        alive = self.alive
        if not self.embeds or len(alive) <= count:
            return np.tile(alive, (len(observations), 1))
        seen = self.see(observations)
        return alive[most_alike(likeness(seen, self.index.shown[alive]), count)]

    def around(self, observations: Observation, prepared: Any, count: int) -> Numbers:  # noqa: ANN401
        """(N, C) numbers of vertices from which N targets may be reached, C <= count."""
        alive = self.alive
        if not self.embeds or len(alive) <= count:
            return np.tile(alive, (len(observations), 1))
        shown = self.show(observations, prepared)
        return alive[most_alike(likeness(self.index.seen[alive], shown).T, count)]

    def connect(self, source: int, target: int, probability: float, driven: int = 0) -> None:
        """Put an edge between vertices, or make it more probable."""
        old = self.graph.get_edge_data(source, target, {"probability": 0.0, "driven": 0})
        told = max(float(probability), old["probability"])
        self.graph.add_edge(
            source,
            target,
            probability=told,
            weight=float(weight(told)),
            driven=old["driven"] + driven,
        )

    def trail_of(self, vertex: int) -> Trail:
        """The trajectory for which a vertex was made, and the place of the vertex in it."""
        return self.trails[self.trajectory[vertex]], int(self.place[vertex])

    def make_vertices(
        self,
        observations: Observation,
        contexts: NDArray,
        timestamps: NDArray,
        trajectory: NDArray[np.intp],
        place: NDArray[np.intp],
        prepared: Any = None,  # noqa: ANN401
    ) -> Numbers:
        """Make N vertices without an edge, and tell their numbers.

        Args:
            observations: N, of anchors.
            contexts: (N, 2k+1, ...) pictures of each as a target.
            timestamps: (N,) seconds.
            trajectory: (N,) for which each is made.
            place: (N,) along that.
            prepared: the contexts as `Reachability.prepare` made them, where that was done.
        """
        if prepared is None:
            prepared = self.vertices.prepare(contexts)
        numbers = self.vertices.append(observations, contexts, timestamps, prepared)
        self.trajectory = np.append(self.trajectory, trajectory)
        self.place = np.append(self.place, place)
        if self.embeds and len(numbers):
            self.index.append(self.see(observations), self.show(observations, prepared))
        self.graph.add_nodes_from(numbers.tolist())
        return numbers

    def remove(self, vertices: Iterable[int]) -> None:
        """Take vertices off the map; the others keep their numbers."""
        gone = {int(vertex) for vertex in vertices}
        if not gone:
            return
        self.graph.remove_nodes_from(gone)
        for number, trail in enumerate(self.trails):
            self.trails[number] = left = [vertex for vertex in trail if vertex not in gone]
            for place, vertex in enumerate(left):
                if self.trajectory[vertex] == number:
                    self.place[vertex] = place


@dataclass(frozen=True)
class Added:
    """What became of a trajectory.

    Attributes:
        trail: (A,) the vertex that each anchor is now.
        reused: (A,) whether that had been there before.
        outdated: (R,) vertices that were removed, since they look different by now.
        queries: pairs that RE was asked about.
    """

    trail: Numbers
    reused: NDArray[np.bool_]
    outdated: Numbers = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    queries: int = 0
