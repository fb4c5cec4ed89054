"""The most probable way over a map, or a refusal (Meng 2020, III-F)."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Localizer, Observation
from tutorial_lib.topology.linking import weight
from tutorial_lib.topology.topomap import TopoMap
from tutorial_lib.topology.vertices import Numbers

_HERE, _GOAL = "here", "goal"


@dataclass(frozen=True, eq=False)
class Goals:
    """Pictures of where a robot may go; one of them is enough.

    Attributes:
        observations: (G,) what is sensed there.
        contexts: (G, 2k+1, ...) pictures of each in its context.

    Raises:
        InputError: when there is none, or not as many of both.
    """

    observations: Observation
    contexts: NDArray

    def __post_init__(self) -> None:
        if not len(self.contexts) or len(self.contexts) != len(self.observations):
            raise InputError(
                f"goals: {len(self.observations)} observations, {len(self.contexts)} contexts; "
                "give as many of both, one at least"
            )

    def __len__(self) -> int:
        return len(self.contexts)


@dataclass(frozen=True)
class Plan:
    """A way from what is seen now to a goal.

    Attributes:
        vertices: of the map, in order; none where the goal itself can be reached from here.
        goal: number of the goal picture that it leads to.
        probabilities: RE of every step, the first from here and the last to the goal.
        refusal: why the robot should not set out; empty if it should.
    """

    vertices: tuple[int, ...] = ()
    goal: int = 0
    probabilities: tuple[float, ...] = ()
    refusal: str = ""

    @property
    def probability(self) -> float:
        """That all steps come true, were they independent; 0 where there is no way."""
        return float(np.prod(self.probabilities)) if self.probabilities else 0.0


@dataclass(frozen=True)
class DijkstraPlanner:
    """Dijkstra on -log RE, with edges from here and to the goal.

    Attributes:
        least: probability of the way below which it is refused.
        p_query: RE from here, or to the goal, from which on there is an edge.
        candidates: vertices that RE is asked about at either end, those most alike.
        localizer: tells where the robot may be, in place of RE; none unless given.
    """

    least: float = 0.1
    p_query: float = 0.5
    candidates: int = 100
    localizer: Localizer | None = None

    def plan(
        self,
        observation: Observation,
        goals: Goals,
        topomap: TopoMap,
        shunned: Collection[int] = (),
    ) -> Plan:
        """Plan from one observation to the goal that is reached most probably.

        Args:
            observation: of one robot.
            goals: where it may go.
            topomap: the map.
            shunned: vertices that could not be reached a while ago; no way leads over them.

        Raises:
            InputError: when there is not one observation, or a probability is none.
        """
        if len(observation) != 1:
            raise InputError(f"plan: {len(observation)} observations; give one")
        graph = self._with_ends(topomap, observation, goals, shunned)
        try:
            way = nx.dijkstra_path(graph, _HERE, _GOAL)
        except nx.NetworkXNoPath:
            return Plan(refusal="no way leads from what is seen here to the goal")
        told = tuple(graph.edges[step]["probability"] for step in pairwise(way[:-1]))
        found = Plan(tuple(way[1:-2]), way[-2][1], told)
        if found.probability < self.least:
            words = f"the best way has probability {found.probability:.3f}, below {self.least}"
            return replace(found, refusal=words)
        return found

    def _with_ends(
        self,
        topomap: TopoMap,
        observation: Observation,
        goals: Goals,
        shunned: Collection[int],
    ) -> nx.DiGraph:
        """The graph with where the robot is and every goal, without what is shunned."""
        prepared = topomap.vertices.reachability.prepare(goals.contexts)
        count = np.arange(len(goals))
        direct = topomap.vertices.ask(observation, np.zeros_like(count), prepared, count)
        edges = [(_HERE, (_GOAL, int(g)), p) for g, p in zip(count, direct, strict=True)]
        here, told = self._from_here(topomap, observation)
        edges += [(_HERE, int(v), p) for v, p in zip(here, told, strict=True)]
        there, goal, told = self._to_goals(topomap, goals, prepared)
        edges += [(int(v), (_GOAL, int(g)), p) for v, g, p in zip(there, goal, told, strict=True)]
        graph = topomap.graph.copy()
        graph.add_nodes_from([_HERE, _GOAL])
        for source, target, probability in edges:
            if probability > self.p_query:
                told_so = {"probability": float(probability), "weight": float(weight(probability))}
                graph.add_edge(source, target, **told_so)
        graph.add_edges_from(((_GOAL, int(g)), _GOAL, {"weight": 0.0}) for g in count)
        graph.remove_nodes_from(shunned)
        return graph

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

    def _to_goals(
        self,
        topomap: TopoMap,
        goals: Goals,
        prepared: object,
    ) -> tuple[Numbers, Numbers, Array]:
        """Vertices (C,) from which goals (C,) may be reached, and how probably."""
        if not len(topomap):
            return np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp), np.empty(0)
        there = topomap.around(goals.observations, prepared, self.candidates)
        goal = np.repeat(np.arange(len(there)), there.shape[1])
        return there.ravel(), goal, topomap.vertices.onward(there.ravel(), prepared, goal)
