"""Which links of a sampled map lead through what stands in a robot's way (ours).

Where one edge is blocked, so are all others that lead through the same place, and those that the
map could have: else expansion would join the two sides again, by images that are not used yet.
"""

from __future__ import annotations

from itertools import chain

import numpy as np

from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.se2 import Array, compose, inverse
from tutorial_lib.topology.maintenance import Edge
from tutorial_lib.topology.mapping.sampling_map import SampledMap

BESIDE = 0.2
"""Metres from an obstacle within which a link leads through it."""
_HOPS = 2  # links from the edge's ends to the images around


def obstructed(
    sampled: SampledMap, edge: Edge, target: Array, obstacles: Array, connect: float
) -> tuple[Edge, ...]:
    """Links that lead through obstacles around an edge.

    Args:
        sampled: the map.
        edge: of it, on which a robot saw the obstacles.
        target: (3,) where the edge ends.
        obstacles: (P, 2) in the same frame.
        connect: D_c, metres, of the links that the map could have.

    Returns:
        Edges of the map, and pairs of images that such a D_c would join.
    """
    places = _places(sampled, edge, target)
    known = np.zeros(len(sampled.pool), dtype=bool)
    known[list(places)] = True
    sources, targets, _ = sampled.links(connect)
    some = known[sources] & known[targets]
    links = zip(sources[some].tolist(), targets[some].tolist(), strict=True)
    pairs = list(dict.fromkeys(chain(sampled.graph.subgraph(places).edges, links)))
    ends = np.array([[*places[a][:2], *places[b][:2]] for a, b in pairs])
    near = distance_to_segments(obstacles, ends).min(axis=0) < BESIDE
    return tuple(pair for pair, closed in zip(pairs, near, strict=True) if closed)


def _places(sampled: SampledMap, edge: Edge, target: Array) -> dict[int, Array]:
    """Where the images around an edge are, as predicted from link to link."""
    graph, pool, connect = sampled.graph, sampled.pool, sampled.rules.connect
    sources, targets, _ = sampled.links(connect)
    known = np.array(graph.edges[edge]["waypoint"])
    places = {edge[1]: target, edge[0]: compose(target, inverse(known))}
    newest = list(places)
    for _ in range(_HOPS):
        found: dict[int, Array] = {}
        for image in newest:
            if image in graph:
                for _, other, leads in graph.out_edges(image, data=True):
                    found.setdefault(other, compose(places[image], np.array(leads["waypoint"])))
            first, last = np.searchsorted(sources, (image, image + 1))
            for other in targets[first:last].tolist():
                waypoint = (
                    pool.waypoints[image, other]
                    if sampled.accepted[image, other]
                    else inverse(pool.waypoints[other, image])
                )
                found.setdefault(other, compose(places[image], waypoint))
        newest = [image for image in found if image not in places]
        places = found | places
    return places
