"""SPTM, the baseline of Meng 2020 (IV): a dense, unweighted map of images that are alike."""

from collections.abc import Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.navigator import MapAgent
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import (
    HERE,
    Edges,
    Experience,
    Goals,
    Observation,
    Plan,
    Reachability,
)
from tutorial_lib.topology.mapping.sparsify import contextified, every_nth
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import excluded_edges
from tutorial_lib.validation import instance, instances, number, whole, with_methods


@dataclass(kw_only=True)
class SPTMAgent(MapAgent):
    """Keeps every n-th image, joins those that are alike, and takes the shortest path.

    After Meng 2020 (IV): it gets the best controller and follower there are, which need RE; the map
    itself knows only how similar images are. See `MapAgent` for the other parts.

    Attributes:
        similarity: predicts how similar two images are (SPTM's retrieval network).
        every: n.
        s_shortcut: similarity above which two places are joined.
        window: pairs of neighbours on either side, over which similarity is the median.
        topomap: what was learned; an edge's probability is the similarity.
    """

    similarity: Reachability
    every: int = 20
    s_shortcut: float = 0.99
    window: int = 2

    def __post_init__(self) -> None:
        with_methods("similarity", self.similarity, "prepare", "probability")
        whole("every", self.every, least=1)
        number("s_shortcut", self.s_shortcut, least=0.0, most=1.0)
        whole("window", self.window, least=0)
        super().__post_init__()
        self._similarities = np.empty((0, 0), dtype=np.float32)

    def empty_map(self) -> TopoMap:
        """A map whose edges are similarities."""
        return TopoMap(self.similarity)

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Keep images of each trajectory, and join all that are alike.

        Raises:
            InputError: when one is no `Experience`, before any is learned.
        """
        for experience in instances("experiences", experiences, Experience):
            self._keep(experience)
        self._similarities = self._compared()
        self.join(self.s_shortcut)

    def join(self, s_shortcut: float) -> None:
        """Join vertices that are alike; shortcuts that were there before are dropped."""
        self.s_shortcut = number("s_shortcut", s_shortcut, least=0.0, most=1.0)
        graph = self.topomap.graph
        driven = nx.get_edge_attributes(graph, "driven")
        graph.remove_edges_from([edge for edge, times in driven.items() if not times])
        alike, trajectory = self._similarities, self.topomap.trajectory
        for source, target in np.argwhere(alike > s_shortcut):
            # Neighbours on a trajectory are joined only as they were driven (dT = 1).
            if abs(source - target) > 1 or trajectory[source] != trajectory[target]:
                self.topomap.connect(int(source), int(target), alike[source, target])

    def _keep(self, experience: Experience) -> None:
        seen, topomap = experience.observations, self.topomap
        view, k = self.predictor.view, self.predictor.k
        contexts = contextified(view.of(seen), k)
        kept = every_nth(len(seen), self.every)
        path = topomap.make_vertices(
            seen[kept],
            contexts[kept],
            experience.timestamps[kept],
            np.full(len(kept), len(topomap.paths)),
            np.arange(len(kept)),
            self.similarity.prepare(contexts[kept, k : k + 1]),
        )
        topomap.paths.append(path.tolist())
        similarities = topomap.vertices.between(path[:-1], path[1:])
        for source, target, similarity in zip(path[:-1], path[1:], similarities, strict=True):
            topomap.connect(int(source), int(target), similarity, driven=1)

    def _compared(self) -> NDArray[np.float32]:
        """(V, V) the median similarity of each pair and its neighbours on their trajectories."""
        count = len(self.topomap)
        alike = np.empty((count, count), dtype=np.float32)
        for source in range(count):
            alike[source] = self.topomap.vertices.between(np.full(count, source), np.arange(count))
        return window_median(alike, self.topomap.trajectory, self.window)

    def find_path(self, observation: Observation, goals: Goals, excluded: Edges) -> Plan:
        """The path over the fewest edges, between the places that are most alike.

        It begins at no vertex to which the first step is excluded.
        """
        instance("observation", observation, Observation)
        instance("goals", goals, Goals)
        given = excluded_edges(excluded)
        graph, alive = self.topomap.graph, self.topomap.alive
        if not len(alive):
            return Plan(refusal="the map is empty")
        allowed = [(HERE, int(vertex)) not in given for vertex in alive]
        if not any(allowed):
            return Plan(refusal="every first step is excluded")
        alike = np.where(allowed, similarities(observation, self.topomap)[0], -1.0)
        here = int(alive[alike.argmax()])
        there = alive[similarities(goals.observations, self.topomap).argmax(axis=1)]
        graph = nx.restricted_view(graph, [], given)
        reached = nx.single_source_shortest_path(graph, here)
        paths = {goal: reached[int(v)] for goal, v in enumerate(there) if int(v) in reached}
        if not paths:
            return Plan(refusal="no path leads from the place that is most alike to the goal's")
        goal = min(paths, key=lambda index: len(paths[index]))
        # Similarities are no probabilities: the plan claims none.
        return Plan(tuple(paths[goal]), goal)


def similarities(observations: Observation, topomap: TopoMap) -> Array:
    """(N, V) how similar N observations are to the vertices that are alive."""
    alive = topomap.alive
    rows = np.repeat(np.arange(len(observations)), len(alive))
    alike = topomap.vertices.into(observations, rows, np.tile(alive, len(observations)))
    return alike.reshape(len(observations), -1)


def window_median(
    alike: NDArray[np.floating], trajectory: NDArray[np.intp], window: int
) -> NDArray[np.float32]:
    """The median over aligned neighbours of each pair (SPTM).

    Args:
        alike: (V, V) similarities.
        trajectory: (V,) of each vertex; those of one lie next to each other, in order.
        window: neighbours on either side; beyond the end of a trajectory there are none.

    >>> window_median(np.eye(3), np.zeros(3, dtype=int), 1).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    if window < 0:
        raise InputError(f"window: {window}; give a whole number, 0 or greater")
    count = len(alike)
    stacked = np.full((2 * window + 1, count, count), np.nan, dtype=np.float32)
    for layer, step in enumerate(range(-window, window + 1)):
        rows = np.arange(max(0, -step), min(count, count - step))
        same = trajectory[rows] == trajectory[rows + step]
        rows = rows[same]
        stacked[layer][np.ix_(rows, rows)] = alike[np.ix_(rows + step, rows + step)]
    return np.nanmedian(stacked, axis=0)
