"""About where a robot is after it was lost: around the vertex of its path that it visited last."""

from __future__ import annotations

import networkx as nx
import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import HERE, Edges
from tutorial_lib.topology.mapping.topomap import TopoMap

_MOVED = 5.0  # metres from there after which it may be anywhere
_STEPS = 4  # edges from there, either way


class Whereabouts:
    """The vertices that each of N robots visited last; it forgets them when it has moved on."""

    def __init__(self, robots: int, topomap: TopoMap) -> None:
        """Begin with robots that may be anywhere."""
        self._topomap = topomap
        self._seen: list[tuple[int, Array] | None] = [None] * robots

    def see(self, robot: int, vertex: int, odometry: Array) -> None:
        """A robot with `odometry` (3,) visited a vertex last."""
        self._seen[robot] = vertex, odometry[:2].copy()

    def excluded(self, robot: int, odometry: Array) -> Edges:
        """The first steps by which no plan begins for a robot with `odometry` (3,) now."""
        seen = self._seen[robot]
        if seen is None or np.linalg.norm(odometry[:2] - seen[1]) > _MOVED:
            return set()
        both_ways = self._topomap.graph.to_undirected(as_view=True)
        around = nx.single_source_shortest_path_length(both_ways, seen[0], cutoff=_STEPS)
        return {(HERE, int(vertex)) for vertex in self._topomap.alive if vertex not in around}
