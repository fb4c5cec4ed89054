"""The check of the filter's update, in notebook 07."""

from functools import partial

import numpy as np

from tutorial_lib.checks.engine import calling, close, exercise, farthest, numbers
from tutorial_lib.checks.nb07.small_models import random_beliefs
from tutorial_lib.geometry import Array


def update(prior: Array, likelihood: Array) -> Array:
    """The belief (N, V + 1) after a look (Bayes' rule); see the exercise."""
    weights = prior * likelihood
    nowhere = weights.sum(axis=1) == 0.0
    weights[nowhere, -1] = 1.0
    return weights / weights.sum(axis=1, keepdims=True)


def _case(robots: int, vertices: int, seed: int, share: float = 0.0) -> tuple[Array, Array]:
    rng = np.random.default_rng([seed, 5])
    likelihood = rng.uniform(0.05, 0.95, (robots, vertices + 1))
    return random_beliefs(robots, vertices, seed), likelihood * (rng.random((robots, 1)) >= share)


CASES = {
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
    "a view that is possible nowhere but for 1e-30": (
        np.array([[0.6, 0.4, 0.0], [0.2, 0.2, 0.6]]),
        np.array([[3e-30, 1e-30, 0.5], [0.5, 0.1, 0.1]]),
    ),
    "likelihoods above 1": (random_beliefs(2, 4, 5), _case(2, 4, 5)[1] * 6.0),
    "many vertices": _case(4, 12, 3),
    "several for which nothing is possible": _case(6, 4, 4, 0.5),
}
MISTAKES = """
multiply the prior by the likelihood; yours adds them
    prior * likelihood -> prior + likelihood
the prior counts as well: multiply it by the likelihood
    prior * likelihood -> 1.0 * likelihood
the prior counts once; yours counts it twice
    prior * -> prior**2 *
the products must sum to one again: divide each row by its sum
    nowhere = weights -> return weights; nowhere = weights
each robot's row sums to one by itself; yours divides by the sum of all robots
    weights.sum(axis=1, keepdims=True) -> weights.sum()
divide each row by its own sum, axis=1; yours divides the columns
    weights.sum(axis=1, keepdims=True) -> weights.sum(axis=0)
divide by the sum of the row, not by its greatest entry
    weights.sum(axis=1, keepdims=True) -> weights.max(axis=1, keepdims=True)
where nothing is possible the row of products is all 0: the robot is off the map, its last state
gets 1; yours spreads it evenly
    weights[nowhere, -1] -> weights[nowhere]
where nothing is possible the robot is off the map; yours keeps the prior
    weights[nowhere, -1] = 1.0 -> weights[nowhere] = prior[nowhere]
off the map is the last state, column -1, not the first
    nowhere, -1] -> nowhere, 0]
where nothing is possible the robot is off the map; yours returns zeros
    weights[nowhere, -1] = 1.0 -> pass
    weights.sum(axis=1, keepdims=True) -> np.where(nowhere, 1.0, weights.sum(axis=1))[:, None]
a sum may be tiny and not 0: something is possible then; compare with 0 itself
    == 0.0 -> <= 1e-6
    weights[nowhere, -1] = 1.0 -> weights[nowhere] = np.eye(len(prior[0]))[-1]
add nothing to the products: where all of them are tiny, it would count more than they do
    weights[nowhere, -1] = 1.0 -> weights[:, -1] += 1e-12; weights[nowhere, -1] = 1.0
one possible state is enough; the robot is off the map only where all products are 0
    weights.sum(axis=1) == 0.0 -> (weights == 0).any(axis=1)
    weights[nowhere, -1] = 1.0 -> weights[nowhere] = np.eye(len(prior[0]))[-1]
the last state gets 1 only in the rows where nothing is possible; in yours in all rows
    weights.sum(axis=1) == 0.0 -> np.full(len(prior), (weights.sum(axis=1) == 0).any())
a likelihood may be above 1, only its ratios count; do not cut it off
    prior * likelihood -> prior * np.minimum(likelihood, 1.0)
where nothing is possible yours divides by 0; set the last state to 1 before
    weights[nowhere, -1] = 1.0 -> pass
"""


def _broken(got: Array, want: Array, prior: Array, likelihood: Array) -> str:
    """Which part of the rule is broken in the worst row."""
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


_SHAPES = "prior and likelihood have the same shape; keepdims=True keeps a sum's second axis"
check_update = exercise(
    update,
    CASES,
    MISTAKES,
    about="One robot and several, a flat likelihood, and robots for which nothing is possible.",
    example=_case(4, 60, 6),
    calls=300,
    invoke=calling({ValueError: _SHAPES}),
    form=lambda what, got, prior, *_: numbers(what, got, prior.shape),
    same=partial(close, tolerance=1e-9),
    difference=farthest,
    broken=_broken,
)
