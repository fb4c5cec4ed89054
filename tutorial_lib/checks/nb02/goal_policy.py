"""The check of the pull to a goal, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import call, parts
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.checks.nb02.policy_parts import PARTS
from tutorial_lib.driving.control import rmp

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
        accelerations, metrics = parts("goal_policy", got, 2, PARTS)
        expect_close(f"accelerations of {name}", accelerations, want, 1e-6, mistakes)
        zeros = {"the metric weighs all directions equally: the identity, not zeros": 0 * metric}
        expect_close(f"metrics of {name}", metrics, metric, 1e-6, zeros)
