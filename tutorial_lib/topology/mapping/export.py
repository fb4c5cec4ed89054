"""Maps for other programs: GraphML for those that draw graphs, GeoJSON for Nav2's route server."""

import io
import json
from pathlib import Path
from typing import Any

import networkx as nx
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.files import write_files, write_text
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import floats, instance, path_of

_LEAST_COST = 1e-6
"""Of an edge with RE = 1: the route server refuses a cost of 0."""


def export_graphml(path: str | Path, topomap: TopoMap, poses: ArrayLike | None = None) -> None:
    """Write the graph as GraphML, for programs that draw or analyse graphs.

    Args:
        path: of the file.
        topomap: the map.
        poses: (V, 3) where its vertices were recorded, those removed since included; written as
            `x`, `y` and `heading` of each vertex where given.

    Raises:
        InputError: when there are not as many finite poses.
    """
    path, topomap = path_of("path", path), instance("topomap", topomap, TopoMap)
    places = None if poses is None else _poses(topomap, poses)
    graph = nx.DiGraph()
    for vertex in sorted(topomap.graph):
        where = {} if places is None else _place(places[vertex])
        graph.add_node(vertex, **_origin(topomap, vertex), **where)
    graph.add_edges_from(topomap.graph.edges(data=True))
    buffer = io.BytesIO()
    nx.write_graphml(graph, buffer)
    write_files({path: buffer.getvalue()})


def export_geojson(
    path: str | Path, topomap: TopoMap, poses: ArrayLike, frame: str = "map"
) -> None:
    """Write the graph as the GeoJSON that the route server of Nav2 loads.

    A vertex is a Point; an edge is a line in one direction, whose fixed cost is -log RE, so that
    the server's cheapest route is the most probable path. Identifiers are unique: those of edges
    begin after those of vertices. `metadata` holds a vertex's heading in rad, trajectory, place and
    time, and an edge's probability, how often it was driven, and by how many rad the robot turns
    where it only turns.

    Args:
        path: of the file.
        topomap: the map.
        poses: (V, 3) where its vertices were recorded, those removed since included; metres in
            `frame`.
        frame: of the coordinates, a name of ROS.

    Raises:
        InputError: when there are not as many finite poses, or no edge, which the server refuses.
    """
    path, topomap = path_of("path", path), instance("topomap", topomap, TopoMap)
    places = _poses(topomap, poses)
    if not isinstance(frame, str):
        raise InputError(f"frame: {frame!r}; give a name of ROS, as map")
    if not topomap.graph.number_of_edges():
        raise InputError(f"{path}: a map without an edge; add trajectories before exporting it")
    features = [_node(topomap, vertex, places[vertex], frame) for vertex in topomap.alive.tolist()]
    edges = topomap.graph.edges(data=True)
    for number, (source, target, edge) in enumerate(edges, start=len(places)):
        features.append(_edge(number, source, target, edge, places))
    write_text(path, json.dumps({"type": "FeatureCollection", "features": features}, indent=1))


def _poses(topomap: TopoMap, poses: ArrayLike) -> Array:
    return floats("poses", poses, (len(topomap.vertices), 3))


def _origin(topomap: TopoMap, vertex: int) -> dict[str, Any]:
    """Which drive made a vertex, where on it, and when."""
    return {
        "trajectory": int(topomap.trajectory[vertex]),
        "place": int(topomap.place[vertex]),
        "timestamp": float(topomap.vertices.timestamps[vertex]),
    }


def _place(pose: Array) -> dict[str, float]:
    return dict(zip(("x", "y", "heading"), pose.tolist(), strict=True))


def _node(topomap: TopoMap, vertex: int, pose: Array, frame: str) -> dict[str, Any]:
    metadata = {**_origin(topomap, vertex), "heading": float(pose[2])}
    return {
        "type": "Feature",
        "properties": {"id": vertex, "frame": frame, "metadata": metadata},
        "geometry": {"type": "Point", "coordinates": pose[:2].tolist()},
    }


def _edge(
    number: int, source: int, target: int, edge: dict[str, Any], places: Array
) -> dict[str, Any]:
    known = {name: edge[name] for name in ("probability", "driven", "turn") if name in edge}
    properties = {
        "id": number,
        "startid": source,
        "endid": target,
        "cost": max(edge["weight"], _LEAST_COST),
        "overridable": False,
        "metadata": known,
    }
    line = places[[source, target], :2].tolist()
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": "MultiLineString", "coordinates": [line]},
    }
