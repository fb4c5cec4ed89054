"""People who stand in the way, the paths around them, and maps with a path left."""

from dataclasses import replace

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.geometry import Array, distance_to_segments
from tutorial_lib.world.floorplan import Door
from tutorial_lib.world.people import Person

APART = 0.34
"""Metres between people who stand in a row; no car fits through."""
BODY = 0.12
"""Metres, half the width of a car."""


def paths_around(building: Building, places: Array) -> GridPaths:
    """A building's geodesics where people stand at places (P, 2)."""
    clearance = building.scene.clearance
    cells = np.indices(clearance.clearance.shape).reshape(2, -1).T
    gap = np.linalg.norm(clearance.centres(cells)[:, None] - places, axis=-1).min(axis=1)
    gap = np.maximum(gap - Person.radius, 0.0).reshape(clearance.clearance.shape)
    left = np.minimum(clearance.clearance, gap).astype(np.float32)
    return GridPaths(replace(clearance, clearance=left))


def across_door(door: Door) -> list[Person]:
    """People who close a door."""
    count = max(int(np.ceil(door.width / APART)), 1) + 1
    return [Person(place[None], speed=0.0) for place in np.linspace(door.start, door.end, count)]


def path_left(
    graph: nx.DiGraph,
    poses: Array,
    people: Array,
    begins: NDArray[np.bool_],
    ends: NDArray[np.bool_],
) -> bool:
    """Whether a map has a path that leads through nobody.

    Args:
        graph: of the map.
        poses: (V, 3) at which its vertices were recorded.
        people: (P, 2) where they stand.
        begins: (V,) at which vertices a path may begin.
        ends: (V,) at which it may end.
    """
    edges = np.array(list(graph.edges), dtype=np.intp).reshape(-1, 2)
    segments = np.hstack([poses[edges[:, 0], :2], poses[edges[:, 1], :2]])
    gap = distance_to_segments(people, segments).min(axis=0)
    left = nx.DiGraph(edges[gap > Person.radius + BODY].tolist())
    reached = set[int]()
    for vertex in np.flatnonzero(begins).tolist():
        if vertex in left:
            reached |= nx.descendants(left, vertex) | {vertex}
    return any(ends[vertex] for vertex in reached)
