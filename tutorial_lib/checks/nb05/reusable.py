"""The check of which vertex takes the place of an anchor, in notebook 05."""

from typing import Any

import numpy as np

from tutorial_lib.checks.engine import Mask, WrongAnswer, calling, exercise, kind
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.edge_rules import reusable

Case = tuple[Array, Array, Mask, float]


def _random_case(seed: int) -> Case:
    """Some vertices, of which a few fit."""
    rng = np.random.default_rng(seed)
    into, onward = rng.uniform(0.0, 1.0, (2, int(rng.integers(1, 9)))).round(2)
    p_reuse = float(rng.choice([0.0, 0.2, 0.4, 0.6]))
    return into, onward, rng.random(len(into)) < 0.7, p_reuse


CASES: dict[str, Case] = {
    name: (np.array(into), np.array(onward), np.array(allowed, dtype=bool), p_reuse)
    for name, into, onward, allowed, p_reuse in (
        ("two fit", [0.5, 0.99, 0.98, 0.2], [1.0, 0.98, 0.995, 0.99], [1, 1, 1, 1], 0.97),
        ("an empty map", [], [], [], 0.97),
        ("none fits", [0.99, 0.4, 0.9], [0.5, 0.99, 0.9], [1, 1, 1], 0.97),
        ("reachable, but leads nowhere", [0.999, 0.3], [0.2, 0.4], [1, 1], 0.9),
        ("leads on, but not reachable", [0.3, 0.2], [0.4, 0.999], [1, 1], 0.9),
        ("surely reachable, leads on doubtfully", [1.0, 0.975], [0.965, 0.975], [1, 1], 0.97),
        ("the best is not allowed", [0.999, 0.98, 0.99], [0.999, 0.98, 0.98], [0, 1, 1], 0.95),
        ("RE to the vertices equals p_reuse", [0.97, 0.97], [0.99, 0.99], [1, 1], 0.97),
        ("RE from the vertices equals p_reuse", [0.99, 0.99], [0.97, 0.97], [1, 1], 0.97),
        ("uneven ones", [0.9, 0.95, 0.86], [1.0, 0.949, 0.86], [1, 1, 1], 0.85),
        ("even and uneven", [0.999, 0.985], [0.972, 0.985], [1, 1], 0.95),
        ("each is enough, their product is less", [0.98, 0.5], [0.98, 0.9], [1, 1], 0.97),
        ("the last one fits", [0.2, 0.99], [0.2, 0.99], [1, 1], 0.9),
        ("none is allowed", [0.99, 0.98], [0.99, 0.98], [0, 0], 0.9),
        ("a low threshold", [0.1, 0.3, 0.2], [0.2, 0.15, 0.3], [1, 1, 1], 0.05),
        ("p_reuse = 0 and small RE", [0.1, 0.2, 0.0], [0.1, 0.1, 0.9], [1, 1, 1], 0.0),
        ("never reuse", [1.0, 1.0], [1.0, 1.0], [1, 1], 1.0),
        ("one vertex", [0.99], [0.98], [1], 0.97),
        ("hardly unequal ones", [0.9911, 0.99112], [0.9911, 0.9911], [1, 1], 0.97),
    )
} | {f"vertices drawn at random ({seed})": _random_case(seed) for seed in range(20)}
MISTAKES = """
the best of all need not fit: first find those that do, then the best of them
    not fits.any(): -> not fits.any() or not fits[np.where(allowed, into * onward, -1).argmax()]:
the best of all need not fit, or be allowed: first find those that do and are
    not fits.any(): -> not fits.any() or not fits[np.argmax(into * onward)]:
after a vertex that is not allowed others may come: continue, not break
    & allowed -> & np.logical_and.accumulate(allowed)
the next anchor must be reachable from the vertex, too: onward > p_reuse
    & (onward > p_reuse) & allowed -> & allowed
the vertex must be reachable from the anchor before, too: into > p_reuse
    (into > p_reuse) & (onward > p_reuse) -> (onward > p_reuse)
both must be above p_reuse; one of them is not enough
    (into > p_reuse) & (onward > p_reuse) -> ((into > p_reuse) | (onward > p_reuse))
each of the two must be above p_reuse, not their product
    (into > p_reuse) & (onward > p_reuse) -> (into * onward > p_reuse)
each of the two must be above p_reuse, not their mean
    (into > p_reuse) & (onward > p_reuse) -> ((into + onward) / 2 > p_reuse)
greater than p_reuse, not equal to it
    (into > p_reuse) & (onward > p_reuse) -> (into >= p_reuse) & (onward >= p_reuse)
p_reuse is an argument, and not always the same
    (into > p_reuse) & (onward > p_reuse) -> (into > 0.97) & (onward > 0.97)
p_reuse is an argument, and not always 0.99
    (into > p_reuse) & (onward > p_reuse) -> (into > 0.99) & (onward > 0.99)
of those that fit take the most probable path, into * onward, not the first
    np.where(fits, into * onward, -1.0) -> fits
of those that fit take the most probable path, into * onward, not the last
    np.where(fits, into * onward, -1.0).argmax() -> np.flatnonzero(fits)[-1]
of those that fit take the greatest product, not the least
    into * onward -> 2 - into * onward
vertex 0 is a vertex like any other, and may be the best one
    .argmax()) -> .argmax()) or -1
vertex 0 is a vertex, too; yours looks at the others only
    & allowed -> & allowed & (np.arange(len(allowed)) > 0)
two probabilities in a row are multiplied, not added
    into * onward -> into + onward
of those that fit take the greatest product, not the greatest minimum
    into * onward -> np.minimum(into, onward)
the step onward counts, too: into * onward
    into * onward -> into
the step into the vertex counts, too: into * onward
    into * onward -> onward
only vertices that are allowed may be taken
    (onward > p_reuse) & allowed -> (onward > p_reuse)
that is its index among those that fit, not its index in the map
    np.where(fits, into * onward, -1.0).argmax() -> (into * onward)[fits].argmax()
where none fits there is none: -1, not vertex 0
    return -1 -> return 0
"""


def _vertex(what: str, got: Any, into: Array, *_: object) -> int:  # noqa: ANN401 - students'
    if got is None:
        raise WrongAnswer(f"{what}: None came back; return -1 where no vertex fits")
    whole = isinstance(got, int | np.integer) and not isinstance(got, bool | np.bool_)
    if not (whole or (isinstance(got, np.ndarray) and got.shape == () and got.dtype.kind == "i")):
        shown = kind(got) if isinstance(got, np.ndarray | list) else repr(got)
        words = "return the index of one vertex, a whole number, or -1"
        raise WrongAnswer(f"{what}: {shown} came back; {words}")
    if not -1 <= int(got) < max(len(into), 1):
        raise WrongAnswer(f"{what}: {got} came back, but there are {len(into)} vertices, from 0")
    return int(got)


def _as_good(got: int, want: int, into: Array, onward: Array, *rest: Any) -> bool:  # noqa: ANN401
    """Whether two answers are equally good; of vertices with the same product any will do."""
    if got == want or min(got, want) < 0:
        return got == want
    fits = bool(rest[0][got]) and min(into[got], onward[got]) > rest[1]
    return fits and np.isclose(into[got] * onward[got], into[want] * onward[want], atol=1e-12)


def _why(got: int, want: int, into: Array, onward: Array, allowed: Mask, p_reuse: float) -> str:
    """What is wrong with one answer."""
    if got < 0:
        numbers = f"into {into[want]:.4g} and onward {onward[want]:.4g}"
        return f"yours finds none, but vertex {want} fits: {numbers} are above {p_reuse:g}"
    if not len(into):
        return f"vertex {got} came back, but the map is empty; return -1"
    if not allowed[got]:
        return f"yours takes vertex {got}, which is not allowed"
    for name, reach in (("into", into), ("onward", onward)):
        if not reach[got] > p_reuse:
            return f"{name} of vertex {got} is {reach[got]:.4g}, not greater than {p_reuse:g}"
    products = f"{into[got] * onward[got]:.4g}; vertex {want} has {into[want] * onward[want]:.4g}"
    return f"vertex {got} fits, but its product into * onward is only {products}"


_HINTS: dict[type[Exception], str] = {
    ValueError: "is there a vertex that fits? Ask .any() before argmax",
    IndexError: "is there a vertex that fits? Ask .any() first",
}
check_reusable = exercise(
    reusable,
    CASES,
    MISTAKES,
    about="Anchors for which vertices fit, fit by half, may not be taken, or do not exist.",
    example=CASES["two fit"],
    invoke=calling(_HINTS),
    form=_vertex,
    same=_as_good,
    difference=_why,
)
