"""The check of combining policies, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import farthest
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.driving.control import rmp
from tutorial_lib.geometry import Array

Policy = tuple[Array, Array, Array]
"""Jacobian (D, 2), acceleration (D,) and metric (D, D)."""
Pieces = Callable[[Array, Array, Array], Array]

_DAMPING = 1e-6
_DIAGONAL = _DAMPING * np.eye(2)
_GOAL: Policy = (np.eye(2), np.array([2.0, 0.5]), np.eye(2))
_WALL: Policy = (np.array([[-0.5, 1.0]]), np.array([3.0]), np.array([[4.0]]))
_TURNED: Policy = (
    np.array([[1.0, -0.2], [0.5, 0.9]]),
    np.array([-1.0, 0.7]),
    np.array([[3.0, 0.5], [0.5, 0.2]]),
)


def resolve(policies: list[Policy]) -> Array:
    """(2,) accelerations of the controls that fit all policies best, by the library."""
    force, metric = np.zeros(2), np.zeros((2, 2))
    for policy in policies:
        more = rmp.pull_back(*policy)
        force, metric = force + more[0], metric + more[1]
    return rmp.resolve(force, metric, _DAMPING)


def _with(
    force: Pieces = lambda j, a, m: j.T @ m @ a,
    metric: Pieces = lambda j, a, m: j.T @ m @ j,
    damping: Array = _DIAGONAL,
) -> Callable[[list[Policy]], Array]:
    """The rule with other pieces."""

    def rule(policies: list[Policy]) -> Array:
        forces = sum((force(*p) for p in policies), np.zeros(2))
        return np.linalg.solve(sum((metric(*p) for p in policies), damping), forces)

    return rule


def _sums(policies: list[Policy]) -> tuple[Array, Array]:
    """Force (2,) and metric (2, 2) of all policies."""
    return sum(j.T @ m @ a for j, a, m in policies), sum(j.T @ m @ j for j, _, m in policies)


def _alone(policies: list[Policy]) -> Array:
    return np.array([resolve([policy]) for policy in policies])


def _by_diagonal(policies: list[Policy]) -> Array:
    force, metric = _sums(policies)
    return force / (np.diag(metric) + _DAMPING)


_FAULTS = {
    "that is the force; the metric still has to be divided out: np.linalg.solve": (
        lambda policies: _sums(policies)[0]
    ),
    "the force is multiplied by the metric; solve metric @ u = force instead": (
        lambda policies: _sums(policies)[1] @ _sums(policies)[0]
    ),
    "the sign is wrong: solve metric @ u = force, without a minus": (
        lambda policies: -resolve(policies)
    ),
    "sum the metrics of all policies; only the last one counts in yours": (
        lambda policies: np.linalg.solve(_sums(policies[-1:])[1] + _DIAGONAL, _sums(policies)[0])
    ),
    "sum the forces of all policies; only the last one counts in yours": (
        lambda policies: np.linalg.solve(_sums(policies)[1] + _DIAGONAL, _sums(policies[-1:])[0])
    ),
    "what you add to the diagonal must be 1e-6; 1 slows every policy down": _with(
        damping=np.eye(2)
    ),
    "sum over all policies; only the one with the largest metric counts in yours": (
        lambda policies: resolve([max(policies, key=lambda p: np.trace(p[2]))])
    ),
    "the diagonal of the metric is not enough; solve with the whole 2 x 2 matrix": _by_diagonal,
    "the metrics do not count: put M between J^T and a, and between J^T and J": _with(
        lambda j, a, m: j.T @ a, lambda j, a, m: j.T @ j
    ),
    "the force lacks the metric: J^T M a": _with(force=lambda j, a, m: j.T @ a),
    "the metric of the controls is J^T M J, not J^T J": _with(metric=lambda j, a, m: j.T @ j),
    "the metric M counts twice; it stands once in the force and once in the metric": _with(
        lambda j, a, m: j.T @ m @ m @ a, lambda j, a, m: j.T @ m @ m @ j
    ),
    "M is a whole matrix, not only its diagonal": _with(
        lambda j, a, m: j.T @ np.diag(np.diag(m)) @ a,
        lambda j, a, m: j.T @ np.diag(np.diag(m)) @ j,
    ),
    "add up forces and metrics first, then solve once; do not average what each policy wants": (
        lambda policies: _alone(policies).mean(axis=0)
    ),
    "solve once, after the sums; do not add up what each policy wants": (
        lambda policies: _alone(policies).sum(axis=0)
    ),
    "the force is a sum, not a mean; do not divide it by the number of policies": (
        lambda policies: resolve(policies) / len(policies)
    ),
    "pull back with J: force J^T M a and metric J^T M J": _with(
        lambda j, a, m: m @ a, lambda j, a, m: m
    ),
    "pull back the force with J too: J^T M a": _with(force=lambda j, a, m: m @ a),
    "pull back the metric with J too: J^T M J": _with(metric=lambda j, a, m: m),
    "J and J^T are exchanged: force J^T M a and metric J^T M J": _with(
        lambda j, a, m: j @ m @ a if len(j) == 2 else j.T @ m @ a,
        lambda j, a, m: j @ m @ j.T if len(j) == 2 else j.T @ m @ j,
    ),
    "sum over all policies; only the last one counts in yours": (
        lambda policies: resolve(policies[-1:])
    ),
    "only the first one counts in yours; is the return inside the loop?": (
        lambda policies: resolve(policies[:1])
    ),
    "sum over all policies; only the first two count in yours": (
        lambda policies: resolve(policies[:2])
    ),
    "the first policy does not count in yours": lambda policies: resolve(policies[1:]),
    "the last policy does not count in yours": lambda policies: resolve(policies[:-1]),
    "policies of one row, such as those of obstacles, do not count in yours": (
        lambda policies: resolve([p for p in policies if len(p[0]) > 1])
    ),
    "1e-6 belongs to the diagonal only: 1e-6 * np.eye(2)": _with(damping=np.full((2, 2), _DAMPING)),
    "no policy constrains one direction: add 1e-6 to the diagonal": (
        lambda policies: np.linalg.solve(*reversed(_sums(policies)))
    ),
    "a pseudo-inverse leaves out the 1e-6: add it to the diagonal, and solve": (
        lambda policies: np.linalg.pinv(_sums(policies)[1]) @ _sums(policies)[0]
    ),
    "1e-6 is added once, to the sum, not for each policy": (
        lambda policies: np.linalg.solve(
            _sums(policies)[1] + len(policies) * _DIAGONAL, _sums(policies)[0]
        )
    ),
}


def _unless_empty(fault: Callable[[list[Policy]], Array]) -> Callable[[list[Policy]], Array]:
    """A mistake that shows only where there are policies."""
    return lambda policies: fault(policies) if policies else np.zeros(2)


def _topics() -> list[Topic]:
    rng = np.random.default_rng(8)
    slow = (np.eye(2), np.array([0.0, -1.0]), np.diag([1.0, 3.0]))
    faint = (np.eye(2), _GOAL[1], _DIAGONAL)
    spatial = (rng.normal(size=(3, 2)), rng.normal(size=3), np.diag([1.0, 0.5, 2.0]))
    return [
        Topic(
            "one policy alone that acts on the controls themselves",
            "with J the identity its acceleration comes back as it is",
            [([_GOAL],)],
        ),
        Topic(
            "one policy alone whose Jacobian is not the identity",
            "force J^T M a, metric J^T M J, and then one np.linalg.solve",
            [([_TURNED],)],
        ),
        Topic(
            "two policies that disagree",
            "the result is their mean, weighted with the metrics: sum both, then solve once",
            [([_GOAL, slow],), ([slow, _GOAL],)],
        ),
        Topic(
            "goal and wall",
            "a wall has one row: J is (1, 2), a is (1,) and M is (1, 1); the same products hold",
            [([_GOAL, _WALL],), ([_WALL, _GOAL],)],
        ),
        Topic(
            "a wall alone",
            "no policy constrains one direction: add 1e-6 to the diagonal",
            [([_WALL],)],
        ),
        Topic(
            "three policies",
            "all of them count, in any order",
            [([_GOAL, _WALL, _TURNED],), ([_TURNED, _GOAL, _WALL],), ([spatial, _WALL, _GOAL],)],
        ),
        Topic(
            "weak policies",
            "what you add to the diagonal must be 1e-6: more of it slows weak policies down",
            [([(_GOAL[0], _GOAL[1], 0.01 * np.eye(2))],)],
        ),
        Topic(
            "a policy that wants much",
            "limit nothing here: whoever calls this function limits speed and steering",
            [([(_GOAL[0], 20 * _GOAL[1], _GOAL[2]), _WALL],)],
        ),
        Topic(
            "policies that weigh next to nothing",
            "add 1e-6 to the diagonal of the sum, once; it halves what a policy of 1e-6 wants",
            [([faint],), ([faint, faint, faint],)],
        ),
        Topic(
            "25 random groups of one to six policies",
            "the simple cases are right; does a part of your rule hold for some policies only?",
            [(_group(rng),) for _ in range(25)],
        ),
        Topic(
            "no policy at all",
            "nothing is wanted: begin with np.zeros(2) and 1e-6 * np.eye(2), and add to them",
            [([],)],
        ),
    ]


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


@check(resolve, ([_GOAL, _WALL, _TURNED] * 10,))
def check_resolve(student: Callable[..., Any]) -> None:
    """One policy, some that agree, some that do not, and one that leaves a direction free."""
    with np.errstate(all="ignore"):
        judge_topics(
            "resolve",
            student,
            _topics(),
            resolve,
            {words: _unless_empty(fault) for words, fault in _FAULTS.items()},
            form=lambda what, answer, policies: numbers(what, answer, (2,)),
            invoke=_invoke,
            same=_same,
            difference=_difference,
        )


def _invoke(student: Callable[..., Any], policies: list[Policy]) -> Any:  # noqa: ANN401
    """Call a student's function, and demand that it leaves list and arrays alone."""
    kept = [tuple(part.copy() for part in policy) for policy in policies]
    given = [tuple(part.copy() for part in policy) for policy in policies]
    answer = student(given)
    if len(given) != len(kept):
        raise WrongAnswer("your function changes the list of policies; only read it")
    pairs = zip(sum(kept, ()), sum(given, ()), strict=True)
    if not all(np.array_equal(old, new) for old, new in pairs):
        raise WrongAnswer("your function changes the policies; make new arrays")
    return answer


def _same(got: Array, want: Array, policies: list[Policy]) -> bool:
    return bool(np.allclose(got, want, atol=2e-4, rtol=1e-4))


def _difference(got: Array, want: Array, *_: object) -> str:
    nearly = "; if you add to the diagonal, add 1e-6, no more"
    close_by = np.allclose(got, want, rtol=0.05, atol=0.0)
    return farthest(got, want) + (nearly if close_by else "")
