"""The most probable way over a map, or a refusal (Meng 2020, III-F)."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Goals, Localizer, Observation, Plan
from tutorial_lib.topology.mapping.edge_rules import weight
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.vertices import Numbers

_HERE, _GOAL = "here", "goal"
Edge = tuple[Any, Any, float]
"""From where to where, and how probably."""


@dataclass(frozen=True)
class DijkstraPlanner:
    """Dijkstra on -log RE, with edges from here and to the goal.

    Attributes:
        least: probability of the way below which it is refused.
        p_query: RE from here, or to the goal, from which on there is an edge.
        p_goal: RE from somewhere on the map to the goal that it takes to set out. It is higher, for
            of hundreds of vertices the most hopeful one is asked: some look a little like anything.
        candidates: vertices that RE is asked about at either end, those most alike.
        localizer: tells where the robot may be, in place of RE; none unless given.
    """

    least: float = 0.2
    p_query: float = 0.5
    p_goal: float = 0.985
    candidates: int = 64
    localizer: Localizer | None = None

    def plan(
        self,
        observation: Observation,
        goals: Goals,
        topomap: TopoMap,
        excluded: Collection[int] = (),
    ) -> Plan:
        """Plan from one observation to the goal that is reached most probably.

        A plan that is refused tells the best way all the same, and its probability.

        Args:
            observation: of one robot.
            goals: where it may go.
            topomap: the map.
            excluded: vertices that could not be reached a while ago; no way leads over them.

        Raises:
            InputError: when there is not one observation, or a probability is none.
        """
        if len(observation) != 1:
            raise InputError(f"plan: {len(observation)} observations; give one")
        graph = topomap.graph.copy()
        graph.remove_nodes_from(excluded)
        here, told = self._from_here(topomap, observation)
        starts = [(_HERE, int(v), p) for v, p in zip(here, told, strict=True) if int(v) in graph]
        _add(graph, starts, self.p_query)
        finishes = self._finishes(topomap, observation, goals)
        finishes = [edge for edge in finishes if edge[0] in graph]
        _add(graph, finishes, self.p_goal)
        found = _most_probable(graph)
        if found is not None:
            sure = found.probability >= self.least
            words = f"the best way has probability {found.probability:.3f}, below {self.least}"
            return found if sure else replace(found, refusal=words)
        _add(graph, finishes, self.p_query)
        found = _most_probable(graph)
        if found is None:
            return Plan(refusal="no way leads from what is seen here to the goal")
        words = f"the goal's place is reached with {found.probabilities[-1]:.3f} at best"
        return replace(found, refusal=f"{words}, not above {self.p_goal}; it may not be on the map")

    def _finishes(self, topomap: TopoMap, observation: Observation, goals: Goals) -> list[Edge]:
        """Edges to every goal, from vertices and from here."""
        prepared = topomap.vertices.prepare(goals.contexts)
        count = np.arange(len(goals))
        told = topomap.vertices.ask(observation, np.zeros_like(count), prepared, count)
        direct = [(_HERE, (_GOAL, int(g)), p) for g, p in zip(count, told, strict=True)]
        if not len(topomap):
            return direct
        there = topomap.around(goals.observations, prepared, self.candidates)
        rows, there = np.repeat(np.arange(len(there)), there.shape[1]), there.ravel()
        told = topomap.vertices.onward(there, prepared, rows)
        ends = zip(there, rows, told, strict=True)
        return [*direct, *((int(v), (_GOAL, int(g)), p) for v, g, p in ends)]

    def _from_here(self, topomap: TopoMap, observation: Observation) -> tuple[Numbers, Array]:
        """Vertices (C,) that may be reached from here, and how probably."""
        if not len(topomap):
            return np.empty(0, dtype=np.intp), np.empty(0)
        if self.localizer is not None:
            told = np.asarray(self.localizer.localize(observation, topomap), dtype=float)
            if told.shape != (1, len(topomap)) or not ((told >= 0) & (told <= 1 + 1e-9)).all():
                raise InputError(
                    f"localizer: told {told.shape}; give probabilities (1, {len(topomap)}), one "
                    "for each vertex"
                )
            return topomap.alive, told[0]
        near = topomap.nearby(observation, self.candidates)[0]
        return near, topomap.vertices.into(observation, np.zeros_like(near), near)


def _add(graph: nx.DiGraph, edges: list[Edge], least: float) -> None:
    """Add edges of more than that probability."""
    graph.add_nodes_from([_HERE, _GOAL])
    for source, target, probability in edges:
        if probability > least:
            told = {"probability": float(probability), "weight": float(weight(probability))}
            graph.add_edge(source, target, **told)
            if isinstance(target, tuple):
                graph.add_edge(target, _GOAL, weight=0.0)


def _most_probable(graph: nx.DiGraph) -> Plan | None:
    """The most probable way from here to a goal, if there is one."""
    try:
        way = nx.dijkstra_path(graph, _HERE, _GOAL)
    except nx.NetworkXNoPath:
        return None
    told = tuple(graph.edges[step]["probability"] for step in pairwise(way[:-1]))
    return Plan(tuple(way[1:-2]), way[-2][1], told)
