"""What `track` must return, and where two of its answers differ, for the check of notebook 07."""

from __future__ import annotations

from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import parts, returned
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.wording import kind, number_of
from tutorial_lib.checks.nb07.small_differences import both, of_rounding
from tutorial_lib.checks.nb07.small_models import distance
from tutorial_lib.checks.nb07.track_stories import Story
from tutorial_lib.geometry import Array

_TOLERANCE = 1e-9
"""Of beliefs."""
Answer = tuple[Array, list[int], list[int]]
"""Beliefs (T, V + 1), vertices of T steps, and the steps at which the robot looked."""


def formed(what: str, got: tuple[Any, list[int]], story: Story) -> Answer:
    """Beliefs, vertices and looks in the right form.

    Raises:
        WrongAnswer: when they are not what the cells below can use.
    """
    words = "return the beliefs and the vertices, one of each for every step"
    beliefs, vertices = parts(what, returned(what, got[0]), 2, words)
    return _beliefs(what, beliefs, story), _vertices(what, vertices, len(story.odometry)), got[1]


def _beliefs(what: str, beliefs: object, story: Story) -> Array:
    if not isinstance(beliefs, np.ndarray):
        words = "return an array of numpy, as np.array makes of a list of rows"
        raise WrongAnswer(f"{what}: the beliefs are {kind(beliefs)}; {words}")
    try:
        beliefs = beliefs.astype(float)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what}: the beliefs are no array of numbers") from None
    shape = len(story.odometry), len(story.lengths)
    if beliefs.shape != shape:
        words = "append belief[0], a row, at each step" if beliefs.ndim == 3 else "one row a step"
        raise WrongAnswer(
            f"{what}: beliefs of shape {beliefs.shape}, but {shape} is right; {words}"
        )
    if np.isnan(beliefs).any():
        step = int(np.isnan(beliefs).any(axis=1).argmax())
        words = "is something divided by 0, or used before it is set?"
        raise WrongAnswer(f"{what}: from step {step} on beliefs are not numbers (nan); {words}")
    return beliefs


def _vertices(what: str, vertices: object, count: int) -> list[int]:
    if not isinstance(vertices, list | tuple | np.ndarray):
        raise WrongAnswer(f"{what}: the vertices are {kind(vertices)}; return a list of numbers")
    shape = vertices.shape if isinstance(vertices, np.ndarray) else (len(vertices),)
    if len(shape) != 1:
        raise WrongAnswer(f"{what}: vertices of shape {shape}, but ({count},) is right")
    if len(vertices) != count:
        raise WrongAnswer(
            f"{what}: the vertices have length {len(vertices)} for {number_of(count, 'step')}"
        )
    for step, vertex in enumerate(vertices):
        if isinstance(vertex, bool) or not isinstance(vertex, int | np.integer):
            words = (
                "whole numbers, -1 for off the map; np.zeros(T) makes floats, np.zeros(T, int) none"
            )
            raise WrongAnswer(
                f"{what}: at step {step} the vertex is {vertex!r}, {kind(vertex)}; "
                f"vertices are {words}"
            )
    return [int(vertex) for vertex in vertices]


def same(got: Answer, want: Answer, *_: object) -> bool:
    """Whether two answers are equally good."""
    return np.allclose(got[0], want[0], rtol=0, atol=_TOLERANCE) and got[1:] == want[1:]


def broken(got: Answer, want: Answer, story: Story) -> str:
    """Which part of the rule the first wrong step breaks."""
    if got[2] != want[2]:
        step = min(set(got[2]) ^ set(want[2]))
        if not step:
            return "the robot looks at the first step, since nothing is known yet"
        if step not in want[2]:
            return (
                "look only after a stride since the last prediction, or after rules.interval steps"
            )
        if _since(story, step) >= story.rules.stride:
            return "a robot that has moved a stride since its last prediction predicts, and looks"
        return "rules.interval steps after the last look the robot looks again, wherever it is"
    wrong = np.abs(got[0] - want[0]).max(axis=1) > _TOLERANCE
    if not wrong.any():
        return (
            "the vertex of a step follows from its belief: it stays while that is at least "
            "rules.hysteresis times the greatest; else the one with the greatest, -1 for the last"
        )
    step = int(wrong.argmax())
    if of_rounding(got[0], want[0]):
        return ""
    if step not in want[2]:
        return "without a look the belief stays as it was; append a row of its own for each step"
    if not step:
        return (
            "the first prior is the same for all states, off the map as well; the likelihoods, at "
            "least rules.least, and rules.unknown behind them, all to the power of rules.sharpness"
        )
    if _since(story, step) >= story.rules.stride:
        return (
            "predict from the belief with the motion since the last prediction, and update that "
            "prior by what is seen at this step"
        )
    return "a look without a motion updates the prior of the last motion, which itself stays"


def _since(story: Story, step: int) -> float:
    """Metres from the pose of the last prediction before a step."""
    last = story.odometry[0]
    for pose in story.odometry[1:step]:
        last = pose if distance(last, pose) >= story.rules.stride else last
    return distance(last, story.odometry[step])


def _due(story: Story, looks: list[int], step: int) -> str:
    """How far, and how long, the robot has gone since it predicted and looked."""
    if not step:
        return "the first one: nothing is known yet, so look"
    last = max((look for look in looks if look < step), default=0)
    return (
        f"{_since(story, step):.2f} m since the last prediction, rules.stride is "
        f"{story.rules.stride:g} m; {number_of(step - last, 'step')} since the last look, "
        f"rules.interval is {story.rules.interval}"
    )


def difference(got: Answer, want: Answer, story: Story) -> str:
    """The first step at which something is wrong."""
    if got[2] != want[2]:
        step = min(set(got[2]) ^ set(want[2]))
        words = "must look there" if step in want[2] else "looks without need"
        return f"at step {step} yours {words} ({_due(story, want[2], step)})"
    apart = np.abs(got[0] - want[0])
    wrong = apart.max(axis=1) > _TOLERANCE
    if wrong.any():
        step = int(wrong.argmax())
        state = int(apart[step].argmax())
        name = "off the map" if state == len(story.lengths) - 1 else f"vertex {state}"
        mine, right = both(got[0][step, state], want[0][step, state], 3)
        return (
            f"at step {step} the belief in {name} is {right}, yours {mine} "
            f"({_due(story, want[2], step)})"
            f"{of_rounding(got[0], want[0])}"
        )
    step = next(i for i, pair in enumerate(zip(got[1], want[1], strict=True)) if pair[0] != pair[1])
    return f"at step {step} the robot is at {want[1][step]}, in yours at {got[1][step]}"
