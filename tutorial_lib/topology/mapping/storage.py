"""Maps on disk: one `.npz` file with the observations and, as JSON, the graph.

One file, so that there is never an older graph beside newer observations: whatever saves at the
same time, a reader finds one map or another.
"""

import hashlib
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.files import save_arrays
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.reading.documents import parse_json
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import instance, path_of, with_methods

VERSION = 2
"""Of the file's layout; maps of version 1 were two files, NAME.json beside NAME-DIGEST.npz."""
_SEEN = ("image", "laser", "odometry", "speed", "steering")
_OTHERS = ("contexts", "timestamps", "trajectory", "place")
_MOST_DRIVEN = 10**9
"""How often trajectories can have gone along an edge."""
_AXES = {
    "image": None,
    "contexts": None,
    "laser": 2,
    "odometry": 2,
    "speed": 1,
    "steering": 1,
    "timestamps": 1,
    "trajectory": 1,
    "place": 1,
}
"""The arrays of a map's V vertices, and how many axes each has; any number, for images."""

_Edge = tuple[int, int, float, int]
"""Source, target, probability, and how often it was driven."""
_Turn = tuple[int, int, float]
"""Source, target, and by how much (rad) a robot turns between them."""


def save_map(path: str | Path, topomap: TopoMap) -> None:
    """Write a map to one `.npz` file, whole or not at all.

    Raises:
        InputError: when the map is empty, the name does not end in `.npz`, or the file cannot be
            written.
    """
    path = _npz(path)
    if not len(instance("topomap", topomap, TopoMap)):
        raise InputError(f"{path}: an empty map; add a trajectory before saving it")
    alive = topomap.alive
    new = {int(old): number for number, old in enumerate(alive)}
    edges = [
        [new[source], new[target], edge["probability"], edge["driven"]]
        for source, target, edge in topomap.graph.edges(data=True)
    ]
    paths = [[new[v] for v in vertices if v in new] for vertices in topomap.paths]
    turns = [
        [new[source], new[target], angle]
        for source, target, angle in topomap.graph.edges(data="turn")
        if angle is not None
    ]
    settings = asdict(topomap.settings)
    # "trails" is what the first version called the paths.
    graph = {"settings": settings, "edges": edges, "turns": turns, "trails": paths}
    text = np.frombuffer(json.dumps(graph).encode(), np.uint8)
    arrays = {**_arrays(topomap, alive), "graph": text}
    arrays["digest"] = _digest(arrays)
    save_arrays(path, arrays, version=VERSION, compressed=True)


def load_map(path: str | Path, reachability: Reachability) -> TopoMap:
    """Read what `save_map` wrote, for use with `reachability`.

    Raises:
        InputError: when the file is missing, damaged or of another version.
    """
    path = _npz(path)
    with_methods("reachability", reachability, "prepare", "probability")
    advice = "build the map again and save it"
    names = (*_SEEN, *_OTHERS, "graph", "digest")
    arrays = load_arrays(path, names, version=VERSION, advice=advice)
    try:
        if not np.array_equal(arrays.pop("digest"), _digest(arrays)):
            raise InputError("damaged (its digest is that of another map)")
        graph = _graph(arrays.pop("graph"))
        _check_arrays(arrays)
        return _topomap(graph, arrays, reachability)
    except InputError as error:
        raise InputError(f"{path}: {error}; {advice}") from error


def _npz(path: str | Path) -> Path:
    path = path_of("path", path)
    if path.suffix == ".json":
        first = "maps of the first version ended in .json and can no longer be read"
        raise InputError(f"{path}: {first}; build the map again and save it as .npz")
    if path.suffix != ".npz":
        raise InputError(f"{path}: the name of a map ends in .npz; give another name")
    return path


def _arrays(topomap: TopoMap, alive: NDArray[np.intp]) -> dict[str, NDArray[Any]]:
    seen = topomap.vertices.observations[alive]
    arrays = {name: np.asarray(getattr(seen, name)) for name in _SEEN}
    return arrays | {
        "contexts": topomap.vertices.contexts[alive],
        "timestamps": topomap.vertices.timestamps[alive],
        "trajectory": topomap.trajectory[alive],
        "place": topomap.place[alive],
    }


def _digest(arrays: dict[str, NDArray[Any]]) -> NDArray[np.uint8]:
    """SHA-256 (32,) of all that a map says."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        digest.update(f"{name} {arrays[name].dtype} {arrays[name].shape}".encode())
        digest.update(np.ascontiguousarray(arrays[name]).reshape(-1).view(np.uint8).data)
    return np.frombuffer(digest.digest(), np.uint8)


def _graph(stored: NDArray[Any]) -> dict[str, Any]:
    """Settings, edges and paths."""
    try:
        graph = parse_json(stored.tobytes().decode(), "its graph")
    except UnicodeDecodeError as error:
        raise InputError(f"its graph is no UTF-8 text ({error})") from error
    keys = {"settings", "edges", "trails"}
    found = set(graph) - {"turns"} if isinstance(graph, dict) else set()  # few maps have turns
    wrong = keys ^ found
    if wrong:
        raise InputError(f"{', '.join(sorted(wrong))}: missing, or not part of a map")
    return graph


def _topomap(
    graph: dict[str, Any], arrays: dict[str, NDArray[Any]], reachability: Reachability
) -> TopoMap:
    try:
        settings = MapSettings(**graph["settings"])
    except TypeError as error:
        raise InputError(f"settings: damaged ({error})") from error
    found = TopoMap(reachability, settings)
    found.paths = _read_paths(graph["trails"], arrays["trajectory"], arrays["place"])
    edges = _read_edges(graph["edges"], len(arrays["place"]))
    seen = Observation(depth=None, **{name: arrays[name] for name in _SEEN})
    found.make_vertices(seen, *(arrays[name] for name in _OTHERS))
    for edge in edges:
        found.connect(*edge)
    for source, target, angle in _read_turns(graph.get("turns", []), edges):
        found.graph.edges[source, target]["turn"] = angle
    return found


def _check_arrays(arrays: dict[str, NDArray[Any]]) -> None:
    """Check that the arrays are those of a map, of numbers, and have a row for each vertex.

    Raises:
        InputError: naming the array that is not.
    """
    wrong = sorted(_AXES.keys() ^ arrays.keys())
    if wrong:
        raise InputError(f"damaged ({', '.join(wrong)}: missing, or not part of a map)")
    count = len(np.atleast_1d(arrays["timestamps"]))
    for name, axes in _AXES.items():
        array = arrays[name]
        wanted = max(array.ndim, 1) if axes is None else axes
        if array.ndim != wanted or len(array) != count or array.dtype.kind not in "biuf":
            raise InputError(
                f"{name}: {array.dtype} of shape {array.shape}, for a map of {count} vertices"
            )
        # A laser has no reading where a picture was all that was seen.
        if name != "laser" and array.dtype.kind == "f" and not np.isfinite(array).all():
            raise InputError(f"{name}: holds numbers that are not finite")
    for name in ("trajectory", "place"):
        if arrays[name].dtype.kind != "i":
            raise InputError(f"{name}: {arrays[name].dtype} where whole numbers belong")


def _read_paths(
    stored: Any,  # noqa: ANN401 - anything JSON can hold
    trajectory: NDArray[np.integer],
    place: NDArray[np.integer],
) -> list[list[int]]:
    """The vertices of each trajectory, if every vertex is where its own trajectory has it.

    Raises:
        InputError: otherwise.
    """
    count = len(place)
    if not isinstance(stored, list) or not all(isinstance(path, list) for path in stored):
        raise InputError("damaged (paths: not a list of lists)")
    for number, path in enumerate(stored):
        if not all(type(vertex) is int for vertex in path):
            raise InputError(f"damaged (paths[{number}]: not all are whole numbers)")
        gone = sorted({vertex for vertex in path if not 0 <= vertex < count})
        if gone:
            raise InputError(f"trajectory {number} leads over {gone}, which are not there")
    for vertex, (own, at) in enumerate(zip(trajectory.tolist(), place.tolist(), strict=True)):
        if not 0 <= own < len(stored):
            raise InputError(f"damaged (vertex {vertex} has no trajectory)")
        if not 0 <= at < len(stored[own]) or stored[own][at] != vertex:
            raise InputError(f"vertex {vertex} is not where its trajectory has it")
    return stored


def _read_edges(stored: Any, count: int) -> list[_Edge]:  # noqa: ANN401 - anything JSON can hold
    """The edges between `count` vertices, each once and none from a vertex to itself.

    Raises:
        InputError: otherwise.
    """
    if not isinstance(stored, list):
        raise InputError("damaged (edges: not a list)")
    known = set()
    for edge in stored:
        if not isinstance(edge, list) or len(edge) != 4:
            raise InputError(f"damaged (edge {edge!r:.60}: not of four numbers)")
        source, target, probability, driven = edge
        where = f"edge {source!r:.20} to {target!r:.20}"
        if not (type(source) is type(target) is int):
            raise InputError(f"damaged ({where}: not between whole numbers)")
        if not (0 <= source < count and 0 <= target < count):
            raise InputError(f"{where}; the map has {count} vertices")
        if type(probability) not in (int, float) or not 0.0 <= probability <= 1.0:
            raise InputError(f"{where}: probability {probability!r:.20}")
        if type(driven) is not int or not 0 <= driven <= _MOST_DRIVEN:
            raise InputError(f"{where}: driven {driven!r:.20} times")
        if source == target or (source, target) in known:
            raise InputError(f"{where}: from a vertex to itself, or twice")
        known.add((source, target))
    return [tuple(edge) for edge in stored]


def _read_turns(stored: Any, edges: list[_Edge]) -> list[_Turn]:  # noqa: ANN401 - any JSON
    """The turns of those edges that have one.

    Raises:
        InputError: when one is damaged, or is not that of an edge.
    """
    known = {edge[:2] for edge in edges}
    if not isinstance(stored, list):
        raise InputError("damaged (turns: not a list)")
    for turn in stored:
        if not isinstance(turn, list) or len(turn) != 3 or type(turn[2]) not in (int, float):
            raise InputError(f"damaged (turn {turn!r:.60}: not of three numbers)")
        source, target, angle = turn
        if type(source) is not int or type(target) is not int or (source, target) not in known:
            raise InputError(f"turn {source!r:.20} to {target!r:.20}; there is no such edge")
        if not -math.pi <= angle <= math.pi:
            raise InputError(f"turn {source} to {target}: by {angle!r:.20} rad")
    return [(source, target, float(angle)) for source, target, angle in stored]
