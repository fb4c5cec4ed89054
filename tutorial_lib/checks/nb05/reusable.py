"""The check of which vertex takes the place of an anchor, in notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import calling
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping import edge_rules

Case = tuple[Array, Array, NDArray[np.bool_], float]


def _random_case(seed: int) -> Case:
    """Some vertices, of which a few fit."""
    rng = np.random.default_rng(seed)
    into, onward = rng.uniform(0.0, 1.0, (2, int(rng.integers(1, 9)))).round(2)
    p_reuse = float(rng.choice([0.0, 0.2, 0.4, 0.6]))
    return into, onward, rng.random(len(into)) < 0.7, p_reuse


_CASES: dict[str, Case] = {
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
    )
} | {f"vertices drawn at random ({seed})": _random_case(seed) for seed in range(20)}


def _by(
    fits: Callable[[Array, Array, float], Any] = lambda i, o, p: (i > p) & (o > p),
    score: Callable[[Array, Array], Any] = lambda i, o: i * o,
    masked: bool = True,
) -> Callable[..., int]:
    """Another rule of reuse."""

    def rule(into: Array, onward: Array, allowed: NDArray[np.bool_], p_reuse: float) -> int:
        fit = fits(into, onward, p_reuse) & (allowed if masked else True)
        return int(np.where(fit, score(into, onward), -1.0).argmax()) if fit.any() else -1

    return rule


def _among_those_that_fit(into: Array, onward: Array, allowed: Array, p_reuse: float) -> int:
    fit = (into > p_reuse) & (onward > p_reuse) & allowed
    return int((into * onward)[fit].argmax()) if fit.any() else -1


def _best_first(into: Array, onward: Array, allowed: Array, p_reuse: float) -> int:
    best = int(np.where(allowed, into * onward, -1.0).argmax()) if len(into) else -1
    fits = best >= 0 and min(into[best], onward[best]) > p_reuse and bool(allowed[best])
    return best if fits else -1


def _best_of_all(into: Array, onward: Array, allowed: Array, p_reuse: float) -> int:
    best = int((into * onward).argmax()) if len(into) else -1
    fits = best >= 0 and min(into[best], onward[best]) > p_reuse and bool(allowed[best])
    return best if fits else -1


def _until_forbidden(into: Array, onward: Array, allowed: Array, p_reuse: float) -> int:
    end = len(allowed) if allowed.all() else int(allowed.argmin())
    return edge_rules.reusable(into[:end], onward[:end], allowed[:end], p_reuse)


def _last_that_fits(into: Array, onward: Array, allowed: Array, p_reuse: float) -> int:
    fit = np.flatnonzero((into > p_reuse) & (onward > p_reuse) & allowed)
    return int(fit[-1]) if len(fit) else -1


_FAULTS: dict[str, Callable[..., int]] = {
    "the best of all need not fit: first find those that do, then the best of them": _best_first,
    "the best of all need not fit, or be allowed: first find those that do and are": _best_of_all,
    "after a vertex that is not allowed others may come: continue, not break": _until_forbidden,
    "the next anchor must be reachable from the vertex, too: onward > p_reuse": _by(
        lambda i, o, p: i > p
    ),
    "the vertex must be reachable from the anchor before, too: into > p_reuse": _by(
        lambda i, o, p: o > p
    ),
    "both must be above p_reuse; one of them is not enough": _by(lambda i, o, p: (i > p) | (o > p)),
    "each of the two must be above p_reuse, not their product": _by(lambda i, o, p: i * o > p),
    "each of the two must be above p_reuse, not their mean": _by(lambda i, o, p: (i + o) / 2 > p),
    "greater than p_reuse, not equal to it": _by(lambda i, o, p: (i >= p) & (o >= p)),
    "p_reuse is an argument, and not always the same": _by(lambda i, o, p: (i > 0.97) & (o > 0.97)),
    "p_reuse is an argument, and not always 0.99": _by(lambda i, o, p: (i > 0.99) & (o > 0.99)),
    "of those that fit take the most probable path, into * onward, not the first": _by(
        score=lambda i, o: 0 * i
    ),
    "of those that fit take the most probable path, into * onward, not the last": _last_that_fits,
    "of those that fit take the greatest product, not the least": _by(score=lambda i, o: 2 - i * o),
    "vertex 0 is a vertex like any other, and may be the best one": lambda *case: (
        edge_rules.reusable(*case) or -1
    ),
    "vertex 0 is a vertex, too; yours looks at the others only": lambda into, onward, ok, p: (
        edge_rules.reusable(into, onward, ok & (np.arange(len(ok)) > 0), p)
    ),
    "two probabilities in a row are multiplied, not added": _by(score=lambda i, o: i + o),
    "of those that fit take the greatest product, not the greatest minimum": _by(score=np.minimum),
    "the step onward counts, too: into * onward": _by(score=lambda i, o: i),
    "the step into the vertex counts, too: into * onward": _by(score=lambda i, o: o),
    "only vertices that are allowed may be taken": _by(masked=False),
    "that is its index among those that fit, not its index in the map": _among_those_that_fit,
    "where none fits there is none: -1, not vertex 0": lambda *case: max(
        0, edge_rules.reusable(*case)
    ),
}


@check(edge_rules.reusable, _CASES["two fit"])
def check_reusable(student: Callable[..., Any]) -> None:
    """Anchors for which vertices fit, fit by half, may not be taken, or do not exist."""
    invoke = calling(
        {
            ValueError: "is there a vertex that fits? Ask .any() before argmax",
            IndexError: "is there a vertex that fits? Ask .any() first",
        }
    )
    compare(
        "reusable",
        student,
        _CASES,
        edge_rules.reusable,
        _FAULTS,
        invoke=invoke,
        form=_vertex,
        same=_as_good,
        difference=_why,
    )


def _vertex(what: str, got: Any, into: Array, *_: object) -> int:  # noqa: ANN401 - students'
    if got is None:
        raise WrongAnswer(f"{what}: None came back; return -1 where no vertex fits")
    whole = isinstance(got, int | np.integer) and not isinstance(got, bool | np.bool_)
    if isinstance(got, np.ndarray) and got.shape == () and got.dtype.kind == "i":
        whole = True
    if not whole:
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


def _why(
    got: int, want: int, into: Array, onward: Array, allowed: NDArray[np.bool_], p_reuse: float
) -> str:
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
