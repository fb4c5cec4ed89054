"""Where no path is left: pruned edges and unused images are tried (LTVN, Graph Maintenance)."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise

import networkx as nx
import numpy as np

from tutorial_lib.topology.maintenance import Edge, Maintenance
from tutorial_lib.topology.mapping.sampling_map import SampledMap

TRIED = 400
"""Unused images that are tried at most."""


def expanded(
    sampled: SampledMap,
    upkeep: Maintenance,
    here: int,
    exits: Collection[int],
    avoided: Collection[Edge] = (),
) -> bool:
    """Look for a path from a vertex to one of the exits, first over pruned edges, then new images.

    Only what is on the path is kept; the other images stay unused.

    Args:
        sampled: the map.
        upkeep: of its graph; what is kept is an event.
        here: where the path begins.
        exits: vertices where it may end.
        avoided: edges that it does not use.

    Returns:
        Whether there is one now.
    """
    graph = sampled.graph.copy()
    graph.remove_edges_from(avoided)
    graph.add_edges_from(edge for edge in upkeep.pruned if edge not in avoided)
    path = _path(graph, here, exits)
    if path is None and upkeep.rules.expand:
        path = _through_new(sampled, upkeep, graph, here, exits)
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
    """A path over images that were not used so far, which are sampled until there is one."""
    rng = np.random.default_rng([upkeep.query, here])
    connect = sampled.rules.connect * upkeep.rules.loosened
    for image in rng.permutation(sorted(sampled.unused))[:TRIED].tolist():
        edges = sampled.edges_with(image, np.array(sorted(graph)), connect)
        if not edges:
            continue
        graph.add_edges_from(edges)
        if sampled.rules.reverse is not None:
            graph.add_edges_from((target, source) for source, target in edges)
        if (path := _path(graph, here, exits)) is not None:
            return path
    return None


def _path(graph: nx.DiGraph, here: int, exits: Collection[int]) -> list[int] | None:
    """Any path over the fewest edges."""
    reached = nx.single_source_shortest_path(graph, here)
    paths = [reached[vertex] for vertex in exits if vertex in reached]
    return min(paths, key=len) if paths else None


def _keep(sampled: SampledMap, upkeep: Maintenance, path: list[int]) -> None:
    """Put the path's vertices and edges into the map for good."""
    for vertex in path:
        if vertex not in sampled.graph:
            upkeep.add_vertex(vertex)
            sampled.unused.discard(vertex)
    for source, target in pairwise(path):
        if sampled.graph.has_edge(source, target):
            continue
        if (source, target) in upkeep.pruned:
            upkeep.bring_back((source, target))
        else:
            reverse = not sampled.accepted[source, target]
            upkeep.add_edge((source, target), sampled.attributes(source, target, reverse))
