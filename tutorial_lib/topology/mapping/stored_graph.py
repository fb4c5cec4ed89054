"""What a map's file says, checked before a map is made of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError

MOST_DRIVEN = 10**9
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

Edge = tuple[int, int, float, int]
"""Source, target, probability, and how often it was driven."""
Turn = tuple[int, int, float]
"""Source, target, and by how much (rad) a robot turns between them."""


def check_arrays(arrays: dict[str, NDArray[Any]]) -> None:
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


def read_paths(
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


def read_edges(stored: Any, count: int) -> list[Edge]:  # noqa: ANN401 - anything JSON can hold
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
        if type(driven) is not int or not 0 <= driven <= MOST_DRIVEN:
            raise InputError(f"{where}: driven {driven!r:.20} times")
        if source == target or (source, target) in known:
            raise InputError(f"{where}: from a vertex to itself, or twice")
        known.add((source, target))
    return [tuple(edge) for edge in stored]


def read_turns(stored: Any, edges: list[Edge]) -> list[Turn]:  # noqa: ANN401 - any JSON
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
