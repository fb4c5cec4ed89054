"""Checks of notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, call, check, expect_close
from tutorial_lib.checks.nb02.waypoint_label import check_waypoint_label, clear_sight
from tutorial_lib.driving.control import rmp
from tutorial_lib.geometry import Array

__all__ = [
    "check_goal_policy",
    "check_obstacle_policy",
    "check_resolve",
    "check_split_first_layer",
    "check_waypoint_label",
    "clear_sight",
]

Policy = tuple[Array, Array, Array]
"""Jacobian (D, 2), acceleration (D,) and metric (D, D)."""

_DAMPING = 1e-6


def _two(what: str, answer: object) -> tuple[Any, Any]:
    """The two parts of what a policy gives."""
    if answer is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise WrongAnswer(f"{what}: return two things, the accelerations and the metrics")
    return answer[0], answer[1]


_GOAL_EXAMPLE = (np.ones((100, 2)), np.zeros((100, 2)), 2.4, 3.0, 0.35)


@check(rmp.goal_policy, _GOAL_EXAMPLE)
def check_goal_policy(student: Callable[..., Any]) -> None:
    """The pull to a goal, with damping, far and near, of one point and of many."""
    one = (np.array([0.3, -1.2]), np.array([0.2, 0.1]))
    many = (
        np.array([[2.0, 0.0], [0.0, -1.0], [0.05, 0.1], [1.0, 1.0]]),
        np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.4], [0.1, 0.2]]),
    )
    there = (np.zeros(2), np.array([0.1, 0.2]))
    gain, damping, near = 2.4, 3.0, 0.35
    cases = (("one point", one), ("four points", many), ("a point at its goal", there))
    for name, (offsets, velocities) in cases:
        want, metric = rmp.goal_policy(offsets, velocities, gain, damping, near)
        length = np.linalg.norm(offsets, axis=-1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            unit, drag = offsets / length, damping * velocities
        mistakes = {
            "the pull is as strong from far away as from nearby: divide the offset by its "
            "length": gain * offsets - drag,
            "damping works against the velocity: it needs a minus": want + 2 * drag,
            "the damping is missing: subtract damping * velocity": want + drag,
            "within `near` the pull fades: divide by the distance or by `near`, whichever is "
            "larger": gain * unit - drag,
            "each offset has its own length: np.linalg.norm(offsets, axis=-1, keepdims=True)": gain
            * offsets
            / max(np.linalg.norm(offsets), near)
            - drag,
            "far away the pull is a whole gain; it fades only within `near`": gain
            * offsets
            / (length + near)
            - drag,
        }
        with np.errstate(divide="ignore", invalid="ignore"):
            got = call(student, offsets, velocities, gain, damping, near)
        accelerations, metrics = _two("goal_policy", got)
        expect_close(f"accelerations of {name}", accelerations, want, 1e-6, mistakes)
        zeros = {"it cares equally for all directions: the identity, not zeros": 0 * metric}
        expect_close(f"metrics of {name}", metrics, metric, 1e-6, zeros)


_OBSTACLE_EXAMPLE = (np.linspace(0.05, 1, 100), np.zeros(100), 0.12, 0.12, 0.3, 0.08)


@check(rmp.obstacle_policy, _OBSTACLE_EXAMPLE)
def check_obstacle_policy(student: Callable[..., Any]) -> None:
    """The push off an obstacle: near and far, closing and receding, and at contact."""
    gains = _, _, weight, fade = 0.12, 0.3, 0.4, 0.1
    cases = (
        ("closing in", [0.5, 0.2, 0.05], [0.4, 0.3, 0.1]),
        ("standing still", [0.5, 0.2, 0.05], [0.0, 0.0, 0.0]),
        ("receding", [0.5, 0.2, 0.05], [-0.4, -0.5, -0.1]),
        ("touching", [0.002, 0.0, -0.01], [0.0, 0.1, 0.0]),
    )
    for name, distances, closing in cases:
        distances, closing = np.array(distances), np.array(closing)
        want, metric = rmp.obstacle_policy(distances, closing, *gains)
        with np.errstate(divide="ignore", invalid="ignore"):
            got = call(student, distances, closing, *gains)
        away, metrics = _two("obstacle_policy", got)
        if np.isinf(np.asarray(away, dtype=float)).any():
            limited = np.shape(metrics) == metric.shape and np.allclose(metrics, metric)
            where = "in the acceleration too, not only in the metric" if limited else "in both"
            raise WrongAnswer(
                f"accelerations, {name}: infinite at contact; nearer than 0.01 m counts as "
                f"0.01 m, {where}"
            )
        mistakes = {"that is the metric: give the accelerations first": metric}
        mistakes |= _pushed(distances, closing, *gains[:2])
        expect_close(f"accelerations, {name}", away, want, 1e-6, mistakes)
        near = np.maximum(distances, 0.01)
        more = {
            "the metric fades with distance: exp(-distance / fade)": np.full(3, weight),
            "the metric has to fall with distance: the exponent is negative": weight
            * np.exp(near / fade),
            "`fade` is a length: divide the distance by it": weight * np.exp(-near * fade),
            "multiply by `weight`, the metric at contact": np.exp(-near / fade),
            "nearer than 0.01 m counts as 0.01 m in the metric too, not only in the "
            "acceleration": weight * np.exp(-distances / fade),
        }
        expect_close(f"metrics, {name}", metrics, metric, 1e-6, more)


def _pushed(distances: Array, closing: Array, push: float, brake: float) -> dict[str, Array]:
    """Known mistakes, and the accelerations they give."""
    near, shrinking = np.maximum(distances, 0.01), np.maximum(closing, 0)
    right, both = push + brake * shrinking, push + brake * closing
    return {
        "what recedes is only pushed: its closing speed counts as 0": both / near,
        "what recedes is not braked: np.maximum(closing, 0), not the absolute value": (
            push + brake * np.abs(closing)
        )
        / near,
        "what recedes is still pushed: limit the closing speed from below, not the sum": np.maximum(
            both, 0
        )
        / near,
        "it makes the distance grow: positive": -right / near,
        "the push and the brake are both divided by the distance": push / near + brake * shrinking,
        "divide both terms by the distance, the push as well": push + brake * shrinking / near,
        "divide by the distance: near obstacles push harder": right,
        "whoever closes in is braked on top of the push": push / near,
        "nearer than 0.01 m counts as 0.01 m, in the acceleration too": right
        / np.where(distances == 0, np.nan, distances),
    }


def resolve(policies: list[Policy]) -> Array:
    """(2,) accelerations of the controls that suit all policies best, by the library."""
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
        mistakes, want = _unresolved(policies), resolve(policies)
        if free and isinstance(got, np.ndarray) and got.shape == (2,):
            fits = np.allclose(metric @ got, force, atol=1e-3) or not np.isfinite(got).all()
            mistakes |= {_FREE: got} if fits else {}
        expect_close(f"resolve, {name}", got, want, 1e-4, mistakes)


_FREE = "nobody cares for one direction: add 1e-6 to the diagonal"
_ONCE = "solve once, after the sums: one policy alone may leave a direction free"


def _sums(policies: list[Policy]) -> tuple[Array, Array]:
    """Force (2,) and metric (2, 2) of all policies."""
    return sum(j.T @ m @ a for j, a, m in policies), sum(j.T @ m @ j for j, _, m in policies)


def _unresolved(policies: list[Policy]) -> dict[str, Array]:
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
        "add up what all policies ask for; only the last one counts": alone[-1],
        "only the first one counts; is the return inside the loop?": alone[0],
        "the metric of the controls is J^T M J, not J^T J": np.linalg.solve(
            sum(j.T @ j for j, _, _ in policies) + small, force
        ),
    }


def split_first_layer(weights: Array) -> tuple[Array, Array]:
    """The part of weights (F, 9, H, W) that applies to cur and to tgt, each (F, 3, H, W)."""
    own, other, difference = np.split(weights, 3, axis=1)
    return own + difference, other - difference


@check(split_first_layer, (np.ones((48, 9, 16, 5)),))
def check_split_first_layer(student: Callable[..., Any]) -> None:
    """Random weights of the first layer: shapes, then each half."""
    weights = np.random.default_rng(2).normal(size=(4, 9, 3, 5))
    a, b, d = np.split(weights, 3, axis=1)
    answer = call(student, weights)
    if answer is None:
        raise WrongAnswer("split_first_layer: your function returned nothing; is a return missing?")
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise WrongAnswer("split_first_layer: return two arrays, for cur and for tgt")
    forgot = "the third part sees cur - tgt, so both pictures: it belongs to both halves"
    mixed = "the channels are stacked: 0 to 2 are cur's, 3 to 5 tgt's, 6 to 8 the difference's"
    thirds = weights[:, 0::3] + weights[:, 2::3]
    first = {forgot: a, "that is the part of tgt; cur comes first": b - d, mixed: thirds}
    first |= {"cur enters the difference with a plus": a - d}
    second = {
        "tgt enters the difference with a minus": b + d,
        "tgt has the weights B of its own as well; only D is turned round": -d,
        "D, not B, changes its sign": d - b,
        forgot: b,
    }
    expect_close("weights for cur", answer[0], a + d, 1e-9, first)
    expect_close("weights for tgt", answer[1], b - d, 1e-9, second)
