"""The check of combining policies, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.driving.control import rmp
from tutorial_lib.geometry import Array

Policy = tuple[Array, Array, Array]
"""Jacobian (D, 2), acceleration (D,) and metric (D, D)."""


_DAMPING = 1e-6


def resolve(policies: list[Policy]) -> Array:
    """(2,) accelerations of the controls that fit all policies best, by the library."""
    force, metric = np.zeros(2), np.zeros((2, 2))
    for policy in policies:
        more = rmp.pull_back(*policy)
        force, metric = force + more[0], metric + more[1]
    return rmp.resolve(force, metric, _DAMPING)


_GOAL: Policy = (np.eye(2), np.array([2.0, 0.5]), np.eye(2))


_WALL: Policy = (np.array([[-0.5, 1.0]]), np.array([3.0]), np.array([[4.0]]))


_TURNED: Policy = (
    np.array([[1.0, -0.2], [0.5, 0.9]]),
    np.array([-1.0, 0.7]),
    np.array([[3.0, 0.5], [0.5, 0.2]]),
)


@check(resolve, ([_GOAL, _WALL, _TURNED] * 10,))
def check_resolve(student: Callable[..., Any]) -> None:
    """One policy, two that agree, two that do not, and one that leaves a direction free."""
    cases = (
        ("one policy alone", [_GOAL]),
        ("goal and wall", [_GOAL, _WALL]),
        ("three policies", [_GOAL, _WALL, _TURNED]),
        ("a wall alone", [_WALL]),
    )
    for name, policies in cases:
        kept = [tuple(part.copy() for part in policy) for policy in policies]
        force, metric = _sums(policies)
        free = np.linalg.matrix_rank(metric) < 2
        try:
            with np.errstate(all="ignore"):
                got = student(policies)
        except np.linalg.LinAlgError:
            raise WrongAnswer(f"resolve, {name}: {_FREE if free else _ONCE}") from None
        before, after = ([part for policy in ps for part in policy] for ps in (kept, policies))
        if not all(np.array_equal(a, b) for a, b in zip(before, after, strict=True)):
            raise WrongAnswer("your function changes the policies; make new arrays")
        mistakes, want = _mistakes(policies), resolve(policies)
        if free and isinstance(got, np.ndarray) and got.shape == (2,):
            fits = np.allclose(metric @ got, force, atol=1e-3) or not np.isfinite(got).all()
            mistakes |= {_FREE: got} if fits else {}
        expect_close(f"resolve, {name}", got, want, 1e-4, mistakes)


_FREE = "no policy constrains one direction: add 1e-6 to the diagonal"


_ONCE = "solve once, after the sums: one policy alone may leave a direction free"


def _sums(policies: list[Policy]) -> tuple[Array, Array]:
    """Force (2,) and metric (2, 2) of all policies."""
    return sum(j.T @ m @ a for j, a, m in policies), sum(j.T @ m @ j for j, _, m in policies)


def _mistakes(policies: list[Policy]) -> dict[str, Array]:
    """Known mistakes, and the answers they give."""
    force, metric = _sums(policies)
    small = _DAMPING * np.eye(2)
    flat = sum(np.zeros(2) + m @ a for _, a, m in policies), sum(small + m for *_, m in policies)
    alone = [resolve([policy]) for policy in policies]
    return {
        "that is the force; the metric still has to be divided out: np.linalg.solve": force,
        "the metrics do not count: put M between J^T and a, and between J^T and J": resolve(
            [(j, a, np.eye(len(a))) for j, a, _ in policies]
        ),
        "the force lacks the metric: J^T M a": np.linalg.solve(
            metric + small, sum(j.T @ a for j, a, _ in policies)
        ),
        "add up forces and metrics first, then solve once; do not average what each policy "
        "wants": np.mean(alone, axis=0),
        "solve once, after the sums; do not add up what each policy wants": np.sum(alone, axis=0),
        "the force is a sum, not a mean; do not divide it by the number of policies": resolve(
            policies
        )
        / len(policies),
        "pull back with J: force J^T M a and metric J^T M J": np.linalg.solve(
            flat[1] + small, flat[0]
        ),
        "pull back the force with J too: J^T M a": np.linalg.solve(metric + small, flat[0]),
        "pull back the metric with J too: J^T M J": np.linalg.solve(flat[1] + small, force),
        "sum over all policies; only the last one counts in yours": alone[-1],
        "only the first one counts in yours; is the return inside the loop?": alone[0],
        "the metric of the controls is J^T M J, not J^T J": np.linalg.solve(
            sum(j.T @ j for j, _, _ in policies) + small, force
        ),
    }
