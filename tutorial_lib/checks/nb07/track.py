"""The check of the filter's loop over a recorded drive, in notebook 07."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import parts, returned
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.framework.explanation import explained
from tutorial_lib.checks.nb07.predict import predict
from tutorial_lib.checks.nb07.track_stories import STORIES, Drive, Story
from tutorial_lib.checks.nb07.track_words import FAULTS
from tutorial_lib.checks.nb07.update import update
from tutorial_lib.geometry import Array
from tutorial_lib.topology.localization import FilterSettings
from tutorial_lib.topology.motion_model import TURN

Tracked = tuple[Array, list[int]]
"""Beliefs (T, V + 1), and the vertex at each step, -1 off the map."""
Rule = Callable[..., Array]


def track(
    odometry: Array,
    look: Callable[[int], Array],
    lengths: Array,
    onward: Array,
    rules: FilterSettings,
    steps: tuple[Rule, Rule] = (predict, update),
) -> Tracked:
    """Localize one robot at each step of a drive; see the exercise.

    Args:
        odometry: (T, 3) poses as the wheels measure them.
        look: returns the likelihoods (V,) of what is seen at a step.
        lengths: (V + 1,) of the motion model.
        onward: (V + 1, V + 1) of the motion model.
        rules: settings of the filter.
        steps: that predict and update.
    """
    return _tracked(odometry, look, lengths, onward, rules, steps=steps)


def distance(first: Array, second: Array) -> float:
    """How far a robot has moved from one pose (3,) to another, metres; turning counts as well."""
    turn = (second[2] - first[2] + math.pi) % (2.0 * math.pi) - math.pi
    return math.hypot(second[0] - first[0], second[1] - first[1]) + TURN * abs(turn)


def _tracked(
    odometry: Array,
    look: Callable[[int], Array],
    lengths: Array,
    onward: Array,
    rules: FilterSettings,
    fault: str = "",
    steps: tuple[Rule, Rule] = (predict, update),
) -> Tracked:
    """The loop, with a `fault` if one is named."""
    count = len(lengths)
    belief = prior = np.full((1, count), 1.0 / count)
    last, waited, vertex = odometry[0], rules.interval, -1
    beliefs, vertices = [], []
    if fault == "no first look":
        waited = 0
    for step, pose in enumerate(odometry):
        motion = distance(last, pose)
        far = motion > rules.stride if fault == "greater" else motion >= rules.stride
        if fault == "each step":
            far = motion > 0
        if far:
            source = prior if fault == "from the prior" else belief
            far_motion = rules.stride if fault == "stride" else motion
            prior = steps[0](source, np.array([far_motion]), lengths, onward)
        if (far and fault != "from the start") or fault == "step by step":
            last = pose
        waited += step > 0
        due = waited >= rules.interval + (fault == "late")
        if fault == "always looks" or far or (due and fault != "never waits"):
            seen = np.maximum(look(step), 0.0 if fault == "no least" else rules.least)
            unknown = 0.0 if fault == "no unknown" else rules.unknown
            power = 1.0 if fault == "no power" else rules.sharpness
            likelihood = np.append(seen, unknown) ** power
            if fault == "unknown as it is":
                likelihood[-1] = unknown
            source = belief if fault == "twice" else prior
            source = np.full((1, count), 1.0 / count) if fault == "no memory" else source
            belief = steps[1](source, likelihood[None])
            waited = waited if fault == "always due" else 0
        vertex = _chosen(belief[0], vertex, rules, fault)
        beliefs.append((prior if fault == "prior" else belief)[0])
        vertices.append(vertex)
    return np.array(beliefs), vertices


def _chosen(belief: Array, before: int, rules: FilterSettings, fault: str) -> int:
    """The vertex at which the robot is localized."""
    best = int(belief.argmax())
    if fault == "never lost":
        best = int(belief[:-1].argmax())
    share = {"no hysteresis": 2.0, "for ever": 0.0}.get(fault, rules.hysteresis)
    stays = belief[before] >= share * belief[best]
    if fault == "half":
        stays = belief[before] >= share
    if stays:
        return before
    return -1 if best == len(belief) - 1 and fault != "last number" else best


def _play(tracks: Callable[..., Any], story: Story) -> tuple[Any, list[int]]:
    """What comes back, and at which steps the function looked."""
    drive = Drive(story)
    arguments = story.odometry.copy(), drive.look, story.lengths.copy(), story.onward.copy()
    return tracks(*arguments, story.rules), drive.log


def _invoke(what: str, student: Callable[..., Any], story: Story) -> tuple[Any, list[int]]:
    hints = {
        TypeError: "look(step) takes the number of a step, predict and update arrays of one row",
        ValueError: "belief and prior have one row, (1, V + 1); the motion is an array of one",
        IndexError: "belief has one row: belief[0] is that of the robot",
    }
    try:
        with np.errstate(all="ignore"):
            return _play(student, story)
    except WrongAnswer as wrong:
        raise WrongAnswer(f"{what}: {wrong}") from None
    except NotImplementedError:
        raise
    except Exception as error:
        raise WrongAnswer(f"{what}: {explained(error, hints)}") from error


@check(
    track,
    (np.zeros((40, 3)), lambda step: np.full(5, 0.5), np.ones(6), np.eye(6), FilterSettings()),
    calls=20,
)
def check_track(student: Callable[..., Any]) -> None:
    """Drives along a row, at standstill, among twins, off the map, and with a kidnapping."""
    faults = with_faults(_tracked, FAULTS)
    compare(
        "track",
        student,
        {name: (story,) for name, story in STORIES.items()},
        partial(_play, track),
        {words: partial(_play, rule) for words, rule in faults.items()},
        invoke=_invoke,
        form=_form,
        same=_same,
        difference=_differ,
    )


def _form(
    what: str, got: tuple[Any, list[int]], story: Story
) -> tuple[Array, list[int], list[int]]:
    """Beliefs, vertices and looks in the right form."""
    words = "return the beliefs and the vertices, one of each for every step"
    beliefs, vertices = parts(what, returned(what, got[0]), 2, words)
    try:
        beliefs = np.asarray(beliefs, dtype=float)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what}: the beliefs are no array of numbers") from None
    shape = len(story.odometry), len(story.lengths)
    if beliefs.shape != shape:
        words = "append belief[0], a row, at each step" if beliefs.ndim == 3 else "one row a step"
        raise WrongAnswer(
            f"{what}: beliefs of shape {beliefs.shape}, but {shape} is right; {words}"
        )
    if len(vertices) != len(story.odometry):
        raise WrongAnswer(f"{what}: {len(vertices)} vertices for {len(story.odometry)} steps")
    return beliefs, [int(vertex) for vertex in vertices], got[1]


def _same(
    got: tuple[Array, list[int], list[int]], want: tuple[Array, list[int], list[int]], *_: object
) -> bool:
    return bool(np.allclose(got[0], want[0], atol=1e-7)) and got[1:] == want[1:]


def _differ(
    got: tuple[Array, list[int], list[int]],
    want: tuple[Array, list[int], list[int]],
    story: Story,
) -> str:
    """The first step at which something is wrong."""
    if got[2] != want[2]:
        wrong = sorted(set(got[2]) ^ set(want[2]))
        step = wrong[0] if wrong else 0
        words = "must look there" if step in want[2] else "looks without need"
        return f"at step {step} yours {words} ({_about(story, step)})"
    apart = np.abs(got[0] - want[0]).max(axis=1)
    if (apart > 1e-7).any():
        step = int((apart > 1e-7).argmax())
        state = int(np.abs(got[0] - want[0])[step].argmax())
        name = "off the map" if state == len(story.lengths) - 1 else f"vertex {state}"
        return (
            f"at step {step} the belief in {name} is {want[0][step, state]:.3f}, yours "
            f"{got[0][step, state]:.3f} ({_about(story, step)})"
        )
    step = next(i for i, pair in enumerate(zip(got[1], want[1], strict=True)) if pair[0] != pair[1])
    return f"at step {step} the robot is at {want[1][step]}, in yours at {got[1][step]}"


def _about(story: Story, step: int) -> str:
    """What happened at a step."""
    if not step:
        return "the first one: nothing is known yet, so look"
    gone = distance(story.odometry[step - 1], story.odometry[step])
    return f"the robot has moved {gone:.2f} m since the step before"
