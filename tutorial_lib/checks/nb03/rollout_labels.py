"""The check of the labels of rollouts, in notebook 03."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import call, numbers
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import close, expect, farthest
from tutorial_lib.driving.metrics import GRACE, REACHED, SLOWEST, time_limit
from tutorial_lib.geometry import Array
from tutorial_lib.viz.canvas import colours

Touches = NDArray[np.bool_]


def rollout_labels(times: Array, gaps: Array, touched: Touches, geodesic: Array) -> Array:
    """1 for each rollout (N,) within 0.30 m of its target in time, with nothing touched before.

    Args:
        times: (T,) seconds since the start, rising.
        gaps: (T, N) metres to the target.
        touched: (T, N) whether something is touched at that moment.
        geodesic: (N,) metres from start to target along the shortest path.
    """
    in_time = times[:, None] <= time_limit(geodesic)
    so_far = np.logical_or.accumulate(touched, axis=0)
    return ((gaps <= REACHED) & in_time & ~so_far).any(axis=0).astype(float)


# Each rollout: its story, metres to the target every 5 s, when it touches something (single moments
# or from, to), its geodesic and its label.
_STORIES: tuple[tuple[str, list[float], list[float | tuple[float, float]], float, float], ...] = (
    ("arrives in time", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [], 2.0, 1),
    ("never comes near", [3.0, 2.5, 2.2, 2.0, 2.0, 2.0, 2.0], [], 3.0, 0),
    ("scrapes past a post, then arrives", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [3.0], 2.0, 0),
    ("arrives, touches a wall later", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [11.0], 2.0, 1),
    ("arrives too late", [2.0, 1.5, 1.0, 0.8, 0.1, 0.1, 0.1], [], 2.0, 0),
    ("needs some of the 5 s", [1.5, 0.6, 0.0, 0.0, 0.0, 0.0, 0.0], [], 1.5, 1),
    ("passes the target, rollouts on", [1.6, 0.0, 1.6, 3.0, 4.0, 4.0, 4.0], [], 1.6, 1),
    ("stops 0.4 m from the target", [2.0, 0.7, 0.4, 0.4, 0.4, 0.4, 0.4], [], 2.0, 0),
    ("ends at a wall", [3.0, 1.5, 1.0, 1.0, 1.0, 1.0, 1.0], [(8.0, 30.0)], 3.0, 0),
    ("has a long path", [5.5, 4.0, 2.5, 1.2, 0.1, 0.1, 0.1], [], 5.5, 1),
    ("leans on a wall as it arrives", [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [(7.0, 30.0)], 2.0, 0),
)
_LABELS = np.array([float(story[-1]) for story in _STORIES])


def _rollouts() -> tuple[Array, Array, Touches, Array]:
    """The arguments for these stories."""
    times = 0.1 * np.arange(301)
    gaps = np.stack([np.interp(times, 5.0 * np.arange(7), s[1]) for s in _STORIES], axis=1)
    touched = np.zeros(gaps.shape, dtype=bool)
    for number, story in enumerate(_STORIES):
        for moment in story[2]:
            begin, end = moment if isinstance(moment, tuple) else (moment, moment)
            touched[round(10 * begin) : round(10 * end) + 1, number] = True
    return times, gaps, touched, np.array([story[3] for story in _STORIES])


_EXAMPLE = (np.arange(300.0), np.ones((300, 400)), np.zeros((300, 400), bool), np.ones(400))


@check(rollout_labels, _EXAMPLE)
def check_rollout_labels(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """Eleven rollouts: in time and too late, past the target, along a wall and into one."""
    rollouts, what = _rollouts(), "rollout_labels"
    got = call(student, *rollouts)
    picture = _timelines(*rollouts, got)
    clean = len(_LABELS) - rollouts[2].any(axis=0).sum()
    if np.ndim(got) == 1 and clean <= len(got) < len(_LABELS):
        words = f"{len(got)} labels for {len(_LABELS)} rollouts; one that touched something"
        raise WrongAnswer(f"{what}: {words} counts 0, it is not left out", picture)
    if np.shape(got) == rollouts[1].shape:
        words = "one answer for each moment; a rollout has one label, 1 if any moment is good"
        raise WrongAnswer(f"{what}: {words}", picture)
    labels, known = numbers(what, got, _LABELS.shape), _mistakes(*rollouts).items()
    expect(what, labels, _LABELS, known, close, _worst_story, picture)
    return picture


def _worst_story(got: Array, want: Array) -> str:
    """The rollout whose label is farthest off."""
    if np.isnan(got).any():
        return farthest(got, want)
    number = int(np.abs(got - want).argmax())
    return f'the rollout that "{_STORIES[number][0]}" has the label {want[number]:.0f}'


def _mistakes(times: Array, gaps: Array, touched: Touches, geodesic: Array) -> dict[str, Array]:
    """Known mistakes, and the labels they give."""
    limit, robots = time_limit(geodesic), np.arange(len(geodesic))
    near, so_far = gaps <= REACHED, np.logical_or.accumulate(touched, axis=0)
    in_time, clean, ever = times[:, None] <= limit, near & ~so_far, touched.any(axis=0)
    hurried, multiplied = times[:, None] <= geodesic / SLOWEST, SLOWEST * geodesic + GRACE
    last = np.minimum(np.searchsorted(times, limit, side="right"), len(times)) - 1
    once = "a car that was at the target once has reached it: do not look only at"
    return {
        "a rollout that touched something has failed, even if it arrives": (near & in_time).any(0),
        "what a car touches after it has arrived does not count: look at what was touched up to "
        "each moment": (near & in_time).any(0) & ~ever,
        "a rollout that touched something has failed, even if the car is free again when it "
        "arrives; see np.logical_or.accumulate": (near & in_time & ~touched).any(0),
        "a target that is reached after t_max does not count": clean.any(0),
        "t_max has 5 s on top: geodesic / 0.3 + 5": (clean & hurried).any(0),
        "0.3 m/s is a speed: divide the geodesic by it": (
            clean & (times[:, None] <= multiplied)
        ).any(0),
        f"{once} the last moment": near[-1] & ~ever,
        f"{once} the moment t_max": near[last, robots] & ~so_far[last, robots],
        "near means within 0.30 m": ((gaps <= 0.5) & in_time & ~so_far).any(0),
        "a rollout that touched something counts 0, not nan: it is a failure, not a gap in the "
        "data": np.where(ever & (_LABELS == 0), np.nan, _LABELS),
        "1 is for those that arrive, 0 for those that do not": 1 - _LABELS,
    }


def _timelines(
    times: Array, gaps: Array, touched: Touches, geodesic: Array, got: object
) -> NDArray[np.uint8]:
    """A line for each rollout: when it is near, when it touches, its time limit, both labels."""
    picture = np.full((36 + 26 * len(_STORIES), 720, 3), 255, np.uint8)

    def write(text: str, x: int, y: int, colour: tuple[int, int, int] = colours.INK) -> None:
        cv2.putText(picture, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)

    def across(time: float) -> int:
        return round(262 + 11 * time)

    write("green: within 0.30 m    red: touches    bar: t_max", 4, 18, colours.SOLID)
    write("target  yours", 606, 18, colours.SOLID)
    own = np.asarray(got, dtype=float) if np.shape(got) == _LABELS.shape else None
    for row, (story, limit) in enumerate(zip(_STORIES, time_limit(geodesic), strict=True)):
        y = 44 + 26 * row
        write(story[0], 4, y + 5)
        for i, time in enumerate(times[:-1]):
            colour = colours.GOAL if gaps[i, row] <= REACHED else (215, 218, 222)
            cv2.rectangle(picture, (across(time), y - 2), (across(time + 0.1), y + 2), colour, -1)
        for time in times[touched[:, row]]:
            cv2.circle(picture, (across(time), y + 6), 2, colours.LASER, -1, cv2.LINE_AA)
        x = across(min(limit, times[-1]))
        cv2.line(picture, (x, y - 9), (x, y + 9), colours.INK, 2)
        write(f"{_LABELS[row]:.0f}", 626, y + 5)
        if own is not None:
            right = abs(own[row] - _LABELS[row]) < 1e-6
            write(f"{own[row]:.3g}", 676, y + 5, colours.GOAL if right else colours.LASER)
    return picture
