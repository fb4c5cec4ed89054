"""Maps on disk: one `.npz` file with the observations and, as JSON, the graph.

One file, so that there is never an older graph beside newer observations: whatever saves at the
same time, a reader finds one map or another.
"""

from __future__ import annotations

import hashlib
import json
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
from tutorial_lib.topology.mapping.stored_graph import (
    check_arrays,
    read_edges,
    read_paths,
    read_turns,
)
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import instance, path_of, with_methods

VERSION = 2
"""Of the file's layout; maps of version 1 were two files, NAME.json beside NAME-DIGEST.npz."""
_SEEN = ("image", "laser", "odometry", "speed", "steering")
_OTHERS = ("contexts", "timestamps", "trajectory", "place")


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
        check_arrays(arrays)
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
    found.paths = read_paths(graph["trails"], arrays["trajectory"], arrays["place"])
    edges = read_edges(graph["edges"], len(arrays["place"]))
    seen = Observation(depth=None, **{name: arrays[name] for name in _SEEN})
    found.make_vertices(seen, *(arrays[name] for name in _OTHERS))
    for edge in edges:
        found.connect(*edge)
    for source, target, angle in read_turns(graph.get("turns", []), edges):
        found.graph.edges[source, target]["turn"] = angle
    return found
