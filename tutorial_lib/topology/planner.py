"""The most probable path over a map, or a refusal (Meng 2020, III-F)."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import HERE, Edges, Goals, Localizer, Observation, Plan
from tutorial_lib.topology.mapping.edge_rules import weight
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.validation import floats, instance, listed, number, whole, with_methods

_HERE, _GOAL = "here", "goal"
Edge = tuple[Any, Any, float]
"""Source, target and probability."""


@dataclass(frozen=True)
class DijkstraPlanner:
    """Dijkstra on -log RE, with edges from here and to the goal.

    Attributes:
        least: probability of the path below which it is refused.
        p_query: RE from here, or to the goal, above which there is an edge.
        p_goal: RE from some vertex to the goal above which the goal counts as on the map. It is
            higher, since it is the maximum over hundreds of vertices, some of which look a little
            like anything.
        candidates: vertices that RE is queried about at either end, those most alike.
        localizer: localizes the robot, in place of RE; none unless given.
    """

    least: float = 0.2
    p_query: float = 0.5
    p_goal: float = 0.95
    candidates: int = 64
    localizer: Localizer | None = None

    def __post_init__(self) -> None:
        for name in ("least", "p_query", "p_goal"):
            number(name, getattr(self, name), least=0.0, most=1.0)
        whole("candidates", self.candidates, least=1)
        if self.localizer is not None:
            with_methods("localizer", self.localizer, "localize")

    def plan(
        self,
        observation: Observation,
        goals: Goals,
        topomap: TopoMap,
        excluded: Collection[tuple[int, int]] = (),
    ) -> Plan:
        """Plan from one observation to the goal that is reached most probably.

        A refused plan holds the best path all the same, with its probability.

        Args:
            observation: of one robot.
            goals: any of which will do.
            topomap: the map.
            excluded: edges that could not be passed a while ago, from `HERE` too; no path leads
                over them.

        Raises:
            InputError: when there is not one observation, or a probability is none.
        """
        if len(instance("observation", observation, Observation)) != 1:
            raise InputError(f"plan: {len(observation)} observations; give one observation")
        instance("goals", goals, Goals)
        instance("topomap", topomap, TopoMap)
        given = excluded_edges(excluded)
        graph = topomap.graph.copy()
        graph.remove_edges_from(given)
        here, reach = self._from_here(topomap, observation)
        starts = [(_HERE, int(v), p) for v, p in zip(here, reach, strict=True)]
        _add(graph, [edge for edge in starts if (HERE, edge[1]) not in given], self.p_query)
        finishes = self._finishes(topomap, observation, goals)
        _add(graph, finishes, self.p_goal)
        found = _most_probable(graph)
        if found is not None:
            sure = found.probability >= self.least
            words = f"the best path has probability {found.probability:.3f}, below {self.least}"
            return found if sure else replace(found, refusal=words)
        _add(graph, finishes, self.p_query)
        found = _most_probable(graph)
        if found is None:
            return Plan(refusal="no path leads from what is seen here to the goal")
        words = f"the goal is reached with {found.probabilities[-1]:.3f} at best"
        return replace(found, refusal=f"{words}, not above {self.p_goal}; it may not be on the map")

    def _finishes(self, topomap: TopoMap, observation: Observation, goals: Goals) -> list[Edge]:
        """Edges to every goal, from vertices and from here."""
        prepared = topomap.vertices.prepare(goals.contexts)
        count = np.arange(len(goals))
        reach = topomap.vertices.query(observation, np.zeros_like(count), prepared, count)
        direct = [(_HERE, (_GOAL, int(g)), p) for g, p in zip(count, reach, strict=True)]
        if not len(topomap):
            return direct
        there = topomap.around(goals.observations, prepared, self.candidates)
        rows, there = np.repeat(np.arange(len(there)), there.shape[1]), there.ravel()
        reach = topomap.vertices.onward(there, prepared, rows)
        ends = zip(there, rows, reach, strict=True)
        return [*direct, *((int(v), (_GOAL, int(g)), p) for v, g, p in ends)]

    def _from_here(self, topomap: TopoMap, observation: Observation) -> tuple[Indices, Array]:
        """Vertices (C,) that may be reached from here, and RE of each."""
        if not len(topomap):
            return np.empty(0, dtype=np.intp), np.empty(0)
        if self.localizer is not None:
            belief = floats(
                "localizer's probabilities",
                self.localizer.localize(observation, topomap),
                (1, len(topomap)),
                least=0.0,
                most=1 + 1e-9,
            )
            return topomap.alive, belief[0]
        near = topomap.nearby(observation, self.candidates)[0]
        return near, topomap.vertices.into(observation, np.zeros_like(near), near)


def checked_plan(plan: Plan, topomap: TopoMap, goals: Goals, excluded: Edges) -> Plan:
    """A planner's plan, if it leads over vertices of the map to one of the goal's images.

    Between them it may take edges that the map does not have, but none that are `excluded`.

    Raises:
        InputError: when it does not, or is no plan.
    """
    vertices = instance("planner", plan, Plan).vertices
    if plan.goal >= len(goals):
        raise InputError(f"plan: leads to goal image {plan.goal}, but there are {len(goals)}")
    for vertex in vertices:
        if vertex not in topomap.graph:
            raise InputError(f"plan: leads over {vertex}, which is no vertex of the map")
    for edge in pairwise((HERE, *vertices)):
        if edge in excluded:
            raise InputError(
                f"plan: takes edge {edge}, which is excluded ({HERE} is where the robot is); plan "
                "around such edges"
            )
    return plan


def excluded_edges(excluded: Collection[tuple[int, int]]) -> frozenset[tuple[int, int]]:
    """The edges that a plan must not use, or an `InputError`."""
    given = listed("excluded", excluded, "edges, tuples of two vertices each")
    if not all(isinstance(edge, tuple) and len(edge) == 2 for edge in given):
        raise InputError("excluded: give edges, tuples of two vertices each")
    return frozenset(given)


def _add(graph: nx.DiGraph, edges: list[Edge], least: float) -> None:
    """Add edges above a probability."""
    graph.add_nodes_from([_HERE, _GOAL])
    for source, target, probability in edges:
        if probability > least:
            edge = {"probability": float(probability), "weight": float(weight(probability))}
            graph.add_edge(source, target, **edge)
            if isinstance(target, tuple):
                graph.add_edge(target, _GOAL, weight=0.0)


def _most_probable(graph: nx.DiGraph) -> Plan | None:
    """The most probable path from here to a goal, if there is one."""
    try:
        path = nx.dijkstra_path(graph, _HERE, _GOAL)
    except nx.NetworkXNoPath:
        return None
    steps = tuple(graph.edges[step]["probability"] for step in pairwise(path[:-1]))
    return Plan(tuple(path[1:-2]), path[-2][1], steps)
