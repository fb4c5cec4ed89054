"""The check of sequence matching, in notebook 07."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import calling, case, close, exercise, farthest, numbers
from tutorial_lib.geometry import Array


def match_sequence(likelihoods: Array, before: NDArray[np.intp]) -> Array:
    """Likelihoods (V,) of a sequence of views that ends at each vertex; see the exercise."""
    total = np.array(likelihoods[0], dtype=float)
    for look in likelihoods[1:]:
        come = np.where(before >= 0, total[before], 0.0)
        best = np.maximum(total, come)
        total = look * best
    return total ** (1.0 / len(likelihoods))


_TWO = np.array([-1, 0, 1, 2, -1, 4, 5, 6])
_MIXED = np.array([3, -1, 5, 4, -1, 1, 2])


def _looks(count: int, vertices: int, seed: int) -> Array:
    return np.random.default_rng([seed, 7]).uniform(0.02, 0.95, (count, vertices)).round(2)


CASES = {
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
MISTAKES = """
the whole sequence counts; yours looks at the last view only
    return -> return likelihoods[-1].copy(); return
all views count, not only the last two
    total = np.array -> likelihoods = likelihoods[-2:]; total = np.array
the latest view is the last row: the sequence begins with row 0
    total = np.array -> likelihoods = likelihoods[::-1]; total = np.array
the robot may also stay at its vertex from one view to the next
    np.maximum(total, come) -> come
the robot may also have come from the vertex before
    np.maximum(total, come) -> total
of staying and coming the better one counts, not their sum
    np.maximum(total, come) -> total + come
of staying and coming the better one counts, not their mean
    np.maximum(total, come) -> (total + come) / 2
a likelihood may be above 1; do not cut it off
    total = np.array -> likelihoods = np.minimum(likelihoods, 1.0); total = np.array
a tiny product is not 0
    look * best -> look * best * (look * best >= 1e-6)
do not divide by the greatest: sequences are compared by their own products
    look * best -> look * best / (look * best).max()
the robot comes from the vertex before alone, not from any vertex
    np.maximum(total, come) -> total.max()
of staying and coming the better one counts, not the worse
    np.maximum -> np.minimum
the T-th root: T views, not V vertices
    len(likelihoods) -> len(before)
likelihoods multiply; yours adds them
    look * best -> look + best
    total ** (1.0 / len(likelihoods)) -> total / len(likelihoods)
likelihoods multiply; yours takes the least
    look * best -> np.minimum(look, best)
    total ** (1.0 / len(likelihoods)) -> total
the robot comes from the vertex before, total[before], not from the one after
    np.where(before >= 0, total[before], 0.0)
        -> np.zeros(len(before) + 1); np.maximum.at(come, before, total); come = come[:-1]
-1 means that there is none; to numpy it is the last vertex
    np.where(before >= 0, total[before], 0.0) -> total[before]
vertex 0 exists; only -1 is none
    before >= 0 -> before > 0
the vertex before v is before[v], not v - 1
    np.where(before >= 0, total[before], 0.0) -> np.append(0.0, total[:-1])
where there is no vertex before, coming has the likelihood 0, not 1
    total[before], 0.0 -> total[before], 1.0
also where there is a vertex before, the robot may have stayed: take the better one
    np.maximum(total, come) -> np.where(before >= 0, come, total)
take the root once, of the whole product; yours takes the T-th root at every view
    look * best -> (look * best) ** (1.0 / len(likelihoods))
    total ** (1.0 / len(likelihoods)) -> total
take the root once, of the whole product; yours takes the T-th root at every view, from the first on
    dtype=float) -> dtype=float) ** (1.0 / len(likelihoods))
    look * best -> (look * best) ** (1.0 / len(likelihoods))
    total ** (1.0 / len(likelihoods)) -> total
take the root once, of the whole product; yours takes it at every view, and again in the end
    look * best -> (look * best) ** (1.0 / len(likelihoods))
take the root once, of the whole product; yours takes a square root at every view
    look * best -> (look * best) ** 0.5
    total ** (1.0 / len(likelihoods)) -> total
take the root once, of the whole product; yours takes one at every view, of the views so far
    for look in likelihoods[1:] -> for count, look in enumerate(likelihoods[1:], 2)
    look * best -> (look * best) ** (1.0 / count)
    total ** (1.0 / len(likelihoods)) -> total
every likelihood gets the T-th root, that of the first view as well
    look * best -> look ** (1.0 / len(likelihoods)) * best
    total ** (1.0 / len(likelihoods)) -> total
T views make a product of T likelihoods: the T-th root, not that of T - 1
    len(likelihoods) -> max(len(likelihoods) - 1, 1)
the T-th root of T likelihoods, ** (1 / T), not always the square root
    len(likelihoods) -> 2
take the T-th root, ** (1 / T), so that long sequences compare with short ones
    total ** (1.0 / len(likelihoods)) -> total
the geometric mean is the T-th root of the product, not the product divided by T
    total ** (1.0 / len(likelihoods)) -> total / len(likelihoods)
"""


def _broken(got: Array, want: Array, *_: Array) -> str:
    """Which part of the rule is broken at the worst vertex."""
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


check_match_sequence = exercise(
    match_sequence,
    CASES,
    MISTAKES,
    about="Two views and more, two trajectories, vertices in no order.",
    example=case(_looks(4, 60, 7), np.arange(60) - 1),
    calls=300,
    invoke=calling({ValueError: "each view is a row of V likelihoods, as many as `before` has"}),
    form=lambda what, got, looks, *_: numbers(what, got, looks.shape[1:]),
    same=partial(close, tolerance=1e-9),
    difference=farthest,
    broken=_broken,
)
