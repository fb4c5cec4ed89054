"""The check of the labels of rollouts, in notebook 03."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import Mask, WrongAnswer, case, exercise
from tutorial_lib.checks.nb03.forms import calling, vector
from tutorial_lib.driving.metrics import GRACE, REACHED, SLOWEST, time_limit
from tutorial_lib.geometry import Array
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label

Case = tuple[Array, Array, Mask, Array]
"""times (T,), gaps (T, N), touched (T, N), geodesic (N,)."""
Story = tuple[str, list[float], list[float | tuple[float, float]], float]
"""What it is like, metres to the target every 5 s, when something is touched (single moments or
from, to), and the geodesic."""

STORIES: tuple[Story, ...] = (
    ("arrives in time", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [], 2.0),
    ("never comes near", [3.0, 2.5, 2.2, 2.0, 2.0, 2.0, 2.0], [], 3.0),
    ("scrapes past a post, then arrives", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [3.0], 2.0),
    ("arrives, touches a wall later", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [11.0], 2.0),
    ("arrives too late", [2.0, 1.5, 1.0, 0.8, 0.1, 0.1, 0.1], [], 2.0),
    ("needs some of the 5 s", [1.5, 0.6, 0.0, 0.0, 0.0, 0.0, 0.0], [], 1.5),
    ("passes the target, rolls on", [1.6, 0.0, 1.6, 3.0, 4.0, 4.0, 4.0], [], 1.6),
    ("stops 0.4 m from the target", [2.0, 0.7, 0.4, 0.4, 0.4, 0.4, 0.4], [], 2.0),
    ("ends at a wall", [3.0, 1.5, 1.0, 1.0, 1.0, 1.0, 1.0], [(8.0, 30.0)], 3.0),
    ("has a long path", [5.5, 4.0, 2.5, 1.2, 0.1, 0.1, 0.1], [], 5.5),
    ("leans on a wall as it arrives", [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [(7.0, 30.0)], 2.0),
    ("stops 0.2 m from the target", [2.0, 0.7, 0.2, 0.2, 0.2, 0.2, 0.2], [], 2.0),
    ("stands at the target from the start", [0.1] * 7, [], 0.1),
    ("is there at the start, rolls away", [0.1, 1.5, 2.0, 2.0, 2.0, 2.0, 2.0], [(6.0, 9.0)], 0.1),
    ("touches a wall at the start", [0.1] * 7, [0.0], 0.1),
    ("is there in the last moment alone", [9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 0.1], [], 9.0),
    ("is late by a second", [2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0], [], 2.1),
    ("is slow, its path is long", [6.0, 5.5, 5.0, 4.5, 4.0, 0.0, 0.0], [], 6.3),
)


def rollouts_of(stories: Sequence[Story] = STORIES) -> Case:
    """The arguments for these stories, every 0.1 s for half a minute."""
    times = np.arange(301) / 10
    gaps = np.stack([np.interp(times, 5.0 * np.arange(7), s[1]) for s in stories], axis=1)
    touched = np.zeros(gaps.shape, dtype=bool)
    for number, story in enumerate(stories):
        for moment in story[2]:
            begin, end = moment if isinstance(moment, tuple) else (moment, moment)
            touched[round(10 * begin) : round(10 * end) + 1, number] = True
    return times, gaps, touched, np.array([story[3] for story in stories])


def few_moments(
    times: list[float], gaps: list[list[float]], geodesic: float, *touches: tuple[int, int]
) -> Case:
    """Rollouts of a few moments; `touches` are the moments and the cars that touch something."""
    touched = np.zeros(np.shape(gaps), dtype=bool)
    for touch in touches:
        touched[touch] = True
    return np.array(times), np.array(gaps), touched, np.full(len(gaps[0]), geodesic)


def random_rollouts(moments: int, cars: int, seed: int) -> Case:
    """Rollouts at uneven times; some touch something, and half of them come near somewhere."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.0, 60.0 / moments, moments))
    times -= times[0]
    gaps = rng.uniform(0.0, 20.0 / moments + 0.8, (moments, cars))
    touched = rng.random((moments, cars)) < 1.0 / moments
    geodesic = rng.uniform(0.2, 5.0, cars)
    # None is within a hair of its limit.
    near = np.abs(times[:, None] - time_limit(geodesic)).min(axis=0) < 1e-3
    return times, gaps, touched, np.where(near, geodesic + 0.01, geodesic)


def rollout_labels(times: Array, gaps: Array, touched: Mask, geodesic: Array) -> Array:
    """1 for each rollout (N,) within 0.30 m of its target in time, with nothing touched before."""
    near, limit = gaps <= REACHED, geodesic / SLOWEST + GRACE
    in_time = times[:, None] <= limit
    clean = ~np.logical_or.accumulate(touched, axis=0)
    good = near & in_time & clean
    return good.any(axis=0).astype(float)


CASES = {
    "single stories": rollouts_of(),
    # Two cars at exactly 0.30 m and at exactly t_max, and one that touches in that moment.
    "exactly at the limits": few_moments(
        [0.0, 5.0, 15.0, 20.0],
        [[3.0, 3.0, 3.0], [0.3, 2.0, 0.2], [0.9, 0.1, 0.0], [0.9, 2.0, 0.0]],
        3.0,
        (1, 2),
        (3, 1),
    ),
    # Two cars, of which one touches something then.
    "near in the last moment alone": few_moments(
        [0.0, 4.0, 8.0], [[2.0, 2.0, 0.1], [1.0, 1.0, 2.0], [0.2, 0.2, 3.0]], 2.0, (2, 1)
    ),
    "uneven times": random_rollouts(9, 40, 1),
    "as many moments as cars": random_rollouts(12, 12, 2),
    "one car": random_rollouts(30, 1, 11),
    "one moment": random_rollouts(1, 20, 4),
    "300 cars": random_rollouts(150, 300, 5),
    "a first moment 6 s after the start": few_moments(
        [6.0, 10.0, 20.0], [[1.0, 1.0], [1.0, 0.2], [0.1, 0.1]], 3.0
    ),
    "two cars that stay at their targets": few_moments([0.0, 1.0, 2.0], [[0.1, 0.1]] * 3, 1.0),
}
MISTAKES = """
every rollout counts as reached; three things must hold
    near & in_time & clean -> near | True
no rollout counts as reached; look at each moment
    near & in_time & clean -> near & False
a rollout that touched something has failed, even if it arrives
    near & in_time & clean -> near & in_time
what a car touches after it has arrived does not count: look at what was touched up to each moment
    np.logical_or.accumulate(touched, axis=0) -> touched.any(axis=0)
a rollout that touched something has failed, even if the car is free again when it arrives;
see np.logical_or.accumulate
    np.logical_or.accumulate(touched, axis=0) -> touched
a touch in the moment in which the car arrives counts, too
    accumulate(touched, -> accumulate(np.vstack([np.zeros_like(touched[:1]), touched[:-1]]),
a target that is reached after t_max does not count
    near & in_time & clean -> near & clean
t_max has 5 s on top: geodesic / 0.3 + 5
    + GRACE -> + 0
0.3 m/s is a speed: divide the geodesic by it
    geodesic / SLOWEST -> geodesic * SLOWEST
t_max is geodesic / 0.3 + 5: the 5 s come on top of the quotient
    geodesic / SLOWEST + GRACE -> (geodesic + GRACE) / SLOWEST
t_max is different for each car; it depends on its geodesic
    geodesic / -> geodesic.max() /
t_max is in seconds: compare it with times, not with the number of the row
    times[:, None] -> np.arange(len(times))[:, None]
a car that was at the target once has reached it: do not look only at the last moment
    near & in_time & clean -> (near & clean)[-1:]
a car that was at the target once has reached it: do not look only at the moment t_max
    near & in_time & clean -> np.take_along_axis(near & clean, row[None], axis=0)
    good = -> row = np.abs(times[:, None] - limit).argmin(axis=0); good =
a car that was at the target once has reached it: look at every moment, not at the last
    near & in_time & clean -> (near & in_time & clean)[-1:]
the nearest moment may come too late or after a touch, and an earlier one may be good: look
at every moment
    near & in_time & clean
        -> np.take_along_axis(near & in_time & clean, gaps.argmin(axis=0)[None], axis=0)
the moments lie unevenly: compare times with t_max, not 0.1 s times the number of the row
    times[:, None] -> 0.1 * np.arange(len(times))[:, None]
accumulate over the moments, axis=0, and not over the cars
    accumulate(touched, axis=0) -> accumulate(touched, axis=1)
argmax of a column without any True is 0: a car that is never near has no first moment
    near & in_time & clean -> np.take_along_axis(in_time & clean, near.argmax(axis=0)[None], axis=0)
a touch in the very first moment counts, too
    accumulate(touched, -> accumulate(np.vstack([np.zeros_like(touched[:1]), touched[1:]]),
near means within 0.30 m, not 0.5 m
    REACHED -> 0.5
near means within 0.30 m, not 0.25 m
    REACHED -> 0.25
the slowest speed is 0.3 m/s, not 0.5 m/s
    / SLOWEST -> / 0.5
t_max has 5 s on top, not 10 s
    GRACE -> 10
the moment of the start counts, too: a car may stand at its target
    good.any -> good[1:].any
the last moment counts, too
    good.any -> good[:-1].any
what was touched before the arrival counts, not what is touched after it
    accumulate(touched, axis=0) -> accumulate(touched[::-1], axis=0)[::-1]
each car has a t_max of its own, by its own geodesic, not that of their mean
    geodesic / -> geodesic.mean() /
exactly 0.30 m counts as near, too: at most
    gaps <= -> gaps <
exactly t_max is still in time: at t_max at the latest
    times[:, None] <= -> times[:, None] <
both limits count as inside: at most 0.30 m, at t_max at the latest
    gaps <= -> gaps <
    times[:, None] <= -> times[:, None] <
a rollout that touched something counts 0, not nan: it is a failure, not a gap in the data
    return good.any(axis=0).astype(float)
        -> return np.where(touched.any(axis=0) & ~good.any(axis=0), np.nan, good.any(axis=0))
near, in time and clean must hold at the same moment, not each at some moment
    near & in_time & clean -> near.any(0) & in_time.any(0) & clean.any(0, keepdims=True)
one good moment is enough: any, not all
    good.any -> good.all
1 is for those that arrive, 0 for those that do not
    return -> return 1 -
a label is 1 or 0, not the number of good moments
    good.any -> good.sum
"""
_HINTS: dict[type[Exception], str] = {
    ValueError: "times is (T,), geodesic (N,), the others are (T, N): times[:, None] is a column, "
    "with which limits (N,) make a table (T, N)",
    IndexError: "gaps and touched have a row for each moment and a column for each car",
    TypeError: "gaps and touched are arrays (T, N); tables of true and false are joined "
    "by &, |, ~, each comparison in parentheses: (a <= b) & (c <= d)",
}


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


def _first_wrong(got: Array, want: Array) -> int:
    return int(np.flatnonzero(~np.isclose(got, want, atol=1e-6))[0])


def _broken(got: Array, want: Array, *case: Array) -> str:
    """Which of the three conditions decides the first label that is wrong."""
    times, gaps, _, geodesic = case
    number = _first_wrong(got, want)
    near = gaps[:, number] <= REACHED
    if want[number]:
        return (
            "a single moment is enough, any from the first to the last: at most 0.30 m away, at "
            "most geodesic / 0.3 + 5 s after the start, and nothing touched until then"
        )
    if not near.any():
        return "a car that is never within 0.30 m, unrounded, has not reached its target"
    if not (near & (times <= time_limit(geodesic[number]))).any():
        return "it comes near too late: after geodesic / 0.3 + 5 s of its own geodesic, unrounded"
    return "whatever was touched up to the moment of arrival, in whichever moment, makes it 0"


def _worst(
    got: Array, want: Array, times: Array, gaps: Array, touched: Mask, geodesic: Array
) -> str:
    """What happens in the first rollout whose label is wrong."""
    number = _first_wrong(got, want)
    story = f'the rollout that "{STORIES[number][0]}"' if len(gaps) == 301 else f"car {number}"

    def first(moments: Mask, what: str, never: str) -> str:
        return f"{what} at {times[moments.argmax()]:.4g} s" if moments.any() else never

    near = first(gaps[:, number] <= REACHED, "first comes within 0.30 m", "never comes so near")
    touches = first(touched[:, number], "first touches something", "touches nothing")
    facts = f"it {near}, {touches}, and t_max is {time_limit(geodesic[number]):.4g} s"
    return f"{story} has the label {want[number]:.0f}, not {got[number]:.3g}: {facts}"


def _timelines(want: Array, got: Array) -> NDArray[np.uint8]:
    """A line for each story: when it is near, when it touches, its time limit, both labels."""
    times, gaps, touched, geodesic = rollouts_of()
    picture = np.full((40 + 28 * len(STORIES), 770, 3), 255, np.uint8)
    write = partial(label, picture, size=0.65)

    def across(time: float) -> int:
        return round(326 + 9.2 * time)

    write("green: within 0.30 m    orange: touches    bar: t_max", 4, 20, colour=colours.SOLID)
    write("expected", 620, 20, colour=colours.SOLID)
    write("yours", 712, 20, colour=colours.SOLID)
    for row, (story, limit) in enumerate(zip(STORIES, time_limit(geodesic), strict=True)):
        y = 48 + 28 * row
        write(story[0], 4, y + 6)
        for i, time in enumerate(times[:-1]):
            colour = colours.GOAL if gaps[i, row] <= REACHED else (215, 218, 222)
            cv2.rectangle(picture, (across(time), y - 2), (across(time + 0.1), y + 2), colour, -1)
        for time in times[touched[:, row]]:
            cv2.circle(picture, (across(time), y + 6), 2, colours.LASER, -1, cv2.LINE_AA)
        x = across(min(limit, times[-1]))
        cv2.line(picture, (x, y - 9), (x, y + 9), colours.INK, 2)
        write(f"{want[row]:.0f}", 648, y + 6)
        right = abs(got[row] - want[row]) < 1e-6
        write(f"{got[row]:.3g}", 728, y + 6, colour=colours.GOAL if right else colours.LASER)
    return picture


check_rollout_labels = exercise(
    rollout_labels,
    CASES,
    MISTAKES,
    about="In time and too late, past the target, along walls, exactly at limits, and 400 more.",
    example=case(np.arange(300.0), np.ones((300, 400)), np.zeros((300, 400), bool), np.ones(400)),
    invoke=calling(_HINTS),
    form=_form,
    same=lambda got, want, *_: np.allclose(got, want, atol=1e-6, equal_nan=True),
    difference=_worst,
    broken=_broken,
    draw=_timelines,
)
