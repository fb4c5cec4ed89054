"""The labels of rollouts, and mistakes with them, in notebook 03."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.nb03.rollout_stories import Case
from tutorial_lib.driving.metrics import GRACE, REACHED, SLOWEST, time_limit
from tutorial_lib.geometry import Array

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


def _first_near(near: Touches, time: Touches, clean: Touches, *case: Array) -> Array:
    row, cars = near.argmax(axis=0), np.arange(near.shape[1])
    return (time & clean)[row, cars].astype(float)


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


FAULTS: dict[str, Callable[..., Array]] = {
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
    "argmax of a column without any True is 0: a car that is never near has no first moment": (
        _with(_first_near)
    ),
    "a touch in the very first moment counts, too": _with(_late_start),
    "near means within 0.30 m, not 0.5 m": _another(near=0.5),
    "near means within 0.30 m, not 0.25 m": _another(near=0.25),
    "the slowest speed is 0.3 m/s, not 0.5 m/s": _another(slowest=0.5),
    "t_max has 5 s on top, not 10 s": _another(grace=10.0),
    "the moment of the start counts, too: a car may stand at its target": _with(
        lambda near, time, clean, *_: _labels((near & time & clean)[1:])
    ),
    "the last moment counts, too": _with(
        lambda near, time, clean, *_: _labels((near & time & clean)[:-1])
    ),
    "what was touched before the arrival counts, not what is touched after it": _with(
        lambda near, time, _, *case: _labels(near & time & ~_so_far(case[2][::-1])[::-1])
    ),
    "each car has a t_max of its own, by its own geodesic, not that of their mean": (
        lambda t, g, c, d: _labels(
            (g <= REACHED) & (t[:, None] <= time_limit(d.mean())) & ~_so_far(c)
        )
    ),
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
