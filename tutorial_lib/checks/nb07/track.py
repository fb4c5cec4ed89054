"""The check of the filter's loop over a recorded drive, in notebook 07."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.framework.explanation import explained
from tutorial_lib.checks.nb07.predict import predict
from tutorial_lib.checks.nb07.small_models import distance
from tutorial_lib.checks.nb07.track_answers import broken, difference, formed, same
from tutorial_lib.checks.nb07.track_stories import STORIES, Drive, Story
from tutorial_lib.checks.nb07.track_words import FAULTS
from tutorial_lib.checks.nb07.update import update
from tutorial_lib.geometry import Array
from tutorial_lib.topology.localization import FilterSettings

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
    limit = rules.interval + {"late": 1, "early": -1}.get(fault, 0)
    last, waited, vertex = odometry[0], limit, 0 if fault == "at 0" else -1
    driven, beliefs, vertices = 0.0, list[Array](), list[int]()
    if fault == "no first look":
        waited = 0
    for step, pose in enumerate(odometry):
        driven += distance(odometry[max(step - 1, 0)], pose)
        motion = {
            "no wrap": math.dist(last[:2], pose[:2]) + 0.5 * abs(pose[2] - last[2]),
            "no small ones": distance(last, pose) * (distance(last, pose) >= 0.05),
            "adds up": driven,
            "no turns": math.dist(last[:2], pose[:2]),
        }.get(fault, distance(last, pose))
        far = motion > rules.stride if fault == "greater" else motion >= rules.stride
        if fault == "each step":
            far = motion > 0
        if far:
            source = prior if fault == "from the prior" else belief
            far_motion = rules.stride if fault == "stride" else motion
            prior, driven = steps[0](source, np.array([far_motion]), lengths, onward), 0.0
        if (far and fault != "from the start") or fault == "step by step":
            last = pose
        waited += step > 0
        due = waited >= limit and (fault != "never waits" or not step)
        if fault == "always looks" or far or due:
            source = belief if fault == "twice" or (fault == "at rest" and not far) else prior
            source = np.full((1, count), 1.0 / count) if fault == "no memory" else source
            belief = steps[1](source, _likelihood(look(step), rules, fault)[None])
            waited = waited if fault == "always due" or (far and fault == "due at rest") else 0
        vertex = _chosen(belief[0], vertex, rules, fault)
        beliefs.append((prior if fault == "prior" else belief)[0])
        vertices.append(vertex)
    return np.array(beliefs), vertices


def _likelihood(seen: Array, rules: FilterSettings, fault: str) -> Array:
    """The likelihoods (V + 1,) of all states."""
    power = 1.0 if fault == "no power" else rules.sharpness
    unknown = 0.0 if fault == "no unknown" else rules.unknown
    if fault == "unknown as it is":
        return np.append(np.maximum(seen, rules.least) ** power, unknown)
    if fault == "power before least":
        return np.append(np.maximum(seen**power, rules.least), unknown**power)
    unknown = max(unknown, rules.least) if fault == "least for all" else unknown
    seen = np.maximum(seen, 0.0 if fault == "no least" else rules.least)
    return (
        np.append(unknown, seen) if fault == "unknown first" else np.append(seen, unknown)
    ) ** power


def _chosen(belief: Array, before: int, rules: FilterSettings, fault: str) -> int:
    """The vertex at which the robot is localized."""
    best = int(belief.argmax())
    greatest = belief[best]
    if fault in ("never lost", "never off"):
        best = int(belief[:-1].argmax())
        greatest = belief[best] if fault == "never lost" else greatest
    share = {"no hysteresis": 2.0, "for ever": 0.0}.get(fault, rules.hysteresis)
    stays = belief[before] >= share * greatest
    if fault == "more than the share":
        stays = belief[before] > share * greatest
    if fault == "share is a half":
        stays = belief[before] >= 0.5 * greatest
    if fault == "half":
        stays = belief[before] >= share
    if stays and not (fault == "off at once" and before == -1):
        return before
    return -1 if best == len(belief) - 1 and fault != "last number" else best


def _play(tracks: Callable[..., Any], story: Story) -> tuple[Any, list[int]]:
    """What comes back, and at which steps the function looked."""
    drive = Drive(story)
    arguments = story.odometry.copy(), drive.look, story.lengths.copy(), story.onward.copy()
    got = tracks(*arguments, story.rules)
    for name in ("odometry", "lengths", "onward"):
        changed = arguments[("odometry", "", "lengths", "onward").index(name)]
        if not np.array_equal(changed, getattr(story, name)):
            raise WrongAnswer(f"your function changes its argument {name}; make a new array")
    drive.demand_untouched()
    return got, drive.log


_SAID = {
    "invalid index to scalar": "is a number where an array is needed? predict takes the motion as "
    "an array of one, np.array([metres])",
    "is not subscriptable": "is a number where an array is needed? predict takes the motion as an "
    "array of one, np.array([metres])",
    "array is 0-dimensional": "predict takes the motion as an array of one, np.array([metres])",
    "truth value of an array": "an array stands where one number is needed. Is the vertex always a "
    "number? It is -1 off the map and at first; belief[0, None] is a whole array",
    "NoneType": "is something None? The vertex is always a number, -1 off the map and at first",
}


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
        raise WrongAnswer(f"{what}: {explained(error, hints, _SAID)}") from error


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
        form=formed,
        same=same,
        difference=difference,
        broken=broken,
    )
