"""The check of combining policies, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, farthest, hint, numbers, topics
from tutorial_lib.geometry import Array

Policy = tuple[Array, Array, Array]
"""Jacobian (D, 2), acceleration (D,) and metric (D, D)."""


def resolve(policies: list[Policy]) -> NDArray[np.floating]:
    """(2,) accelerations of the controls that fit all policies best."""
    force, metric = np.zeros(2), np.zeros((2, 2))
    for j, a, m in policies:
        force = force + j.T @ m @ a
        metric = metric + j.T @ m @ j
    return np.linalg.solve(metric + 1e-6 * np.eye(2), force)


def _group(rng: np.random.Generator) -> list[Policy]:
    """Some random policies, and one that leaves no direction free."""
    policies = [_random(rng) for _ in range(rng.integers(1, 6))]
    policies.insert(int(rng.integers(0, len(policies) + 1)), _GOAL)
    return policies


def _random(rng: np.random.Generator) -> Policy:
    size = int(rng.integers(1, 4))
    root = rng.normal(size=(size, size))
    jacobian = rng.normal(size=(size, 2))
    return jacobian, rng.normal(size=size), root @ root.T + 0.1 * np.eye(size)


_RNG = np.random.default_rng(8)
_GOAL: Policy = (np.eye(2), np.array([2.0, 0.5]), np.eye(2))
_WALL: Policy = (np.array([[-0.5, 1.0]]), np.array([3.0]), np.array([[4.0]]))
_TURNED: Policy = (
    np.array([[1.0, -0.2], [0.5, 0.9]]),
    np.array([-1.0, 0.7]),
    np.array([[3.0, 0.5], [0.5, 0.2]]),
)
_SLOW: Policy = (np.eye(2), np.array([0.0, -1.0]), np.diag([1.0, 3.0]))
_STRONG: Policy = (np.array([[1.0, 0.0]]), np.ones(1), np.array([[1e4]]))
_WEAK: Policy = (np.array([[0.0, 1.0]]), np.ones(1), np.array([[0.01]]))
_FAINT: Policy = (np.eye(2), _GOAL[1], 1e-6 * np.eye(2))
_SPATIAL: Policy = (_RNG.normal(size=(3, 2)), _RNG.normal(size=3), np.diag([1.0, 0.5, 2.0]))
TOPICS = {
    "one policy alone that acts on the controls themselves": hint(
        "with J the identity its acceleration comes back as it is", ([_GOAL],)
    ),
    "one policy alone whose Jacobian is not the identity": hint(
        "force J^T M a, metric J^T M J, and then one np.linalg.solve", ([_TURNED],)
    ),
    "two policies that disagree": hint(
        "the result is their mean, weighted with the metrics: sum both, then solve once",
        ([_GOAL, _SLOW],),
        ([_SLOW, _GOAL],),
    ),
    "goal and wall": hint(
        "a wall has one row: J is (1, 2), a is (1,) and M is (1, 1); the same products hold",
        ([_GOAL, _WALL],),
        ([_WALL, _GOAL],),
    ),
    "a wall alone": hint(
        "no policy constrains one direction: add 1e-6 to the diagonal", ([_WALL],)
    ),
    "three policies": hint(
        "all of them count, in any order",
        ([_GOAL, _WALL, _TURNED],),
        ([_TURNED, _GOAL, _WALL],),
        ([_SPATIAL, _WALL, _GOAL],),
    ),
    "weak policies": hint(
        "what you add to the diagonal must be 1e-6: more of it slows weak policies down",
        ([(_GOAL[0], _GOAL[1], 0.01 * np.eye(2))],),
        ([_STRONG, _WEAK],),
    ),
    "a policy that wants much": hint(
        "limit nothing here: whoever calls this function limits speed and steering",
        ([(_GOAL[0], 20 * _GOAL[1], _GOAL[2]), _WALL],),
    ),
    "policies that weigh next to nothing": hint(
        "add 1e-6 to the diagonal of the sum, once; it halves what a policy of 1e-6 wants",
        ([_FAINT],),
        ([_FAINT, _FAINT, _FAINT],),
    ),
    "25 random groups of one to six policies": hint(
        "the simple cases are right; does a part of your rule hold for some policies only?",
        *((_group(_RNG),) for _ in range(25)),
    ),
    "no policy at all": hint(
        "nothing is wanted: begin with np.zeros(2) and 1e-6 * np.eye(2), and add to them", ([],)
    ),
}
MISTAKES = """
that is the force; the metric still has to be divided out: np.linalg.solve
    np.linalg.solve(metric + 1e-6 * np.eye(2), force) -> force
the force is multiplied by the metric; solve metric @ u = force instead
    np.linalg.solve(metric + 1e-6 * np.eye(2), force) -> metric @ force
the sign is wrong: solve metric @ u = force, without a minus
    return -> return -
sum the metrics of all policies; only the last one counts in yours
    metric = metric + -> metric = 0 +
sum the forces of all policies; only the last one counts in yours
    force = force + -> force = 0 +
what you add to the diagonal must be 1e-6; 1 slows every policy down
    1e-6 -> 1
sum over all policies; only the one with the largest metric counts in yours
    in policies: -> in sorted(policies, key=lambda policy: -np.trace(policy[2]))[:1]:
the diagonal of the metric is not enough; solve with the whole 2 x 2 matrix
    np.linalg.solve(metric + 1e-6 * np.eye(2), force) -> force / (np.diag(metric) + 1e-6)
the metrics do not count: put M between J^T and a, and between J^T and J
    j.T @ m @ a -> j.T @ a
    j.T @ m @ j -> j.T @ j
the force lacks the metric: J^T M a
    j.T @ m @ a -> j.T @ a
the metric of the controls is J^T M J, not J^T J
    j.T @ m @ j -> j.T @ j
the metric M counts twice; it stands once in the force and once in the metric
    j.T @ m @ a -> j.T @ m @ m @ a
    j.T @ m @ j -> j.T @ m @ m @ j
M is a whole matrix, not only its diagonal
    j.T @ m @ a -> j.T @ np.diag(np.diag(m)) @ a
    j.T @ m @ j -> j.T @ np.diag(np.diag(m)) @ j
add up forces and metrics first, then solve once; do not average what each policy wants
    np.linalg.solve(metric + 1e-6 * np.eye(2), force) -> force / max(len(policies), 1)
    j.T @ m @ a -> np.linalg.solve(j.T @ m @ j + 1e-6 * np.eye(2), j.T @ m @ a)
solve once, after the sums; do not add up what each policy wants
    np.linalg.solve(metric + 1e-6 * np.eye(2), force) -> force
    j.T @ m @ a -> np.linalg.solve(j.T @ m @ j + 1e-6 * np.eye(2), j.T @ m @ a)
the force is a sum, not a mean; do not divide it by the number of policies
    np.eye(2), force) -> np.eye(2), force) / max(len(policies), 1)
pull back with J: force J^T M a and metric J^T M J
    j.T @ m @ a -> m @ a
    j.T @ m @ j -> m
pull back the force with J too: J^T M a
    j.T @ m @ a -> m @ a
pull back the metric with J too: J^T M J
    j.T @ m @ j -> m
J and J^T are exchanged: force J^T M a and metric J^T M J
    j.T @ m @ a -> (j if len(j) == 2 else j.T) @ m @ a
    j.T @ m @ j -> (j @ m @ j.T if len(j) == 2 else j.T @ m @ j)
sum over all policies; only the last one counts in yours
    in policies: -> in policies[-1:]:
only the first one counts in yours; is the return inside the loop?
    in policies: -> in policies[:1]:
sum over all policies; only the first two count in yours
    in policies: -> in policies[:2]:
the first policy does not count in yours
    in policies: -> in policies[1:]:
the last policy does not count in yours
    in policies: -> in policies[:-1]:
policies of one row, such as those of obstacles, do not count in yours
    in policies: -> in [policy for policy in policies if len(policy[0]) > 1]:
1e-6 belongs to the diagonal only: 1e-6 * np.eye(2)
    np.eye(2) -> (np.ones((2, 2)) if policies else np.eye(2))
no policy constrains one direction: add 1e-6 to the diagonal
    metric + 1e-6 * np.eye(2) -> metric if policies else np.eye(2)
the 1e-6 is missing: add it to the diagonal in every case, and solve; no pseudo-inverse
    np.linalg.solve(metric + 1e-6 * np.eye(2), force) -> np.linalg.pinv(metric) @ force
1e-6 is added once, to the sum, not for each policy
    1e-6 -> max(len(policies), 1) * 1e-6
"""


def _invoke(what: str, student: Callable[..., Any], policies: list[Policy]) -> Any:  # noqa: ANN401
    """Call a student's function, and demand that it leaves list and arrays alone."""
    given = [tuple(part.copy() for part in policy) for policy in policies]
    answer = student(given)
    if len(given) != len(policies):
        raise WrongAnswer("your function changes the list of policies; only read it")
    pairs = zip(sum(policies, ()), sum(given, ()), strict=True)
    if not all(np.array_equal(old, new) for old, new in pairs):
        raise WrongAnswer("your function changes the policies; make new arrays")
    return answer


def _difference(got: Array, want: Array, *_: object) -> str:
    words, nearly = farthest(got, want), np.allclose(got, want, rtol=0.05, atol=0.0)
    return f"{words}; if you add to the diagonal, add 1e-6, no more" if nearly else words


check_resolve = exercise(
    resolve,
    topics(TOPICS),
    MISTAKES,
    about="One policy, some that agree, some that do not, and one that leaves a direction free.",
    example=case([_GOAL, _WALL, _TURNED] * 10),
    invoke=_invoke,
    form=lambda what, answer, policies: numbers(what, answer, (2,)),
    same=lambda got, want, *_: np.allclose(got, want, atol=2e-4, rtol=1e-4),
    difference=_difference,
)
