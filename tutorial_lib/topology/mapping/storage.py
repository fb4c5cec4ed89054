"""Maps on disk: a JSON file with the graph, and beside it an `.npz` file with the observations.

The graph names the file of arrays that it belongs to by a digest, and is written last: an
interrupted save leaves the old map intact. Its own checksum is over all that it says.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path, save_arrays, write_text
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.reading.checksums import CHECKSUM, with_checksum, without_checksum
from tutorial_lib.reading.documents import read_json
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.stored_graph import check_arrays, read_edges, read_paths
from tutorial_lib.topology.mapping.topomap import TopoMap

VERSION = 2
"""Of the files' layout; the graph of version 1 had no checksum."""
_ADVICE = "build the map again and save it"
_KEYS = {"version", "arrays", "digest", "settings", "edges", "trails"}
_SEEN = ("image", "laser", "odometry", "speed", "steering")


def save_map(path: str | Path, topomap: TopoMap) -> None:
    """Write a map to `path` (JSON) and to an `.npz` file beside it.

    Raises:
        InputError: when the map is empty, or the name does not end in `.json`.
    """
    path = _json(path)
    if not len(topomap):
        raise InputError(f"{path}: an empty map; add a trajectory before saving it")
    alive = topomap.alive
    arrays = _arrays(topomap, alive)
    digest = _digest(arrays)
    beside = path.with_name(f"{path.stem}-{digest[:12]}.npz")
    save_arrays(beside, arrays, compressed=True)
    new = {int(old): number for number, old in enumerate(alive)}
    edges = [
        [new[source], new[target], edge["probability"], edge["driven"]]
        for source, target, edge in topomap.graph.edges(data=True)
    ]
    paths = [[new[v] for v in vertices if v in new] for vertices in topomap.paths]
    graph = {
        "version": VERSION,
        "arrays": beside.name,
        "digest": digest,
        "settings": asdict(topomap.settings),
        "edges": edges,
        "trails": paths,  # as files have called them since version 1
    }
    write_text(path, json.dumps(with_checksum(graph)))
    for stale in path.parent.glob(f"{path.stem}-{'[0-9a-f]' * 12}.npz"):
        if stale != beside:
            stale.unlink()


def load_map(path: str | Path, reachability: Reachability) -> TopoMap:
    """Read what `save_map` wrote, for use with `reachability`.

    Raises:
        InputError: when a file is missing, damaged or of another version; it says which.
    """
    path = _json(path)
    content = read_json(path, _ADVICE)
    try:
        graph = _graph(content)
        arrays = _load(path.with_name(graph["arrays"]), graph["digest"])
        return _topomap(graph, arrays, reachability)
    except InputError as error:
        raise InputError(f"{path}: {error}; {_ADVICE}") from error


def export_graphml(path: str | Path, topomap: TopoMap) -> None:
    """Write the graph as GraphML, for programs that draw or analyse graphs."""
    graph = nx.DiGraph()
    for vertex in sorted(topomap.graph):
        graph.add_node(
            vertex,
            trajectory=int(topomap.trajectory[vertex]),
            place=int(topomap.place[vertex]),
            timestamp=float(topomap.vertices.timestamps[vertex]),
        )
    graph.add_edges_from(topomap.graph.edges(data=True))
    with atomic_path(path) as temporary:
        nx.write_graphml(graph, temporary)


def _json(path: str | Path) -> Path:
    path = Path(path)
    if path.suffix != ".json":
        raise InputError(f"{path}: the name of a map ends in .json; give another name")
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


def _digest(arrays: dict[str, NDArray[Any]]) -> str:
    digest = hashlib.sha256()
    for name in sorted(arrays):
        digest.update(f"{name} {arrays[name].dtype} {arrays[name].shape}".encode())
        digest.update(np.ascontiguousarray(arrays[name]).reshape(-1).view(np.uint8))
    return digest.hexdigest()


def _graph(graph: Any) -> dict[str, Any]:  # noqa: ANN401 - anything JSON can hold
    """What the graph's file holds, so far as it is one."""
    version = graph.get("version") if isinstance(graph, dict) else None
    if type(version) is not int or version not in (1, VERSION):
        raise InputError(f"not a map of version {VERSION}")
    missing = _KEYS - set(graph)
    if missing:
        raise InputError(f"{', '.join(sorted(missing))}: missing")
    # A map of version 1 loads so far as it makes sense, which is all that can be said of it.
    if version != 1 or CHECKSUM in graph:
        graph = without_checksum(graph)
    if set(graph) != _KEYS:
        raise InputError(f"{', '.join(sorted(set(graph) - _KEYS))}: not part of a map")
    name = graph["arrays"]
    if not isinstance(name, str) or not name or Path(name).name != name:
        raise InputError(f"arrays: {name!r} is not the name of a file beside it")
    return graph


def _load(path: Path, digest: str) -> dict[str, NDArray[Any]]:
    """The arrays that belong to a graph."""
    try:
        arrays = load_arrays(path, names=())
    except InputError as error:
        raise InputError(f"{path.name}: missing or damaged ({error})") from error
    check_arrays(arrays)
    if _digest(arrays) != digest:
        raise InputError(f"{path.name}: does not belong to this map")
    return arrays


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
    found.make_vertices(
        seen, *(arrays[name] for name in ("contexts", "timestamps", "trajectory", "place"))
    )
    for edge in edges:
        found.connect(*edge)
    return found
