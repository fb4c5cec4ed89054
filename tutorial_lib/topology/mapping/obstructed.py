"""Which links of a sampled map lead through what stands in a robot's way (ours).

Where one edge is blocked, so are the others that lead through the same place, and those that the
map could have: else expansion would join the two sides again, by images that are not used yet.
"""

from itertools import chain

import numpy as np

from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.se2 import Array, compose, inverse
from tutorial_lib.topology.maintenance import Edge
from tutorial_lib.topology.mapping.sampling_map import Links, SampledMap

BESIDE = 0.2
"""Metres from an obstacle within which a link leads through it."""
_HOPS = 2  # links from the edge to the images around


def obstructed(
    sampled: SampledMap,
    edge: Edge,
    source: Array,
    obstacles: Array,
    connect: float,
) -> tuple[Edge, ...]:
    """Links that lead through obstacles around an edge.

    Args:
        sampled: the map.
        edge: on which a robot saw the obstacles.
        source: (3,) where the edge begins.
        obstacles: (P, 2) in the same frame.
        connect: D_c, metres, of the links that the map could have.

    Returns:
        The edge, other edges of the map, and pairs of images that such a D_c would join.
    """
    places = _places(sampled, edge, source)
    known = np.zeros(len(sampled.pool), dtype=bool)
    known[list(places)] = True
    sources, targets, _ = sampled.links(connect)
    some = known[sources] & known[targets]
    links = zip(sources[some].tolist(), targets[some].tolist(), strict=True)
    pairs = list(dict.fromkeys(chain(sampled.graph.subgraph(places).edges, links)))
    ends = np.array([[*places[a][:2], *places[b][:2]] for a, b in pairs]).reshape(-1, 4)
    near = distance_to_segments(obstacles, ends).min(axis=0) < BESIDE
    closed = [pair for pair, through in zip(pairs, near, strict=True) if through and pair != edge]
    return (edge, *closed)


def _places(sampled: SampledMap, edge: Edge, source: Array) -> dict[int, Array]:
    """Where the images around an edge are, as predicted from link to link; never by the edge.

    For that may be a mistake of the map.
    """
    places = {edge[0]: source}
    links, newest = sampled.links(sampled.rules.connect), list(places)
    for _ in range(_HOPS):
        found: dict[int, Array] = {}
        for image in newest:
            for other, waypoint in _beside(sampled, image, links):
                if {image, other} != set(edge):
                    found.setdefault(other, compose(places[image], waypoint))
        newest = [image for image in found if image not in places]
        places = found | places
    return places


def _beside(sampled: SampledMap, image: int, links: Links) -> list[tuple[int, Array]]:
    """The images that links join to an image, or a turn, and where they are as seen from it."""
    pool, (sources, targets, _) = sampled.pool, links
    others = np.unique(np.concatenate([targets[sources == image], sources[targets == image]]))
    ahead = sampled.accepted[image, others]
    there = np.where(
        ahead[:, None], pool.waypoints[image, others], inverse(pool.waypoints[others, image])
    )
    found = list(zip(others.tolist(), there, strict=True))
    if image in sampled.graph:
        found += [
            (other, np.array(leads["waypoint"]))
            for _, other, leads in sampled.graph.out_edges(image, data=True)
            if "turn" in leads
        ]
    return found
