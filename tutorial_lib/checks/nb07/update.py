"""The check of the filter's update, in notebook 07."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import calling, numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close, compare, with_faults
from tutorial_lib.checks.nb07.small_differences import farthest, of_rounding
from tutorial_lib.checks.nb07.small_models import random_beliefs
from tutorial_lib.geometry import Array


def update(prior: Array, likelihood: Array) -> Array:
    """The belief (N, V + 1) after a look (Bayes' rule); see the exercise."""
    return _updated(prior, likelihood)


def _updated(prior: Array, likelihood: Array, fault: str = "") -> Array:
    """The update, with a `fault` if one is named."""
    if fault == "clipped":
        likelihood = np.minimum(likelihood, 1.0)
    weights = np.array(prior * likelihood, dtype=float)
    if fault == "sum":
        weights = prior + likelihood
    if fault == "likelihood":
        weights = np.array(likelihood, dtype=float)
    if fault == "squared":
        weights = prior**2 * likelihood
    if fault == "unnormalized":
        return weights
    nowhere = weights.sum(axis=1) <= (1e-6 if fault == "threshold" else 0.0)
    if fault == "some zero":
        nowhere = (weights == 0).any(axis=1)
    weights[nowhere] = 0.0
    if fault == "a little":
        weights[:, -1] += 1e-12
    if fault == "any":
        nowhere[:] = nowhere.any()
    if fault == "uniform":
        weights[nowhere] = 1.0
    elif fault == "prior kept":
        weights[nowhere] = prior[nowhere]
    elif fault == "first vertex":
        weights[nowhere, 0] = 1.0
    elif fault == "zeros":
        weights[nowhere] = 0.0
        return weights / np.where(nowhere, 1.0, weights.sum(axis=1))[:, None]
    elif fault != "divides":
        weights[nowhere, -1] = 1.0
    with np.errstate(all="ignore"):
        if fault == "all robots":
            return weights / weights.sum()
        if fault == "columns":
            return weights / weights.sum(axis=0)
        if fault == "greatest":
            return weights / weights.max(axis=1, keepdims=True)
        return weights / weights.sum(axis=1, keepdims=True)


_FAULTS = {
    "multiply the prior by the likelihood; yours adds them": "sum",
    "the prior counts as well: multiply it by the likelihood": "likelihood",
    "the prior counts once; yours counts it twice": "squared",
    "the products must sum to one again: divide each row by its sum": "unnormalized",
    "each robot's row sums to one by itself; yours divides by the sum of all robots": "all robots",
    "divide each row by its own sum, axis=1; yours divides the columns": "columns",
    "divide by the sum of the row, not by its greatest entry": "greatest",
    "where nothing is possible the row of products is all 0: the robot is off the map, its last "
    "state gets 1; yours spreads it evenly": "uniform",
    "where nothing is possible the robot is off the map; yours keeps the prior": "prior kept",
    "off the map is the last state, column -1, not the first": "first vertex",
    "where nothing is possible the robot is off the map; yours returns zeros": "zeros",
    "a sum may be tiny and not 0: something is possible then; compare with 0 itself": "threshold",
    "add nothing to the products: where all of them are tiny, it would count more than they do": (
        "a little"
    ),
    "one possible state is enough; the robot is off the map only where all products are 0": (
        "some zero"
    ),
    "the last state gets 1 only in the rows where nothing is possible; in yours in all rows": "any",
    "a likelihood may be above 1, only its ratios count; do not cut it off": "clipped",
    "where nothing is possible yours divides by 0; set the last state to 1 before": "divides",
}


def _case(robots: int, vertices: int, seed: int, share: float = 0.0) -> tuple[Array, Array]:
    rng = np.random.default_rng([seed, 5])
    likelihood = rng.uniform(0.05, 0.95, (robots, vertices + 1))
    return random_beliefs(robots, vertices, seed), likelihood * (rng.random((robots, 1)) >= share)


_CASES = {
    "one robot, two vertices": (np.array([[0.5, 0.5, 0.0]]), np.array([[0.9, 0.1, 0.2]])),
    "three robots": _case(3, 4, 1),
    "a flat likelihood": (random_beliefs(2, 4, 2), np.full((2, 5), 0.3)),
    "a robot for which nothing is possible": (
        np.array([[0.6, 0.4, 0.0], [0.2, 0.2, 0.6]]),
        np.array([[0.0, 0.0, 0.5], [0.5, 0.1, 0.1]]),
    ),
    "states that are not possible beside others that are": (
        np.array([[0.5, 0.3, 0.2], [0.0, 0.9, 0.1]]),
        np.array([[0.0, 0.4, 0.2], [0.5, 0.3, 0.0]]),
    ),
    "a view that is hardly possible anywhere": (
        np.array([[0.6, 0.4, 0.0], [0.2, 0.2, 0.6]]),
        np.array([[3e-20, 1e-20, 0.5], [0.5, 0.1, 0.1]]),
    ),
    "likelihoods above 1": (random_beliefs(2, 4, 5), _case(2, 4, 5)[1] * 6.0),
    "many vertices": _case(4, 12, 3),
    "several for which nothing is possible": _case(6, 4, 4, 0.5),
}


def _broken(got: Array, want: Array, prior: Array, likelihood: Array) -> str:
    """Which part of the rule is broken in the worst row."""
    if of_rounding(got, want):
        return ""
    row = int(np.nan_to_num(np.abs(got - want), nan=np.inf).max(axis=1).argmax())
    total = float((prior[row] * likelihood[row]).sum())
    if total == 0.0:
        return "where all products of a row are 0, all of the belief is in the last state"
    if total < 1e-12:
        return "something is possible, however little: divide by the sum, and add nothing to it"
    if not np.isclose(got[row].sum(), 1.0, atol=1e-9):
        return "each row must sum to one again: divide it by its own sum, axis=1"
    return (
        "each state, the last one as well, gets prior times likelihood over the sum of its row: "
        "no other function of them, and nothing added"
    )


@check(update, _case(4, 60, 6), calls=300)
def check_update(student: Callable[..., Any]) -> None:
    """One robot and several, a flat likelihood, and robots for which nothing is possible."""
    words = "prior and likelihood have the same shape; keepdims=True keeps a sum's second axis"
    compare(
        "update",
        student,
        _CASES,
        update,
        with_faults(_updated, _FAULTS),
        invoke=calling({ValueError: words}),
        form=lambda what, got, prior, *_: numbers(what, got, prior.shape),
        same=partial(close, tolerance=1e-9),
        difference=farthest,
        broken=_broken,
    )
