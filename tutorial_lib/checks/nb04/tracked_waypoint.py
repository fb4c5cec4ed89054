"""The check of a waypoint that is tracked by odometry, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array, to_local, to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.figures.panels import side_by_side


def tracked_waypoint(then: ArrayLike, waypoint: ArrayLike, now: ArrayLike) -> Array:
    """Waypoints (..., 2) predicted at odometry poses `then` (..., 3), in the frame of `now`."""
    return to_local(now, to_world(then, waypoint))


_THEN = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 0.7], [-2.0, 0.5, 2.6]])


_PREDICTED = np.array([[1.5, 0.0], [1.2, -0.4], [1.0, 0.5], [0.8, -0.9]])


_NOW = np.array([[0.6, 0.1, 0.4], [1.7, 1.9, -0.5], [1.4, 2.5, 1.4], [-2.3, 0.9, -2.9]])


_CASES = (
    ("nothing has moved", _THEN, _THEN),
    ("shifted and turned", _THEN, _NOW),
    ("shifted, but not turned", _THEN, np.column_stack([_NOW[:, :2], _THEN[:, 2]])),
    ("turned on the spot", _THEN, np.column_stack([_THEN[:, :2], _NOW[:, 2]])),
)


@check(
    tracked_waypoint,
    (np.tile(_THEN, (25, 1)), np.tile(_PREDICTED, (25, 1)), np.tile(_NOW, (25, 1))),
)
def check_tracked_waypoint(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """A waypoint as predicted, after a shift, after a turn, and after both; one and many."""
    one = student(_THEN[2], _PREDICTED[2], _NOW[2])
    want = tracked_waypoint(_THEN[2], _PREDICTED[2], _NOW[2])
    picture = side_by_side([_seen_from_above(want), _seen_from_above(one)], ["target", "yours"])
    cases = [(f"four cars, {name}", then, _PREDICTED, now) for name, then, now in _CASES]
    for name, then, waypoint, now in [*cases, ("one car", _THEN[2], _PREDICTED[2], _NOW[2])]:
        got, want = call(student, then, waypoint, now), tracked_waypoint(then, waypoint, now)
        what = f"tracked_waypoint, {name}"
        expect_close(what, got, want, 1e-6, _mistakes(then, waypoint, now), picture)
    return picture


def _mistakes(then: Array, waypoint: Array, now: Array) -> dict[str, Array]:
    """Known mistakes, and the waypoints they give."""
    place, shift = to_world(then, waypoint), now[..., :2] - then[..., :2]
    turned = to_world(np.concatenate([0 * shift, then[..., 2:]], axis=-1), waypoint)
    return {
        "that is the waypoint as it was predicted; the car has moved since": waypoint,
        "that is the place in the odometer's frame; give it in the frame of now: to_local": place,
        "the waypoint was predicted in the frame of then: to_world(then, waypoint) first": to_local(
            now, waypoint
        ),
        "then and now are exchanged": to_local(then, to_world(now, waypoint)),
        "the car has turned as well; a shift is not enough": waypoint - shift,
        "the shift is measured along the odometer's axes, and the waypoint along the car's": (
            to_local(
                np.concatenate([0 * shift, now[..., 2:] - then[..., 2:]], axis=-1), waypoint - shift
            )
        ),
        "shifted, but not turned by the heading of now: to_local": turned - shift,
    }


def _seen_from_above(waypoint: object) -> NDArray[np.uint8]:
    """The car then and now, the waypoint as predicted then, and as tracked now."""
    picture = np.full((300, 330, 3), 255, np.uint8)

    def at(point: Array) -> tuple[int, int]:
        return round(150 * (point[0] - 0.4)), round(290 - 150 * (point[1] - 1.8))

    for name, pose, colour in (
        ("then", _THEN[2], colours.FAINT),
        ("now", _NOW[2], colours.ROBOT),
    ):
        ahead, (column, row) = to_world(pose, [0.3, 0.0]), at(pose)
        cv2.circle(picture, (column, row), 9, colour, cv2.FILLED, cv2.LINE_AA)
        cv2.line(picture, at(pose), at(ahead), colour, 4, cv2.LINE_AA)
        label(picture, name, column + 16, row + 12, 0.5, colour)
    meant = to_world(_THEN[2], _PREDICTED[2])
    cv2.line(picture, at(_THEN[2]), at(meant), colours.FAINT, 1, cv2.LINE_AA)
    cv2.circle(picture, at(meant), 8, colours.FAINT, 2, cv2.LINE_AA)
    label(picture, "the place that was meant", at(meant)[0] - 100, at(meant)[1] - 18, 0.5)
    try:
        point = np.asarray(waypoint, dtype=float)
    except (TypeError, ValueError):
        return picture
    if point.shape == (2,) and np.isfinite(point).all() and np.abs(point).max() < 5:
        place = to_world(_NOW[2], point)
        cv2.line(picture, at(_NOW[2]), at(place), colours.GOAL, 2, cv2.LINE_AA)
        cv2.circle(picture, at(place), 5, colours.GOAL, cv2.FILLED, cv2.LINE_AA)
    return picture
