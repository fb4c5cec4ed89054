"""SPTM, the baseline of Meng 2020 (IV): a dense map of pictures that are alike, without weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.agent import Experience
from tutorial_lib.agents.navigator import MapNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import (
    Controller,
    Localizer,
    Observation,
    Reachability,
    WaypointPredictor,
)
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.sparsify import contextified, every_nth
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import Goals, Plan


@dataclass(frozen=True)
class MostAlike:
    """SPTM's `Localizer`: the robot is where the picture is most like what it sees."""

    def localize(self, observations: Observation, topomap: TopoMap) -> Array:
        """Probabilities (N, V), 1 for one vertex."""
        alive = topomap.alive
        rows = np.repeat(np.arange(len(observations)), len(alive))
        alike = topomap.vertices.into(observations, rows, np.tile(alive, len(observations)))
        alike = alike.reshape(len(observations), -1)
        return (np.arange(len(alive)) == alike.argmax(axis=1)[:, None]).astype(float)


@dataclass
class SPTMAgent:
    """Keeps every n-th picture, joins those that are alike, and takes the shortest way; an `Agent`.

    After Meng 2020 (IV): it is given the best controller and follower there are, which need RE;
    the map itself knows only how alike pictures are.

    Attributes:
        similarity: tells how alike two pictures are (SPTM's retrieval network).
        predictor: C_WP.
        controller: C_RMP.
        reachability: RE, for the follower.
        localizer: says at which vertex the robot or a goal is.
        every: n.
        s_shortcut: similarity from which on two places are joined.
        window: pairs of neighbours on either side, over which similarity is the median.
        follower: when the follower believes what it is told.
        replans: how often a robot that was lost plans anew before it gives up.
        topomap: what was learned; an edge's probability is the similarity.
    """

    similarity: Reachability
    predictor: WaypointPredictor
    controller: Controller
    reachability: Reachability
    localizer: Localizer = field(default_factory=MostAlike)
    every: int = 20
    s_shortcut: float = 0.99
    window: int = 2
    follower: FollowerSettings = field(default_factory=FollowerSettings)
    replans: int = 8

    def __post_init__(self) -> None:
        self.topomap = TopoMap(self.similarity)
        self._alike = np.empty((0, 0), dtype=np.float32)

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Keep pictures of each drive, and join all that are alike."""
        for experience in experiences:
            self._keep(experience)
        self._alike = self._compared()
        self.join(self.s_shortcut)

    def join(self, s_shortcut: float) -> None:
        """Join vertices that are alike; shortcuts that were there before are dropped."""
        self.s_shortcut, graph = s_shortcut, self.topomap.graph
        driven = nx.get_edge_attributes(graph, "driven")
        graph.remove_edges_from([edge for edge, times in driven.items() if not times])
        alike = self._alike
        for source, target in np.argwhere(alike > s_shortcut):
            # Neighbours on a trajectory are joined only as they were driven (dT = 1).
            if abs(source - target) > 1 or not self._on_one(source, target):
                self.topomap.connect(int(source), int(target), alike[source, target])

    def start(self, goals: Sequence[Goals]) -> MapNavigation:
        """Send robots to one goal each."""
        follower = Follower(self.predictor, self.controller, self.reachability, self.follower)
        return MapNavigation(self._find_way, follower, self.topomap, goals, self.replans)

    def _keep(self, experience: Experience) -> None:
        seen, topomap = experience.observations, self.topomap
        view, k = self.predictor.view, self.predictor.architecture.k
        contexts = contextified(view.of(seen), k)
        kept = every_nth(len(seen), self.every)
        trail = topomap.make_vertices(
            seen[kept],
            contexts[kept],
            experience.timestamps[kept],
            np.full(len(kept), len(topomap.trails)),
            np.arange(len(kept)),
            self.similarity.prepare(contexts[kept, k : k + 1]),
        )
        topomap.trails.append(trail.tolist())
        told = topomap.vertices.between(trail[:-1], trail[1:])
        for source, target, similarity in zip(trail[:-1], trail[1:], told, strict=True):
            topomap.connect(int(source), int(target), similarity, driven=1)

    def _compared(self) -> NDArray[np.float32]:
        """(V, V) the median similarity of each pair and its neighbours on their trajectories."""
        count = len(self.topomap)
        alike = np.empty((count, count), dtype=np.float32)
        for source in range(count):
            alike[source] = self.topomap.vertices.between(np.full(count, source), np.arange(count))
        return window_median(alike, self.topomap.trajectory, self.window)

    def _on_one(self, source: int, target: int) -> bool:
        return self.topomap.trajectory[source] == self.topomap.trajectory[target]

    def _find_way(self, observation: Observation, goals: Goals, excluded: set[int]) -> Plan:
        """The way over the fewest edges, between the places that are most alike."""
        graph, alive = self.topomap.graph, self.topomap.alive
        if not len(alive):
            return Plan(refusal="the map is empty")
        here = int(alive[self.localizer.localize(observation, self.topomap)[0].argmax()])
        there = alive[self.localizer.localize(goals.observations, self.topomap).argmax(axis=1)]
        graph = nx.restricted_view(graph, excluded - {here, *there.tolist()}, [])
        reached = nx.single_source_shortest_path(graph, here)
        ways = {goal: reached[int(v)] for goal, v in enumerate(there) if int(v) in reached}
        if not ways:
            return Plan(refusal="no way leads from the place that is most alike to the goal's")
        goal = min(ways, key=lambda number: len(ways[number]))
        # Similarities are no probabilities; nothing is claimed of the way.
        return Plan(tuple(ways[goal]), goal)


def window_median(alike: Array, trajectory: NDArray[np.intp], window: int) -> NDArray[np.float32]:
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
