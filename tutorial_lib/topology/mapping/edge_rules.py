"""The rules by which a map grows, as functions of arrays (Meng 2020, III-E, III-G)."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, flags, floats, integers, number, whole

_NEVER = 1e-12  # a probability whose logarithm is finite


@dataclass(frozen=True)
class MapSettings:
    """Thresholds and sizes of a map.

    Attributes:
        p_edge: RE above which two vertices are joined.
        p_reuse: RE to a vertex, and onward from it, above which it replaces an anchor; 1 for never.
        sequence: anchors before and after both ends of an edge that must be reachable, too.
        candidates: most similar vertices that a new anchor is compared with first.
        p_outdated: RE below which a vertex between two that are seen again is outdated.
        p_between: RE to an anchor from one vertex, and from it to the next, above which the edge
            between the two replaces it; 1 for never, as in the paper.
        reuse_sequence: anchors before and after one that is to be replaced that must match those
            before and after the vertex, too; 0 as in the paper's III-E, which merges look-alikes.
    """

    p_edge: float = 0.99
    p_reuse: float = 0.94
    sequence: int = 2
    candidates: int = 12
    p_outdated: float = 0.1
    p_between: float = 0.94
    reuse_sequence: int = 0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name.startswith("p_"):
                number(f"map: {field.name}", value, least=0.0, most=1.0)
            else:
                whole(f"map: {field.name}", value, least=int(field.name == "candidates"))


def reusable(into: ArrayLike, onward: ArrayLike, allowed: ArrayLike, p_reuse: float) -> int:
    """The vertex that replaces an anchor, -1 for none (Meng 2020, III-E).

    Of those with RE above `p_reuse` both from the anchor before and to the anchor after, the one
    with the largest product of the two.

    Args:
        into: (V,) RE from the anchor before to each vertex.
        onward: (V,) RE from each vertex to the anchor after.
        allowed: (V,) which may be reused.
        p_reuse: threshold on RE.

    >>> reusable([0.99, 0.98, 0.5, 1.0], [0.98, 0.995, 1.0, 1.0], [True] * 3 + [False], 0.97)
    1
    """
    into = floats("into", into, ("V",), least=0.0, most=1.0)
    onward = floats("onward", onward, ("V",), least=0.0, most=1.0)
    allowed = flags("allowed", allowed, ("V",))
    alike(into=into, onward=onward, allowed=allowed)
    number("p_reuse", p_reuse, least=0.0, most=1.0)
    fits = (into > p_reuse) & (onward > p_reuse) & allowed
    if not fits.any():
        return -1
    return int(np.where(fits, into * onward, -1.0).argmax())


def reusable_edge(
    into: ArrayLike, onward: ArrayLike, edges: ArrayLike, probabilities: ArrayLike, p_reuse: float
) -> tuple[int, int] | None:
    """The edge whose two vertices replace an anchor between them, None for none.

    A vertex that replaces an anchor must be near it: some decimetres further, and it is out of
    reach from the anchor before, or does not reach the one after. Two vertices, one on either side,
    have no such bounds, so that a map ends to grow where robots drive as before.

    Of the edges with RE above `p_reuse` to their source, along them and onward from their target,
    the one with the largest product of the three.

    Args:
        into: (V,) RE from the anchor before to each vertex.
        onward: (V,) RE from each vertex to the anchor after.
        edges: (E, 2) source and target of those that may be taken.
        probabilities: (E,) of those.
        p_reuse: threshold on RE.

    >>> edges = [[0, 1], [1, 2], [2, 0]]
    >>> reusable_edge([0.99, 0.97, 0.5], [0.2, 0.96, 0.98], edges, [0.98, 0.99, 0.99], 0.95)
    (1, 2)
    """
    into = floats("into", into, ("V",), least=0.0, most=1.0)
    onward = floats("onward", onward, ("V",), least=0.0, most=1.0)
    alike(into=into, onward=onward)
    edges = np.empty((0, 2), np.intp) if isinstance(edges, list) and not edges else edges
    edges = integers("edges", edges, ("E", 2), least=0, most=len(into) - 1)
    probabilities = floats("probabilities", probabilities, ("E",), least=0.0, most=1.0)
    alike(edges=edges, probabilities=probabilities)
    number("p_reuse", p_reuse, least=0.0, most=1.0)
    steps = np.stack([into[edges[:, 0]], probabilities, onward[edges[:, 1]]])  # (3, E)
    fits = (steps > p_reuse).all(axis=0)
    if not fits.any():
        return None
    source, target = edges[np.where(fits, steps.prod(axis=0), -1.0).argmax()].tolist()
    return source, target


def ahead_of(
    trajectory: NDArray[np.intp], place: NDArray[np.intp], reused: ArrayLike
) -> NDArray[np.bool_]:
    """(V,) which vertices may follow those `reused`: never backwards along their trajectory.

    Args:
        trajectory: (V,) of each vertex, -1 for none.
        place: (V,) of each on its path, -1 for none.
        reused: vertices, in order.

    >>> ahead_of(np.array([0, 0, 0, 1]), np.array([0, 1, 2, 0]), [1]).tolist()
    [False, False, True, True]
    """
    trajectory = integers("trajectory", trajectory, ("V",), least=-1)
    place = integers("place", place, ("V",), least=-1)
    alike(trajectory=trajectory, place=place)
    reused = integers("reused", reused, ("R",), least=0, most=len(place) - 1)
    allowed = np.ones(len(place), dtype=bool)
    for vertex in reused:
        allowed &= (trajectory != trajectory[vertex]) | (place > place[vertex])
    return allowed


def outdated(
    seen: NDArray[np.bool_], unseen: NDArray[np.bool_], before: NDArray, after: NDArray, reach: int
) -> NDArray[np.intp]:
    """Vertices that a trajectory passed but did not see again (future work in Meng 2020, III-E).

    The vertices before and after such a vertex on its own trajectory were seen again, in this
    order, but the vertex itself was not seen by any anchor in between.

    Args:
        seen: (A, V) whether a vertex can be reached from an anchor.
        unseen: (A, V) whether it certainly cannot.
        before: (V,) the vertex before each on its trajectory, -1 for none.
        after: (V,) the vertex after each.
        reach: anchors that may lie between those that see what is before and what is after.

    >>> seen = np.array([[True, False, False], [False, False, True]])
    >>> outdated(seen, ~seen, np.array([-1, 0, 1]), np.array([1, 2, -1]), 2).tolist()
    [1]
    """
    seen = flags("seen", seen, ("A", "V"))
    unseen = flags("unseen", unseen, ("A", "V"))
    before, after = integers("before", before, ("V",)), integers("after", after, ("V",))
    alike(seen=seen, unseen=unseen)
    alike(seen=seen.T, unseen=unseen.T, before=before, after=after)
    integers("before", before, least=-1, most=len(before) - 1)
    integers("after", after, least=-1, most=len(after) - 1)
    whole("reach", reach, least=0)
    gone = np.zeros(len(before), dtype=bool)
    inner = np.flatnonzero((before >= 0) & (after >= 0))
    for first in range(len(seen)):
        for last in range(first, min(first + reach, len(seen) - 1) + 1):
            met = seen[first, before[inner]] & seen[last, after[inner]]
            gone[inner] |= met & unseen[first : last + 1, inner].all(axis=0)
    return np.flatnonzero(gone)


def weight(probability: ArrayLike) -> Array:
    """-log RE, so that the shortest path is the most probable one (Meng 2020, III-E, III-F).

    >>> weight([1.0, 0.5]).round(2).tolist()
    [0.0, 0.69]
    """
    probability = floats("probability", probability, least=0.0, most=1.0)
    return 0.0 - np.log(np.maximum(probability, _NEVER))
