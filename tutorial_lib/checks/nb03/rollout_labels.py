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
from tutorial_lib.checks.nb03.rollout_stories import (
    STORIES,
    Case,
    at_limits,
    random_rollouts,
    rollouts_of,
)
from tutorial_lib.driving.metrics import GRACE, REACHED, SLOWEST, time_limit
from tutorial_lib.geometry import Array
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label

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
    return ((gaps <= REACHED) & in_time & ~_so_far(touched)).any(axis=0).astype(float)


def _so_far(touched: Touches) -> Touches:
    return np.logical_or.accumulate(touched, axis=0)


_CASES: dict[str, Case] = {
    "single stories": rollouts_of(),
    "exactly at the limits": at_limits(),
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
        _FAULTS,
        invoke=calling(_HINTS),
        form=_form,
        same=_same,
        difference=_worst,
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


def _labels(moments: Touches) -> Array:
    return moments.any(axis=0).astype(float)


def _parts(case: Case) -> tuple[Touches, Touches, Touches]:
    """Where a car is near, in time, and clean so far."""
    times, gaps, touched, geodesic = case
    return gaps <= REACHED, times[:, None] <= time_limit(geodesic), ~_so_far(touched)


def _another(near: float = REACHED, slowest: float = SLOWEST, grace: float = GRACE) -> Any:  # noqa: ANN401
    """The rule with other constants."""

    def fault(times: Array, gaps: Array, touched: Touches, geodesic: Array) -> Array:
        in_time = times[:, None] <= geodesic / slowest + grace
        return _labels((gaps <= near) & in_time & ~_so_far(touched))

    return fault


def _with(rule: Callable[..., Array]) -> Callable[..., Array]:
    """A rule of near, in time and clean, and of the case, for the case alone."""
    return lambda *case: rule(*_parts(case), *case)


def _at_end(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    return (near[-1] & ~case[2].any(axis=0)).astype(float)


def _at_limit(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    times, cars = case[0], np.arange(near.shape[1])
    row = np.abs(times[:, None] - time_limit(case[3])).argmin(axis=0)
    return (near[row, cars] & clean[row, cars]).astype(float)


def _nearest(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    row, cars = case[1].argmin(axis=0), np.arange(near.shape[1])
    return (near & time & clean)[row, cars].astype(float)


def _late_start(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    """A touch in the first moment is overlooked."""
    later = np.vstack([np.zeros_like(case[2][:1]), case[2][1:]])
    return _labels(near & time & ~_so_far(later))


def _even_steps(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    steps = 0.1 * np.arange(len(near))[:, None] <= time_limit(case[3])
    return _labels(near & clean & steps)


def _before(touched: Touches) -> Touches:
    """What was touched before each moment, without that moment."""
    return np.vstack([np.zeros_like(touched[:1]), _so_far(touched)[:-1]])


def _as_index(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    steps = np.arange(len(near))[:, None] <= time_limit(case[3])
    return _labels(near & clean & steps)


_FAULTS: dict[str, Callable[..., Array]] = {
    "every rollout counts as reached; three things must hold": lambda t, g, c, d: np.ones(len(d)),
    "no rollout counts as reached; look at each moment": lambda t, g, c, d: np.zeros(len(d)),
    "a rollout that touched something has failed, even if it arrives": _with(
        lambda near, time, clean, *_: _labels(near & time)
    ),
    "what a car touches after it has arrived does not count: look at what was touched up to each "
    "moment": _with(lambda near, time, _, *case: _labels(near & time) * ~case[2].any(axis=0)),
    "a rollout that touched something has failed, even if the car is free again when it arrives; "
    "see np.logical_or.accumulate": _with(
        lambda near, time, _, *case: _labels(near & time & ~case[2])
    ),
    "a touch in the moment in which the car arrives counts, too": _with(
        lambda near, time, _, *case: _labels(near & time & ~_before(case[2]))
    ),
    "a target that is reached after t_max does not count": _with(
        lambda near, _, clean, *case: _labels(near & clean)
    ),
    "t_max has 5 s on top: geodesic / 0.3 + 5": _another(grace=0.0),
    "0.3 m/s is a speed: divide the geodesic by it": lambda t, g, c, d: _labels(
        (g <= REACHED) & (t[:, None] <= SLOWEST * d + GRACE) & ~_so_far(c)
    ),
    "t_max is geodesic / 0.3 + 5: the 5 s come on top of the quotient": lambda t, g, c, d: _labels(
        (g <= REACHED) & (t[:, None] <= (d + GRACE) / SLOWEST) & ~_so_far(c)
    ),
    "t_max is different for each car; it depends on its geodesic": lambda t, g, c, d: _labels(
        (g <= REACHED) & (t[:, None] <= time_limit(d.max())) & ~_so_far(c)
    ),
    "t_max is in seconds: compare it with times, not with the number of the row": _with(_as_index),
    "a car that was at the target once has reached it: do not look only at the last moment": (
        _with(_at_end)
    ),
    "a car that was at the target once has reached it: do not look only at the moment t_max": (
        _with(_at_limit)
    ),
    "a car that was at the target once has reached it: look at every moment, not at the last": (
        _with(lambda near, time, _, *case: (near[-1] & time[-1] & ~case[2].any(0)).astype(float))
    ),
    "the nearest moment may come too late or after a touch, and an earlier one may be good: look "
    "at every moment": _with(_nearest),
    "the moments lie unevenly: compare times with t_max, not 0.1 s times the number of the row": (
        _with(_even_steps)
    ),
    "accumulate over the moments, axis=0, and not over the cars": _with(
        lambda near, time, _, *case: _labels(
            near & time & ~np.logical_or.accumulate(case[2], axis=1)
        )
    ),
    "a touch in the very first moment counts, too": _with(_late_start),
    "near means within 0.30 m, not 0.5 m": _another(near=0.5),
    "exactly 0.30 m counts as near, too: at most": lambda t, g, c, d: _labels(
        (g < REACHED) & (t[:, None] <= time_limit(d)) & ~_so_far(c)
    ),
    "exactly t_max is still in time: at t_max at the latest": lambda t, g, c, d: _labels(
        (g <= REACHED) & (t[:, None] < time_limit(d)) & ~_so_far(c)
    ),
    "both limits belong to it: at most 0.30 m, at t_max at the latest": lambda t, g, c, d: _labels(
        (g < REACHED) & (t[:, None] < time_limit(d)) & ~_so_far(c)
    ),
    "a rollout that touched something counts 0, not nan: it is a failure, not a gap in the data": (
        lambda *case: np.where(
            case[2].any(axis=0) & (rollout_labels(*case) == 0), np.nan, rollout_labels(*case)
        )
    ),
    "near, in time and clean must hold at the same moment, not each at some moment": _with(
        lambda near, time, clean, *_: (near.any(0) & time.any(0) & clean.any(0)).astype(float)
    ),
    "one good moment is enough: any, not all": _with(
        lambda near, time, clean, *_: (near & time & clean).all(axis=0).astype(float)
    ),
    "1 is for those that arrive, 0 for those that do not": lambda *case: 1 - rollout_labels(*case),
    "a label is 1 or 0, not the number of good moments": _with(
        lambda near, time, clean, *_: (near & time & clean).sum(axis=0).astype(float)
    ),
}


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
