"""The check of the push off obstacles, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import call, parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.checks.nb02.policy_parts import PARTS
from tutorial_lib.driving.control import rmp
from tutorial_lib.geometry import Array

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
        away, metrics = parts("obstacle_policy", got, 2, PARTS)
        if np.isinf(np.asarray(away, dtype=float)).any():
            limited = np.shape(metrics) == metric.shape and np.allclose(metrics, metric)
            where = "in the acceleration too, not only in the metric" if limited else "in both"
            raise WrongAnswer(
                f"accelerations, {name}: infinite at contact; nearer than 0.01 m counts as "
                f"0.01 m, {where}"
            )
        mistakes = {"that is the metric: give the accelerations first": metric}
        mistakes |= _mistakes(distances, closing, *gains[:2])
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


def _mistakes(distances: Array, closing: Array, push: float, brake: float) -> dict[str, Array]:
    """Known mistakes, and the accelerations they give."""
    near, shrinking = np.maximum(distances, 0.01), np.maximum(closing, 0)
    right, both = push + brake * shrinking, push + brake * closing
    return {
        "a receding obstacle only pushes: its closing speed counts as 0": both / near,
        "no brake for a receding obstacle: np.maximum(closing, 0), not the absolute value": (
            push + brake * np.abs(closing)
        )
        / near,
        "a receding obstacle still pushes: limit the closing speed from below, not the sum": (
            np.maximum(both, 0) / near
        ),
        "it makes the distance grow: positive": -right / near,
        "the push and the brake are both divided by the distance": push / near + brake * shrinking,
        "divide both terms by the distance, the push as well": push + brake * shrinking / near,
        "divide by the distance: near obstacles push harder": right,
        "while closing in, the brake comes on top of the push": push / near,
        "nearer than 0.01 m counts as 0.01 m, in the acceleration too": right
        / np.where(distances == 0, np.nan, distances),
    }
