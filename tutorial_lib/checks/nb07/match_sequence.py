"""The check of sequence matching, in notebook 07."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import calling, numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close, compare, with_faults
from tutorial_lib.checks.nb07.small_differences import farthest, of_rounding
from tutorial_lib.geometry import Array


def match_sequence(likelihoods: Array, before: NDArray[np.intp]) -> Array:
    """Likelihoods (V,) of a sequence of views that ends at each vertex; see the exercise."""
    return _matched(likelihoods, before)


def _matched(likelihoods: Array, before: NDArray[np.intp], fault: str = "") -> Array:
    """The best alignment's geometric mean, with a `fault` if one is named."""
    likelihoods = np.minimum(likelihoods, 1.0) if fault == "clipped" else likelihoods
    looks = likelihoods[::-1] if fault == "reversed" else likelihoods
    if fault == "last only":
        return np.array(looks[-1], dtype=float)
    if fault == "last two":
        looks = looks[-2:]
    total = np.array(looks[0], dtype=float)
    for look in looks[1:]:
        come = total[before] if fault == "wraps" else np.where(before >= 0, total[before], 0.0)
        if fault == "after":
            come = np.zeros_like(total)
            for v, w in enumerate(before):
                if w >= 0:
                    come[w] = max(come[w], total[v])
        if fault == "no 0":
            come = np.where(before > 0, total[before], 0.0)
        if fault == "one":
            come = np.where(before >= 0, total[before], 1.0)
        if fault == "by number":
            come = np.concatenate([[0.0], total[:-1]])
        best = np.maximum(total, come)
        best = {
            "anywhere": np.full_like(total, total.max()),
            "worse": np.minimum(total, come),
            "stays": total,
            "comes": come,
            "both": total + come,
            "mean": (total + come) / 2,
            "comes or stays": np.where(before >= 0, come, total),
        }.get(fault, best)
        total = look + best if fault == "adds" else look * best
        if fault == "tiny":
            total[total < 1e-6] = 0.0
        if fault == "scaled":
            total /= total.max()
        if fault == "least":
            total = np.minimum(look, best)
    if fault in ("no root", "least"):
        return total
    if fault in ("divides", "adds"):
        return total / len(looks)
    return total ** (
        1.0
        / {"one less": max(len(looks) - 1, 1), "square": 2, "of V": len(before)}.get(
            fault, len(looks)
        )
    )


_FAULTS = {
    "the whole sequence counts; yours looks at the last view only": "last only",
    "all views count, not only the last two": "last two",
    "the latest view is the last row: the sequence begins with row 0": "reversed",
    "the robot may also stay at its vertex from one view to the next": "comes",
    "the robot may also have come from the vertex before": "stays",
    "of staying and coming the better one counts, not their sum": "both",
    "of staying and coming the better one counts, not their mean": "mean",
    "a likelihood may be above 1; do not cut it off": "clipped",
    "a tiny product is not 0": "tiny",
    "do not divide by the greatest: sequences are compared by their own products": "scaled",
    "the robot comes from the vertex before alone, not from any vertex": "anywhere",
    "of staying and coming the better one counts, not the worse": "worse",
    "the T-th root: T views, not V vertices": "of V",
    "likelihoods multiply; yours adds them": "adds",
    "likelihoods multiply; yours takes the least": "least",
    "the robot comes from the vertex before, total[before], not from the one after": "after",
    "-1 means that there is none; to numpy it is the last vertex": "wraps",
    "vertex 0 exists; only -1 is none": "no 0",
    "the vertex before v is before[v], not v - 1": "by number",
    "where there is no vertex before, coming has the likelihood 0, not 1": "one",
    "also where there is a vertex before, the robot may have stayed: take the better one": (
        "comes or stays"
    ),
    "T views make a product of T likelihoods: the T-th root, not that of T - 1": "one less",
    "the T-th root of T likelihoods, ** (1 / T), not always the square root": "square",
    "take the T-th root, ** (1 / T), so that long sequences compare with short ones": "no root",
    "the geometric mean is the T-th root of the product, not the product divided by T": "divides",
}
_TWO = np.array([-1, 0, 1, 2, -1, 4, 5, 6])
_MIXED = np.array([3, -1, 5, 4, -1, 1, 2])


def _looks(count: int, vertices: int, seed: int) -> Array:
    return np.random.default_rng([seed, 7]).uniform(0.02, 0.95, (count, vertices)).round(2)


_CASES = {
    "twins, and one view that tells them apart": (
        np.array([[0.9, 0.05, 0.1, 0.05], [0.1, 0.8, 0.1, 0.8]]),
        np.array([-1, 0, -1, 2]),
    ),
    "three views along two trajectories": (_looks(3, 8, 1), _TWO),
    "a single view": (_looks(1, 8, 2), _TWO),
    "five views": (_looks(5, 8, 3), _TWO),
    "vertices in no order": (_looks(4, 7, 4), _MIXED),
    "more views than vertices": (_looks(6, 3, 5), np.array([-1, 0, 1])),
    "likelihoods above 1": (_looks(3, 8, 8) * 5.0, _TWO),
    "views that hardly fit anywhere": (_looks(3, 8, 9) * 1e-4, _TWO),
    "no neighbours": (_looks(3, 4, 6), np.full(4, -1)),
}


def _broken(got: Array, want: Array, *_: Array) -> str:
    """Which part of the rule is broken at the worst vertex."""
    if of_rounding(got, want):
        return ""
    worst = int(np.nan_to_num(np.abs(got - want), nan=np.inf).argmax())
    if got[worst] > want[worst]:
        return (
            "yours is too sure: a view before was at the same vertex or at before[v], nowhere "
            "else, and every likelihood counts, that of the first view as well"
        )
    return (
        "yours misses the best sequence: take the better of staying at v and of coming from "
        "before[v], both with what was best until the view before"
    )


@check(match_sequence, (_looks(4, 60, 7), np.arange(60) - 1), calls=300)
def check_match_sequence(student: Callable[..., Any]) -> None:
    """Two views and more, two trajectories, vertices in no order."""
    compare(
        "match_sequence",
        student,
        _CASES,
        match_sequence,
        with_faults(_matched, _FAULTS),
        invoke=calling(
            {ValueError: "each view is a row of V likelihoods, as many as `before` has"}
        ),
        form=lambda what, got, looks, *_: numbers(what, got, looks.shape[1:]),
        same=partial(close, tolerance=1e-9),
        difference=farthest,
        broken=_broken,
    )
