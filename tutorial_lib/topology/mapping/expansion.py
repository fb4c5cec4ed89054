"""Where no path is left: pruned edges and unused images are tried (LTVN, Graph Maintenance)."""

from collections.abc import Callable, Collection
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.topology.maintenance import Edge, Maintenance
from tutorial_lib.topology.mapping.sampling_map import SampledMap

_LAST = 1e3  # times that a blocked edge counts as long: it is tried last


def expanded(
    sampled: SampledMap,
    upkeep: Maintenance,
    here: int,
    exits: Collection[int],
    avoided: Collection[Edge] = (),
) -> bool:
    """Look for a path from a vertex to one of the exits, over new images or over pruned edges.

    Only what is on the path is kept; the other images stay unused, and none joins what is closed.
    Pruned edges come back only where the map has no path at all, not even over what the robot
    avoids for now; those that were blocked only where no others help.

    Args:
        sampled: the map.
        upkeep: of its graph; what is kept is an event.
        here: where the path begins.
        exits: vertices where it may end.
        avoided: edges that it does not use.

    Returns:
        Whether there is one now.
    """
    if not exits:
        return False
    graph = sampled.graph.copy()
    graph.remove_edges_from(avoided)
    path = _through_new(sampled, upkeep, graph, here, exits) if upkeep.rules.expand else None
    if path is None and _path(sampled.graph, here, exits) is None:
        graph, blocked = sampled.graph.copy(), upkeep.blocked
        for edge, known in upkeep.pruned.items():
            if edge not in avoided:
                price = _LAST if edge in blocked else 1.0
                graph.add_edge(*edge, cost=known["cost"] * price)
        path = _path(graph, here, exits)
    if path is None:
        return False
    _keep(sampled, upkeep, path)
    return True


def _through_new(
    sampled: SampledMap,
    upkeep: Maintenance,
    graph: nx.DiGraph,
    here: int,
    exits: Collection[int],
) -> list[int] | None:
    """The shortest path over the graph's edges and images that were not used so far.

    The paper samples such images until there is a path. Here all are tried at once, which finds the
    shortest; either way only those on the path are kept.
    """
    new = sampled.unused | sampled.redundant
    if not new:
        return None
    sources, targets, costs = sampled.links(sampled.rules.connect * upkeep.rules.loosened)
    count = len(sampled.pool)
    added = np.zeros(count, dtype=bool)
    added[list(new)] = True
    some = added[sources] | added[targets]  # the map knows its own edges
    closed = [source * count + target for source, target in upkeep.closed]
    some &= ~np.isin(sources * count + targets, closed)
    trial = nx.DiGraph()
    trial.add_weighted_edges_from(
        zip(sources[some].tolist(), targets[some].tolist(), costs[some].tolist(), strict=True),
        weight="cost",
    )
    trial.add_edges_from(graph.edges(data=True))
    trial.add_node(here)
    return _path(trial, here, exits)


def shortest_paths(
    graph: nx.DiGraph, here: int, cost: str | Callable[[int, int, dict[str, Any]], float | None]
) -> tuple[dict[int, float], dict[int, list[int]]]:
    """Costs of the shortest paths from a vertex, and the paths, by the vertex at their end."""
    # networkx's stubs do not say yet that both are by vertex where there is no target.
    return nx.single_source_dijkstra(graph, here, weight=cost)  # pyrefly: ignore[bad-return]


def _path(graph: nx.DiGraph, here: int, exits: Collection[int]) -> list[int] | None:
    """The shortest path to any of the exits."""
    metres, paths = shortest_paths(graph, here, "cost")
    reached = [vertex for vertex in exits if vertex in metres]
    return paths[min(reached, key=metres.__getitem__)] if reached else None


def _keep(sampled: SampledMap, upkeep: Maintenance, path: list[int]) -> None:
    """Put the path's vertices and edges into the map for good."""
    for vertex in path:
        if vertex not in sampled.graph:
            upkeep.add_vertex(vertex)
            sampled.unused.discard(vertex)
            sampled.redundant.discard(vertex)
    for source, target in pairwise(path):
        if sampled.graph.has_edge(source, target):
            continue
        if (source, target) in upkeep.pruned:
            upkeep.bring_back((source, target))
        else:
            reverse = not sampled.accepted[source, target]
            upkeep.add_edge((source, target), sampled.attributes(source, target, reverse))
