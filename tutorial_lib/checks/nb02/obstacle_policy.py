"""The check of the push off obstacles, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.checks.nb02.policy_parts import Policies, differing, policies_of, same_policies
from tutorial_lib.driving.control import rmp
from tutorial_lib.geometry import Array

_EXAMPLE = (np.linspace(0.05, 1, 100), np.zeros(100), 0.12, 0.12, 0.3, 0.08)
_CONTACT = 0.01


def _accelerating(rule: Callable[..., Array]) -> Callable[..., Policies]:
    """The right metrics with a rule (distances, limited distances, closing, push, brake)."""
    return lambda distances, closing, push, brake, weight, fade: (
        rule(distances, np.maximum(distances, _CONTACT), closing, push, brake),
        rmp.obstacle_policy(distances, closing, push, brake, weight, fade)[1],
    )


def _weighing(rule: Callable[..., Array]) -> Callable[..., Policies]:
    """The right accelerations with metrics (distances, limited distances, weight, fade)."""
    return lambda distances, closing, push, brake, weight, fade: (
        rmp.obstacle_policy(distances, closing, push, brake, weight, fade)[0],
        rule(distances, np.maximum(distances, _CONTACT), weight, fade),
    )


def _unlimited(
    distances: Array, closing: Array, push: float, brake: float, *rest: float
) -> Policies:
    weight, fade = rest
    return (
        (push + brake * np.maximum(closing, 0)) / distances,
        weight * np.exp(-distances / fade),
    )


def _absolute(distances: Array, *rest: Any) -> Policies:  # noqa: ANN401
    return rmp.obstacle_policy(np.abs(distances), *rest)


def _exchanged(*case: Any) -> Policies:  # noqa: ANN401
    return rmp.obstacle_policy(*case)[::-1]


_FAULTS = {
    "the two are exchanged: give the accelerations first": _exchanged,
    "infinite or negative at contact: nearer than 0.01 m counts as 0.01 m, in both": _unlimited,
    "nearer than 0.01 m counts as 0.01 m in the acceleration too, not only in the metric": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * np.maximum(c, 0)) / d)
    ),
    "nearer than 0.01 m counts as 0.01 m in the metric too, not only in the acceleration": (
        _weighing(lambda d, near, weight, fade: weight * np.exp(-d / fade))
    ),
    "a negative distance is nearer than 0.01 m too: np.maximum, not the absolute value": _absolute,
    "0.01 m is the smallest distance; it is not added to every distance": (
        lambda d, *rest: _unlimited(d + _CONTACT, *rest)
    ),
    "0.01 m is the smallest distance; it is not added, also not to those above 0": (
        lambda d, *rest: _unlimited(np.maximum(d, 0) + _CONTACT, *rest)
    ),
    "the smallest distance is 0.01 m, 1 cm, not 2 cm": (
        lambda d, *rest: _unlimited(np.maximum(d, 0.02), *rest)
    ),
    "the smallest distance is 0.01 m, 1 cm, not 5 cm": (
        lambda d, *rest: _unlimited(np.maximum(d, 0.05), *rest)
    ),
    "a receding obstacle only pushes: its closing speed counts as 0": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * c) / near)
    ),
    "no brake for a receding obstacle: np.maximum(closing, 0), not the absolute value": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * np.abs(c)) / near)
    ),
    "the brake acts while the distance shrinks (closing > 0), not while it grows": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * np.maximum(-c, 0)) / near)
    ),
    "a receding obstacle still pushes: limit the closing speed from below, not the sum": (
        _accelerating(lambda d, near, c, push, brake: np.maximum(push + brake * c, 0) / near)
    ),
    "an obstacle pushes even if it does not come nearer: only the brake depends on closing": (
        _accelerating(lambda d, near, c, push, brake: np.where(c > 0, push + brake * c, 0) / near)
    ),
    "it makes the distance grow: positive": (
        _accelerating(lambda d, near, c, push, brake: -(push + brake * np.maximum(c, 0)) / near)
    ),
    "the push and the brake are both divided by the distance": (
        _accelerating(lambda d, near, c, push, brake: push / near + brake * np.maximum(c, 0))
    ),
    "divide both terms by the distance, the push as well": (
        _accelerating(lambda d, near, c, push, brake: push + brake * np.maximum(c, 0) / near)
    ),
    "divide by the distance: near obstacles push harder": (
        _accelerating(lambda d, near, c, push, brake: push + brake * np.maximum(c, 0))
    ),
    "multiplied by the distance; divide: near obstacles push harder": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * np.maximum(c, 0)) * near)
    ),
    "divide by the distance itself, not by its square": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * np.maximum(c, 0)) / near**2)
    ),
    "while closing in, the brake comes on top of the push": (
        _accelerating(lambda d, near, c, push, brake: push / near)
    ),
    "the brake is missing its own factor: it is brake, not push, that multiplies closing": (
        _accelerating(lambda d, near, c, push, brake: push * (1 + np.maximum(c, 0)) / near)
    ),
    "each obstacle has its own distance; do not use the nearest for all": (
        _accelerating(
            lambda d, near, c, push, brake: (push + brake * np.maximum(c, 0)) / near.min()
        )
    ),
    "each obstacle has its own distance; do not use the nearest one's for all": (
        lambda d, *rest: rmp.obstacle_policy(np.full(d.shape, d.min()), *rest)
    ),
    "`push` and `brake` are exchanged: it is the brake that multiplies closing": (
        _accelerating(lambda d, near, c, push, brake: (brake + push * np.maximum(c, 0)) / near)
    ),
    "the brake multiplies the closing speed itself, not its square": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * np.maximum(c, 0) ** 2) / near)
    ),
    "the smallest distance is 0.01 m, 1 cm, not 1 mm": (
        lambda d, *rest: _unlimited(np.maximum(d, 0.001), *rest)
    ),
    "the smallest distance is 0.01 m, 1 cm, not 10 cm": (
        lambda d, *rest: _unlimited(np.maximum(d, 0.1), *rest)
    ),
    "limit the distances from below: np.maximum(distances, 0.01), not np.minimum": (
        lambda d, *rest: _unlimited(np.minimum(d, _CONTACT), *rest)
    ),
    "the acceleration is not weighted with the metric here; `resolve` does that": (
        lambda *case: (
            np.multiply(*rmp.obstacle_policy(*case)),
            rmp.obstacle_policy(*case)[1],
        )
    ),
    "each obstacle has its own closing speed; do not use the largest for all": (
        _accelerating(lambda d, near, c, push, brake: (push + brake * max(c.max(), 0)) / near)
    ),
    "every obstacle has its weight, not only the nearest one": (
        _weighing(
            lambda d, near, weight, fade: np.where(d == d.min(), weight * np.exp(-near / fade), 0)
        )
    ),
    "the metric fades with distance: exp(-distance / fade)": (
        _weighing(lambda d, near, weight, fade: np.full(near.shape, weight))
    ),
    "the metric has to fall with distance: the exponent is negative": (
        _weighing(lambda d, near, weight, fade: weight * np.exp(near / fade))
    ),
    "`fade` is a length: divide the distance by it": (
        _weighing(lambda d, near, weight, fade: weight * np.exp(-near * fade))
    ),
    "multiply by `weight`, the metric at contact": (
        _weighing(lambda d, near, weight, fade: np.exp(-near / fade))
    ),
    "the exponent is the distance divided by `fade`, not squared": (
        _weighing(lambda d, near, weight, fade: weight * np.exp(-((near / fade) ** 2)))
    ),
    "`weight` and `fade` are exchanged: weight * exp(-distance / fade)": (
        _weighing(lambda d, near, weight, fade: fade * np.exp(-near / weight))
    ),
    "the metric falls by the factor e every `fade` metres: np.exp, not powers of 2": (
        _weighing(lambda d, near, weight, fade: weight * 2 ** (-near / fade))
    ),
    "the metric fades exponentially, np.exp, not along a straight line": (
        _weighing(lambda d, near, weight, fade: weight * np.maximum(0, 1 - near / fade))
    ),
    "each metric stands alone; do not divide them by their sum": (
        _weighing(
            lambda d, near, weight, fade: weight * np.exp(-near / fade) / np.exp(-near / fade).sum()
        )
    ),
}


def _topics() -> list[Topic]:
    rng = np.random.default_rng(7)
    usual = (0.12, 0.3, 0.4, 0.1)
    distances = np.array([0.5, 0.2, 0.05])
    closing = np.array([0.4, 0.3, 0.1])

    def random() -> tuple:
        count = int(rng.integers(1, 9))
        gains = rng.uniform([0.05, 0.05, 0.1, 0.05], [0.6, 0.6, 3.0, 0.5])
        return (rng.uniform(-0.05, 1, count), rng.uniform(-1, 1, count), *map(float, gains))

    def changed(place: int, *values: float) -> list[tuple]:
        gains = [[*usual[:place], value, *usual[place + 1 :]] for value in values]
        return [(distances, closing, *each) for each in gains]

    return [
        Topic(
            "obstacles at rest",
            "without closing speed: push / distance, and a metric that falls with the distance",
            [(distances, np.zeros(3), *usual)],
        ),
        Topic(
            "obstacles that come nearer",
            "the brake times the closing speed is added to the push, before the division",
            [(distances, closing, *usual), (distances, 0.1 * closing, *usual)],
        ),
        Topic(
            "obstacles that recede",
            "a negative closing speed counts as 0: the push stays, the brake is off",
            [(distances, -closing, *usual)],
        ),
        Topic(
            "obstacles at 3 mm, at contact and overlapping",
            "first limit the distances from below to 0.01 m; then use them in both formulas",
            [(np.array([0.003, 0.0, -0.3]), np.array([0.0, 0.1, 0.2]), *usual)],
        ),
        Topic(
            "obstacles at 1.2 cm and at 3 m",
            "only distances below 0.01 m are limited, and no obstacle is left out",
            [(np.array([0.012, 3.0, 0.9]), np.array([0.1, 0.1, -0.1]), *usual)],
        ),
        Topic(
            "another push",
            "the push is an argument; use it, and no number in its place",
            changed(0, 0.0, 0.5),
        ),
        Topic(
            "another brake",
            "the brake is an argument; use it, and no number in its place",
            changed(1, 0.0, 0.9),
        ),
        Topic(
            "another weight",
            "the weight is an argument; use it, and no number in its place",
            changed(2, 0.0, 3.0),
        ),
        Topic(
            "another fade",
            "the fade is an argument, a length in metres; use it, and no number in its place",
            changed(3, 0.03, 0.6),
        ),
        Topic(
            "30 random groups of one to eight obstacles",
            "the simple cases are right; does a part of your rule hold for some obstacles only?",
            [random() for _ in range(30)],
        ),
    ]


@check(rmp.obstacle_policy, _EXAMPLE)
def check_obstacle_policy(student: Callable[..., Any]) -> None:
    """The push off an obstacle: near and far, closing and receding, and at contact."""
    with np.errstate(all="ignore"):
        judge_topics(
            "obstacle_policy",
            student,
            _topics(),
            rmp.obstacle_policy,
            _FAULTS,
            form=_form,
            same=same_policies,
            difference=differing,
        )


def _form(what: str, answer: object, distances: Array, *_: object) -> Policies:
    return policies_of(what, answer, distances.shape, distances.shape)
