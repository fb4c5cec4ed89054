"""The check of the pull to a goal, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.checks.nb02.policy_parts import Policies, differing, policies_of, same_policies
from tutorial_lib.driving.control import rmp
from tutorial_lib.geometry import Array

_EXAMPLE = (np.ones((100, 2)), np.zeros((100, 2)), 2.4, 3.0, 0.35)
Pull = Callable[[Array, Array, Array, float, float, float], Array]


def _accelerating(rule: Pull) -> Callable[..., Policies]:
    """The right metrics with a rule (offsets, lengths, velocities, gain, damping, near)."""

    def fault(offsets: Array, velocities: Array, *gains: float) -> Policies:
        length = np.linalg.norm(offsets, axis=-1, keepdims=True)
        return rule(offsets, length, velocities, *gains), _identities(offsets)

    return fault


def _weighing(metrics: Callable[..., Array]) -> Callable[..., Policies]:
    """The right accelerations with other metrics (offsets, gain, damping)."""
    return lambda offsets, velocities, gain, damping, near: (
        rmp.goal_policy(offsets, velocities, gain, damping, near)[0],
        metrics(offsets, gain, damping),
    )


def _identities(offsets: Array) -> Array:
    return np.broadcast_to(np.eye(2), (*np.shape(offsets), 2))


_FAULTS = {
    "the pull is as strong from far away as from nearby: divide the offset by its length": (
        _accelerating(lambda o, d, v, gain, damping, near: gain * o - damping * v)
    ),
    "damping works against the velocity: it needs a minus": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * o / np.maximum(d, near) + damping * v
        )
    ),
    "the gain multiplies the pull, the damping the velocity; yours exchanges them": (
        _accelerating(
            lambda o, d, v, gain, damping, near: damping * o / np.maximum(d, near) - gain * v
        )
    ),
    "only the pull is divided by the length; the velocity is damped as it is": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (gain * o - damping * v) / np.maximum(d, near)
        )
    ),
    "the damping works against the velocity with its sign, not against its size": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(d, near) - damping * np.abs(v)
            )
        )
    ),
    "the damping is missing: subtract damping * velocity": (
        _accelerating(lambda o, d, v, gain, damping, near: gain * o / np.maximum(d, near))
    ),
    "only the pull is multiplied by the gain, only the velocity by the damping": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (gain - damping) * o / np.maximum(d, near) - v
        )
    ),
    "the damping does not belong inside the pull: the gain multiplies the pull alone": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * (o / np.maximum(d, near) - damping * v)
        )
    ),
    "the velocity is multiplied by the damping, not divided by it": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * o / np.maximum(d, near) - v / damping
        )
    ),
    "the damping grows with the velocity itself, not with its square": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(d, near)
                - damping * v * np.linalg.norm(v, axis=-1, keepdims=True)
            )
        )
    ),
    "divide by the larger of length and `near`; far away `near` must not matter": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * o / np.sqrt(d**2 + near**2) - damping * v
        )
    ),
    "the damping acts everywhere, not only within `near`": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(d, near) - damping * v * (d < near)
            )
        )
    ),
    "the damping acts everywhere, not only farther away than `near`": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(d, near) - damping * v * (d >= near)
            )
        )
    ),
    "the damping works against the whole velocity, not only along the way to the goal": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                (gain - damping * np.linalg.norm(v, axis=-1, keepdims=True))
                * o
                / np.maximum(d, near)
            )
        )
    ),
    "within `near` the pull is gain * offset / near; it is not divided by `near`": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * np.where(d < near, o, _unit(o, d)) - damping * v
            )
        )
    ),
    "the damping works against the whole velocity, also sideways, not only along the offset": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(d, near)
                - damping * (v * o).sum(axis=-1, keepdims=True) * o / np.maximum(d, near) ** 2
            )
        )
    ),
    "the velocity is damped component by component, not its length": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(d, near) - damping * np.linalg.norm(v, axis=-1, keepdims=True)
            )
        )
    ),
    "it pushes away from the goal: the offset runs from the point to its goal, so it has a plus": (
        _accelerating(
            lambda o, d, v, gain, damping, near: -gain * o / np.maximum(d, near) - damping * v
        )
    ),
    "within `near` the pull fades: divide by the distance or by `near`, whichever is larger": (
        _accelerating(lambda o, d, v, gain, damping, near: gain * _unit(o, d) - damping * v)
    ),
    "divide by the larger of distance and `near`, not by the smaller": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * o / np.minimum(d, near) - damping * v
        )
    ),
    "within `near` the pull fades evenly; it does not stop at once": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * _unit(o, d) * (d >= near) - damping * v
        )
    ),
    "far away the pull is a whole gain; it fades only within `near`": (
        _accelerating(lambda o, d, v, gain, damping, near: gain * o / (d + near) - damping * v)
    ),
    "each offset has its own length: np.linalg.norm(offsets, axis=-1, keepdims=True)": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / max(np.linalg.norm(o), near) - damping * v
            )
        )
    ),
    "divide by the length of the offset, not by the sum of its components": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(np.abs(o).sum(axis=-1, keepdims=True), near) - damping * v
            )
        )
    ),
    "divide by the length of the offset, not by its square": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * o / np.maximum(d**2, near) - damping * v
        )
    ),
    "divide by the larger of the length and `near` itself, not by the square of that": (
        _accelerating(
            lambda o, d, v, gain, damping, near: gain * o / np.maximum(d, near) ** 2 - damping * v
        )
    ),
    "divide by the length of the offset, not by the larger of its two components": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(np.abs(o).max(axis=-1, keepdims=True), near) - damping * v
            )
        )
    ),
    "x and y share one length; do not divide each by its own size": (
        _accelerating(
            lambda o, d, v, gain, damping, near: (
                gain * o / np.maximum(np.abs(o), near) - damping * v
            )
        )
    ),
    "the metric weighs all directions equally: the identity, not zeros": _weighing(
        lambda o, gain, damping: 0 * _identities(o)
    ),
    "the metric is the identity itself; the gain does not belong in it": _weighing(
        lambda o, gain, damping: gain * _identities(o)
    ),
    "the metric is the identity itself; the damping does not belong in it": _weighing(
        lambda o, gain, damping: damping * _identities(o)
    ),
    "the metric weighs all directions equally, not only the one to the goal": _weighing(
        lambda o, gain, damping: (
            _unit(o, np.linalg.norm(o, axis=-1, keepdims=True))[..., None]
            * _unit(o, np.linalg.norm(o, axis=-1, keepdims=True))[..., None, :]
        )
    ),
    "the metric is the identity: ones on the diagonal only": _weighing(
        lambda o, gain, damping: np.ones((*np.shape(o), 2))
    ),
}


def _unit(offsets: Array, length: Array) -> Array:
    return np.divide(offsets, length, out=np.zeros(np.shape(offsets)), where=length > 0)


def _topics() -> list[Topic]:
    rng = np.random.default_rng(6)
    still, many = np.zeros(2), rng.uniform(-3, 3, (4, 2))
    usual = (2.4, 3.0, 0.35)
    shapes = [(2,), (5, 2), (1, 2), (2, 3, 2)]
    random = [
        (
            rng.uniform(-2, 2, shapes[i % 4]),
            rng.uniform(-1, 1, shapes[i % 4]),
            *(float(g) for g in rng.uniform([0.5, 0.5, 0.1], [4.0, 5.0, 1.5])),
        )
        for i in range(24)
    ]
    return [
        Topic(
            "one point at rest, far from its goal",
            "the offset divided by its length, times the gain; the metric is the 2 x 2 identity. "
            "One point has the shape (2,): use axis=-1",
            [(np.array([3.0, 0.0]), still, *usual), (np.array([0.3, -1.2]), still, *usual)],
        ),
        Topic(
            "one point that moves",
            "subtract the damping times the velocity, component by component",
            [(np.array([0.3, -1.2]), np.array([0.2, 0.1]), *usual)],
        ),
        Topic(
            "several points at once",
            "each row has a length and a metric of its own: axis=-1 and keepdims=True",
            [(many, rng.uniform(-1, 1, (4, 2)), *usual)],
        ),
        Topic(
            "points within `near` of their goals",
            "nearer than `near`, divide by `near`: the pull fades evenly, and is nothing at 0 only",
            [
                (np.array([[0.05, 0.1], [-0.2, 0.0], [0.0, 0.34]]), np.zeros((3, 2)), *usual),
                (np.array([[0.02, 0.01], [0.0, -0.004]]), np.zeros((2, 2)), *usual),
            ],
        ),
        Topic(
            "a point at its goal",
            "there the offset is 0: dividing by the larger of length and `near` gives no pull",
            [(np.zeros(2), np.array([0.1, 0.2]), *usual)],
        ),
        Topic(
            "another gain",
            "the gain is an argument; use it, and no number in its place",
            [(many, 0.1 * many, gain, 3.0, 0.35) for gain in (0.6, 1.0, 3.6)],
        ),
        Topic(
            "another damping",
            "the damping is an argument; use it, and no number in its place",
            [
                (many * scale, 0.1 * many, 2.4, damping, 0.35)
                for scale in (1.0, 0.02)
                for damping in (0.5, 1.0, 5.0)
            ],
        ),
        Topic(
            "another `near`",
            "`near` is an argument; use it, and no number in its place",
            [(many, 0.1 * many, 2.4, 3.0, near) for near in (1.5, 2.5, 0.01)],
        ),
        Topic(
            "24 random groups of points, also a grid (2, 3, 2)",
            "the simple cases are right; work on the last axis, whatever comes before it",
            random,
        ),
    ]


@check(rmp.goal_policy, _EXAMPLE)
def check_goal_policy(student: Callable[..., Any]) -> None:
    """The pull to a goal, with damping, far and near, of one point and of many."""
    with np.errstate(all="ignore"):
        judge_topics(
            "goal_policy",
            student,
            _topics(),
            rmp.goal_policy,
            _FAULTS,
            form=_form,
            same=same_policies,
            difference=differing,
        )


def _form(what: str, answer: object, offsets: Array, *_: object) -> Policies:
    return policies_of(what, answer, offsets.shape, (*offsets.shape, 2))
