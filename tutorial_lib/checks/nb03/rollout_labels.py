"""The check of the labels of rollouts, in notebook 03."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.nb03.forms import calling, vector
from tutorial_lib.checks.nb03.rollout_faults import FAULTS, rollout_labels
from tutorial_lib.checks.nb03.rollout_stories import (
    STORIES,
    Case,
    at_limits,
    last_moment,
    random_rollouts,
    rollouts_of,
)
from tutorial_lib.driving.metrics import REACHED, time_limit
from tutorial_lib.geometry import Array
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label

_CASES: dict[str, Case] = {
    "single stories": rollouts_of(),
    "exactly at the limits": at_limits(),
    "near in the last moment alone": last_moment(),
    "uneven times": random_rollouts(9, 40, 1),
    "as many moments as cars": random_rollouts(12, 12, 2),
    "one car": random_rollouts(30, 1, 11),
    "one moment": random_rollouts(1, 20, 4),
    "300 cars": random_rollouts(150, 300, 5),
}
_HINTS: dict[type[Exception], str] = {
    ValueError: "times is (T,), geodesic (N,), the others are (T, N): times[:, None] is a column, "
    "with which limits (N,) make a table (T, N)",
    IndexError: "gaps and touched have a row for each moment and a column for each car",
    TypeError: "gaps and touched are arrays (T, N); tables of true and false are joined by &, |, ~",
}
_EXAMPLE = (np.arange(300.0), np.ones((300, 400)), np.zeros((300, 400), bool), np.ones(400))


@check(rollout_labels, _EXAMPLE)
def check_rollout_labels(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """In time and too late, past the target, along walls, exactly at limits, and 400 more."""
    return compare(
        "rollout_labels",
        student,
        _CASES,
        rollout_labels,
        FAULTS,
        invoke=calling(_HINTS),
        form=_form,
        same=_same,
        difference=_worst,
        broken=_broken,
        draw=_timelines,
    )


def _form(what: str, got: Any, *case: Any) -> Array:  # noqa: ANN401 - students' answers
    """Labels of the right form."""
    count = case[1].shape[1]
    if isinstance(got, np.ndarray) and got.shape == case[1].shape and got.shape != (count,):
        words = "one answer for each moment; a rollout has one label, 1 if any moment is good"
        raise WrongAnswer(f"{what}: {words}")
    if isinstance(got, np.ndarray) and got.ndim == 1 and len(got) < count:
        words = f"{len(got)} labels for {count} rollouts; one that touched something"
        raise WrongAnswer(f"{what}: {words} counts 0, it is not left out")
    return vector(what, got, count, "a label for each car")


def _same(got: Array, want: Array, *_: object) -> bool:
    return np.allclose(got, want, atol=1e-6, equal_nan=True)


def _broken(got: Array, want: Array, *case: Array) -> str:
    """Which of the three conditions decides the first label that is wrong."""
    times, gaps, _, geodesic = case
    number = int(np.flatnonzero(~np.isclose(got, want, atol=1e-6))[0])
    near = gaps[:, number] <= REACHED
    if want[number]:
        return (
            "a single moment is enough, any from the first to the last: at most 0.30 m away, at "
            "most geodesic / 0.3 + 5 s after the start, and nothing touched until then"
        )
    if not near.any():
        return "a car that is never within 0.30 m has not reached its target; do not round"
    if not (near & (times <= time_limit(geodesic[number]))).any():
        return "it comes near too late: after geodesic / 0.3 + 5 s of its own geodesic, unrounded"
    return "whatever was touched up to the moment of arrival, in whichever moment, makes it 0"


def _worst(got: Array, want: Array, *case: Array) -> str:
    """What happens in the first rollout whose label is wrong."""
    times, gaps, touched, geodesic = case
    number = int(np.flatnonzero(~np.isclose(got, want, atol=1e-6))[0])
    story = f'the rollout that "{STORIES[number][0]}"' if len(gaps) == 301 else f"car {number}"

    def first(moments: NDArray[np.bool_]) -> str:
        return f"first at {times[moments.argmax()]:.4g} s" if moments.any() else "never"

    near, touches = first(gaps[:, number] <= REACHED), first(touched[:, number])
    facts = f"it is within 0.30 m {near}, touches something {touches}, and t_max is"
    limit = f"{time_limit(geodesic[number]):.4g} s"
    return f"{story} has the label {want[number]:.0f}, not {got[number]:.3g}: {facts} {limit}"


def _timelines(want: Array, got: Array) -> NDArray[np.uint8]:
    """A line for each story: when it is near, when it touches, its time limit, both labels."""
    times, gaps, touched, geodesic = rollouts_of()
    picture = np.full((36 + 26 * len(STORIES), 760, 3), 255, np.uint8)

    write = partial(label, picture, size=0.5)

    def across(time: float) -> int:
        return round(302 + 11 * time)

    write("green: within 0.30 m    red: touches    bar: t_max", 4, 18, colour=colours.SOLID)
    write("target  yours", 646, 18, colour=colours.SOLID)
    for row, (story, limit) in enumerate(zip(STORIES, time_limit(geodesic), strict=True)):
        y = 44 + 26 * row
        write(story[0], 4, y + 5)
        for i, time in enumerate(times[:-1]):
            colour = colours.GOAL if gaps[i, row] <= REACHED else (215, 218, 222)
            cv2.rectangle(picture, (across(time), y - 2), (across(time + 0.1), y + 2), colour, -1)
        for time in times[touched[:, row]]:
            cv2.circle(picture, (across(time), y + 6), 2, colours.LASER, -1, cv2.LINE_AA)
        x = across(min(limit, times[-1]))
        cv2.line(picture, (x, y - 9), (x, y + 9), colours.INK, 2)
        write(f"{want[row]:.0f}", 666, y + 5)
        right = abs(got[row] - want[row]) < 1e-6
        write(f"{got[row]:.3g}", 716, y + 5, colour=colours.GOAL if right else colours.LASER)
    return picture
