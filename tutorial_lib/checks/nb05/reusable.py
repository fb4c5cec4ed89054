"""The check of which vertex takes the place of an anchor, in notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import hinting
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping import edge_rules

_CASES = {
    name: (np.array(into), np.array(onward), np.array(allowed, dtype=bool), p_reuse)
    for name, into, onward, allowed, p_reuse in (
        ("two fit", [0.5, 0.99, 0.98, 0.2], [1.0, 0.98, 0.995, 0.99], [1, 1, 1, 1], 0.97),
        ("none fits", [0.99, 0.4, 0.9], [0.5, 0.99, 0.9], [1, 1, 1], 0.97),
        ("reachable, but leads nowhere", [0.999, 0.3], [0.2, 0.4], [1, 1], 0.9),
        ("leads on, but not reachable", [0.3, 0.2], [0.4, 0.999], [1, 1], 0.9),
        ("surely reachable, leads on doubtfully", [1.0, 0.975], [0.965, 0.975], [1, 1], 0.97),
        ("the best is not allowed", [0.999, 0.98, 0.99], [0.999, 0.98, 0.98], [0, 1, 1], 0.95),
        ("RE equals the threshold", [0.97, 0.97], [0.99, 0.99], [1, 1], 0.97),
        ("uneven ones", [0.9, 0.95, 0.86], [1.0, 0.949, 0.86], [1, 1, 1], 0.85),
        ("even and uneven", [0.999, 0.985], [0.972, 0.985], [1, 1], 0.95),
        ("each is enough, their product is less", [0.98, 0.5], [0.98, 0.9], [1, 1], 0.97),
        ("never reuse", [1.0, 1.0], [1.0, 1.0], [1, 1], 1.0),
        ("an empty map", [], [], [], 0.97),
    )
}


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


_FAULTS: dict[str, Callable[..., int]] = {
    "the best of all need not fit: first find those that do, then the best of them": _best_first,
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
    "of those that fit take the most probable path, into * onward, not the first": _by(
        score=lambda i, o: 0 * i
    ),
    "two probabilities in a row are multiplied, not added": _by(score=lambda i, o: i + o),
    "of those that fit take the greatest product, not the greatest minimum": _by(score=np.minimum),
    "the step onward counts, too: into * onward": _by(score=lambda i, o: i),
    "only vertices that are allowed may be taken": _by(masked=False),
    "that is its index among those that fit, not its index in the map": _among_those_that_fit,
    "where none fits there is none: -1, not vertex 0": lambda *case: max(
        0, edge_rules.reusable(*case)
    ),
}


@check(edge_rules.reusable, _CASES["two fit"])
def check_reusable(student: Callable[..., Any]) -> None:
    """Twelve anchors: vertices that fit, that fit by half, that may not be taken, and none."""
    invoke = hinting(ValueError, "is there a vertex that fits? Ask .any() before argmax")
    compare("reusable", student, _CASES, edge_rules.reusable, _FAULTS, invoke=invoke, form=_vertex)


def _vertex(what: str, got: Any, *_: object) -> int:  # noqa: ANN401 - students'
    if got is None:
        raise WrongAnswer(f"{what}: None came back; return -1 where no vertex fits")
    if isinstance(got, bool) or not isinstance(got, int | np.integer):
        raise WrongAnswer(f"{what}: {got!r} came back; return the index of one vertex, or -1")
    return int(got)
