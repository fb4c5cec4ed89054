"""How a demo ended, in words that are printed, saved and shown in the film."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tutorial_lib.driving.rollouts import STUCK
from tutorial_lib.experiments.protocols.navigation import Outcome
from tutorial_lib.exploration.task import STEPS, ExplorationTask
from tutorial_lib.interfaces import Plan


def drive_ending(found: Outcome, plans: Sequence[Plan] = ()) -> str:
    """How the only drive of a navigation ended; when, is said beside it.

    Args:
        found: of one trial.
        plans: of the robot, where it plans.
    """
    gap = float(found.gap[0])
    off = f"{gap:.1f} m from the goal"
    ending = str(found.ending[0])
    if ending == "arrived" and found.there[0]:
        return f"reached the goal, {gap:.2f} m from it"
    if ending == "arrived":
        belief = f", believing {plans[-1].probability:.1%}" if plans else ""
        return f"stopped {off}{belief}"
    if ending == "stuck":
        return f"collided: touched something for {STUCK:.0f} s, {off}"
    if ending == "late":
        return f"out of time, {off}"
    refusal = plans[-1].refusal if plans else ""
    if refusal and len(plans) == 1:
        return f"refused: {refusal}"
    why = f": {refusal}" if refusal else ""
    return f"gave up, {off}{why}"


def exploration_ending(task: ExplorationTask) -> str:
    """How the only episode of an exploration ended."""
    gap = float(np.linalg.norm(task.poses[0, :2] - task.goal_poses[0, :2]))
    if task.success[0]:
        return f"reached the goal, {gap:.2f} m from it"
    ended = "stopped" if task.steps[0] < STEPS else "no steps left,"
    return f"{ended} {gap:.1f} m from the goal"
