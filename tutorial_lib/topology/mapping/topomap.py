"""The topological map: anchors as vertices, reachability as edges (Meng 2020, III-E)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.se2 import wrap
from tutorial_lib.topology.mapping.edge_rules import MapSettings, weight
from tutorial_lib.topology.mapping.retrieval import Embedding, Index, likeness, most_alike
from tutorial_lib.topology.mapping.vertices import Indices, Vertices
from tutorial_lib.topology.query import check_seen
from tutorial_lib.validation import (
    alike,
    batch,
    floats,
    instance,
    integers,
    listed,
    number,
    whole,
    with_methods,
)


class TopoMap:
    """A directed graph of contextified anchors; `insertion.add_trajectory` lets it grow.

    Attributes:
        graph: on networkx. An edge has `probability` (RE), `weight` (-log RE) and `driven`: how
            often a trajectory went along it. One on which the robot turns where it stands also has
            `turn`: by how many rad.
        vertices: observation, context and prepared target of each vertex.
        settings: thresholds on RE.
        paths: for each trajectory its vertices, in order.
        trajectory, place: (V,) the trajectory that each vertex was made for, and its place there.
        index: embeddings of the vertices, where `reachability` has `embed`.
    """

    def __init__(self, reachability: Reachability, settings: MapSettings | None = None) -> None:
        """An empty map. Without `reachability.embed`, every vertex is queried."""
        with_methods("reachability", reachability, "prepare", "probability")
        settings = MapSettings() if settings is None else settings
        self.graph = nx.DiGraph()
        self.vertices = Vertices(reachability)
        self.settings = instance("settings", settings, MapSettings)
        self.paths: list[list[int]] = []
        self.trajectory = self.place = np.empty(0, dtype=np.intp)
        self.index = Index()

    def __len__(self) -> int:
        return len(self.graph)

    @property
    def alive(self) -> Indices:
        """(len,) indices of the vertices that were not removed."""
        return np.array(sorted(self.graph), dtype=np.intp)

    @property
    def embeds(self) -> bool:
        """Whether the estimator embeds images."""
        return hasattr(self.vertices.reachability, "embed")

    def see(self, observations: Observation) -> Embedding:
        """(N, R, D) embeddings of N observations."""
        check_seen(observations)
        reachability = self.vertices.reachability
        if not hasattr(reachability, "embed"):
            raise InputError("reachability: embeds no images; give one with the method embed")
        return np.asarray(reachability.embed(observations))

    def show(self, observations: Observation, prepared: Any) -> Embedding:  # noqa: ANN401
        """(N, P, R, D) embeddings of N targets; of their observations, if RE embeds no targets."""
        reachability = self.vertices.reachability
        check_seen(observations)
        if hasattr(reachability, "embed_targets"):
            Vertices.checked(prepared, len(observations))
            return reachability.embed_targets(prepared)
        return self.see(observations)[:, None]

    def nearby(self, observations: Observation, count: int) -> Indices:
        """(N, C) indices of vertices that may be reached from N observations, C <= count."""
        alive = self.alive
        check_seen(observations)
        whole("count", count, least=0)
        if not self.embeds or len(alive) <= count:
            return np.tile(alive, (len(observations), 1))
        seen = self.see(observations)
        return alive[most_alike(likeness(seen, self.index.shown[alive]), count)]

    def around(self, observations: Observation, prepared: Any, count: int) -> Indices:  # noqa: ANN401
        """(N, C) indices of vertices from which N targets may be reached, C <= count."""
        alive = self.alive
        check_seen(observations)
        whole("count", count, least=0)
        if not self.embeds or len(alive) <= count:
            return np.tile(alive, (len(observations), 1))
        shown = self.show(observations, prepared)
        return alive[most_alike(likeness(self.index.seen[alive], shown).T, count)]

    def connect(self, source: int, target: int, probability: float, driven: int = 0) -> None:
        """Add an edge, or raise its probability."""
        self._check_vertex("source", source)
        self._check_vertex("target", target)
        probability = number("probability", probability, least=0.0, most=1.0)
        whole("driven", driven, least=0)
        if self.graph.get_edge_data(source, target, {}).get("turn") is not None:
            self.graph.remove_edge(source, target)  # to drive is better than to turn
        old = self.graph.get_edge_data(source, target, {"probability": 0.0, "driven": 0})
        probability = max(probability, old["probability"])
        self.graph.add_edge(
            source,
            target,
            probability=probability,
            weight=float(weight(probability)),
            driven=old["driven"] + driven,
        )

    def turns_on(self, vertices: Sequence[int]) -> dict[int, float]:
        """The places of a path before which a robot turns in place, and by how many rad."""
        integers("vertices", vertices, ("L",), least=0)
        steps = enumerate(pairwise(vertices), start=1)
        edges = {place: self.graph.get_edge_data(*step, {}) for place, step in steps}
        return {place: edge["turn"] for place, edge in edges.items() if "turn" in edge}

    def connect_by_turn(self, source: int, target: int, probability: float, angle: float) -> bool:
        """Add an edge on which the robot turns by so many rad, unless there is one already."""
        self._check_vertex("source", source)
        self._check_vertex("target", target)
        number("probability", probability, least=0.0, most=1.0)
        number("angle", angle)
        if source == target or self.graph.has_edge(source, target):
            return False
        self.connect(source, target, probability)
        self.graph.edges[source, target]["turn"] = float(wrap(angle))
        return True

    def make_vertices(
        self,
        observations: Observation,
        contexts: NDArray,
        timestamps: NDArray,
        trajectory: NDArray[np.intp],
        place: NDArray[np.intp],
        prepared: Any = None,  # noqa: ANN401
    ) -> Indices:
        """Make N vertices without edges, and return their indices.

        Args:
            observations: N, of anchors.
            contexts: (N, 2k+1, ...) images of each as a target.
            timestamps: (N,) seconds.
            trajectory: (N,) that each is made for.
            place: (N,) on its path.
            prepared: the contexts from `Reachability.prepare`, if they are prepared already.
        """
        check_seen(observations)
        count = len(observations)
        batch("contexts", instance("contexts", contexts, np.ndarray))
        timestamps = floats("timestamps", timestamps, (count,))
        trajectory = integers("trajectory", trajectory, (count,), least=0)
        place = integers("place", place, (count,), least=0)
        alike(observations=observations, contexts=contexts)
        if prepared is None:
            prepared = self.vertices.prepare(contexts)
        else:
            Vertices.checked(prepared, count)
        indices = self.vertices.append(observations, contexts, timestamps, prepared)
        self.trajectory = np.append(self.trajectory, trajectory)
        self.place = np.append(self.place, place)
        if self.embeds and len(indices):
            self.index.append(self.see(observations), self.show(observations, prepared))
        self.graph.add_nodes_from(indices.tolist())
        return indices

    def remove(self, vertices: Iterable[int]) -> None:
        """Remove vertices; the others keep their indices."""
        given = listed("vertices", vertices, "a list of vertices")
        gone = {self._check_vertex("vertices", vertex) for vertex in given}
        if not gone:
            return
        self.graph.remove_nodes_from(gone)
        for trajectory, path in enumerate(self.paths):
            self.paths[trajectory] = left = [vertex for vertex in path if vertex not in gone]
            for place, vertex in enumerate(left):
                if self.trajectory[vertex] == trajectory:
                    self.place[vertex] = place

    def _check_vertex(self, name: str, vertex: int) -> int:
        """The number of a vertex, if there is such a one."""
        if whole(name, vertex, least=0) not in self.graph:
            raise InputError(f"{name}: {vertex}; give a vertex of this map, of {len(self)}")
        return int(vertex)


@dataclass(frozen=True)
class Added:
    """How a trajectory was added to the map.

    Attributes:
        path: (A,) the vertex of each anchor; of an edge that replaces it, the target.
        reused: (A,) whether that vertex had been there before.
        outdated: (R,) vertices that were removed, since they look different by now.
        queries: pairs that RE was queried about.
    """

    path: Indices
    reused: NDArray[np.bool_]
    outdated: Indices = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    queries: int = 0
