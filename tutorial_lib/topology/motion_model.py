"""How a robot moves along the edges of a map, by what its wheels measure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, relative
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import alike, floats, instance, whole

TURN = 0.5
"""Metres that one rad counts as: turning changes the view as driving does."""
STRAYS, RETURNS_AFTER = 0.03, 1.0
"""Share of what leaves a vertex that goes off the map, and metres until it is on the map again."""
BACK = 0.15
"""Share of what leaves a vertex that goes back along an edge: the robot was not yet where it was
believed to be, or it reverses."""
_USUAL, _SHORTEST = 1.5, 0.3  # metres of an edge


@dataclass(frozen=True, eq=False)
class MotionModel:
    """A motion model along edges, for beliefs over V vertices and off the map.

    Attributes:
        lengths: (V + 1,) metres that a robot goes on average until it leaves each.
        onward: (V + 1, V + 1) where it comes to then; each row sums to one.

    Raises:
        InputError: when shapes do not fit, a length is not positive or a row does not sum to one.
    """

    lengths: Array
    onward: Array

    def __post_init__(self) -> None:
        lengths = floats("motion: lengths", self.lengths, ("V+1",), empty=False)
        onward = floats("motion: onward", self.onward, ("V+1", "V+1"))
        alike(lengths=lengths, onward=onward)
        alike(lengths=lengths, onward=onward.T)
        if not (self.lengths > 0).all():
            raise InputError("motion: lengths: a length is not positive; give metres")
        if not np.allclose(self.onward.sum(axis=1), 1.0) or (self.onward < 0).any():
            raise InputError("motion: a row of onward does not sum to one; give probabilities")


def moved(motion: Array) -> Array:
    """Metres (N,) that motions (N, 3) in a robot's frame count as.

    >>> moved(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0]])).tolist()
    [5.0, 0.5]
    """
    return length_of(floats("motion", motion, (..., 3)))


def length_of(motion: Array) -> Array:
    """The same of motions that are right, or not a number where it is not known."""
    return np.linalg.norm(motion[..., :2], axis=-1) + TURN * np.abs(motion[..., 2])


def motion_model(topomap: TopoMap) -> MotionModel:
    """The motion model of a map: from each vertex along its edges, the surer ones more often.

    Lengths are those that odometry measured where one trajectory made both ends of an edge; the
    others have the usual one. Edges on which a robot turns are left out: each rests on one place,
    whose twin would look the same, and would carry the belief there.
    """
    alive = instance("topomap", topomap, TopoMap).alive
    column = {int(vertex): i for i, vertex in enumerate(alive)}
    count = len(alive)
    length, share = np.zeros((2, count, count))
    for v, w, probability in _driven(topomap):
        share[column[v], column[w]] = probability
        length[column[v], column[w]] = _length(topomap, v, w)
    known = length > 0
    usual = float(np.median(length[known])) if known.any() else _USUAL
    length = np.where((share > 0) & ~known, usual, length)
    edges = (share > 0).sum(axis=1)
    mean = np.where(edges > 0, length.sum(axis=1) / np.maximum(edges, 1), usual)
    return MotionModel(np.append(np.maximum(mean, _SHORTEST), RETURNS_AFTER), _onward(share))


def neighbourhoods(topomap: TopoMap, steps: int) -> NDArray[np.bool_]:
    """(V, V) which vertices lie at most so many edges from each, forwards or backwards.

    Edges on which a robot turns are left out, see `motion_model`.
    """
    count = len(instance("topomap", topomap, TopoMap))
    whole("steps", steps, least=0)
    joined = np.eye(count, dtype=bool)
    edges = np.array([(v, w) for v, w, _ in _driven(topomap)], dtype=np.intp).reshape(-1, 2)
    joined[tuple(np.searchsorted(topomap.alive, edges).T)] = True
    near, joined = np.eye(count, dtype=bool), joined.astype(np.float32)
    for _ in range(min(steps, count)):
        near = near.astype(np.float32) @ joined > 0  # in numbers, which is much faster
    return near | near.T


def _driven(topomap: TopoMap) -> list[tuple[int, int, float]]:
    """Edges along which a robot drives, with their probabilities."""
    edges = topomap.graph.edges(data=True)
    return [(v, w, edge["probability"]) for v, w, edge in edges if "turn" not in edge]


def _length(topomap: TopoMap, v: int, w: int) -> float:
    """Metres between two vertices of one trajectory, 0 where odometry does not know."""
    if topomap.trajectory[v] != topomap.trajectory[w]:
        return 0.0
    start, end = topomap.vertices.observations[np.array([v, w])].odometry
    return float(moved(relative(start, end)))


def _onward(share: Array) -> Array:
    """Where a robot comes to from each vertex, and from off the map: anywhere."""
    count = len(share)
    onward = np.zeros((count + 1, count + 1))
    ahead, behind = (_rows(edges) for edges in (share, share.T))
    onward[:count, :count] = (1.0 - BACK) * ahead + BACK * behind
    onward[:count, count] = STRAYS
    onward[:count, :count] *= 1.0 - STRAYS
    onward[:count, count] += 1.0 - onward[:count].sum(axis=1)  # where there is no edge
    onward[count, :count] = 1.0 / max(count, 1)
    onward[count, count] = 0.0 if count else 1.0
    return onward


def _rows(edges: Array) -> Array:
    """Rows that sum to one, or to zero where there is no edge."""
    total = edges.sum(axis=1, keepdims=True)
    return np.divide(edges, total, out=np.zeros_like(edges), where=total > 0)
