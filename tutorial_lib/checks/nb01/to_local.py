"""The check of points in the robot's frame, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.geometry import Array


def _turned(heading: float, offsets: Array) -> Array:
    """Offsets (N, 2) rotated by a heading."""
    return geometry.to_world(np.array([0.0, 0.0, heading]), offsets)


def _by_new_x(pose: Array, points: Array) -> Array:
    offset, cos, sin = points - pose[:2], np.cos(pose[2]), np.sin(pose[2])
    ahead = cos * offset[:, 0] + sin * offset[:, 1]
    return np.stack([ahead, cos * offset[:, 1] - sin * ahead], axis=1)


def _y_from_x(pose: Array, points: Array) -> Array:
    offset, cos, sin = points - pose[:2], np.cos(pose[2]), np.sin(pose[2])
    ahead = cos * offset[:, 0] + sin * offset[:, 1]
    return np.stack([ahead, cos * offset[:, 0] - sin * offset[:, 1]], axis=1)


def _polar(pose: Array, points: Array) -> Array:
    x, y = (points - pose[:2]).T
    return np.stack([np.hypot(x, y), np.arctan2(y, x) - pose[2]], axis=1)


_FAULTS = {
    "the robot's frame is turned the wrong way; use minus the heading": (
        lambda pose, points: _turned(pose[2], points - pose[:2])
    ),
    "subtract the robot's position before you turn": (
        lambda pose, points: _turned(-pose[2], points)
    ),
    "in the wrong order: shift first, then turn": (
        lambda pose, points: _turned(-pose[2], points) - pose[:2]
    ),
    "the robot's position is added; subtract it": (
        lambda pose, points: _turned(-pose[2], points + pose[:2])
    ),
    "the offset is from the point to the robot; it must be point minus robot": (
        lambda pose, points: _turned(-pose[2], pose[:2] - points)
    ),
    "the points are shifted but not turned; undo the heading": (
        lambda pose, points: points - pose[:2]
    ),
    "headings are in radians; do not convert them from degrees": (
        lambda pose, points: _turned(-np.deg2rad(pose[2]), points - pose[:2])
    ),
    "headings are in radians; do not convert them to degrees": (
        lambda pose, points: _turned(-np.rad2deg(pose[2]), points - pose[:2])
    ),
    "y points to the right here; it must be positive to the left": (
        lambda pose, points: geometry.to_local(pose, points) * [1, -1]
    ),
    "left first, then ahead; it is metres ahead first, then metres to the left": (
        lambda pose, points: geometry.to_local(pose, points)[:, ::-1]
    ),
    "polar coordinates (distance and angle) came back; metres ahead and to the left are asked": (
        _polar
    ),
    "the new x stands in the formula of the new y; keep the old offset until both are done": (
        _by_new_x
    ),
    "the sign of the heading is lost: a negative heading is a turn to the right": (
        lambda pose, points: _turned(-abs(pose[2]), points - pose[:2])
    ),
    "points behind the robot lie at a negative x; do not cut or drop the sign": (
        lambda pose, points: np.maximum(geometry.to_local(pose, points), [0, -np.inf])
    ),
    "points to the right of the robot lie at a negative y; do not drop the sign": (
        lambda pose, points: (
            np.abs(geometry.to_local(pose, points) * [0, 1])
            + geometry.to_local(pose, points) * [1, 0]
        )
    ),
    "the formula of the new y is that of x with another sign; it is cos * dy - sin * dx": (
        _y_from_x
    ),
    "the heading goes through an arctan, which takes half a turn from some": (
        lambda pose, points: _turned(-np.arctan(np.tan(pose[2])), points - pose[:2])
    ),
}


def _topics() -> list[Topic]:
    rng = np.random.default_rng(1)
    up = np.array([0.0, 0.0, np.pi / 2])
    poses = rng.uniform([-5, -5, -7], [5, 5, 7], (20, 3))
    return [
        Topic(
            "a robot at the origin with heading 0",
            "its frame is that of the world: each point comes back as it is, in its own row",
            [(np.zeros(3), rng.uniform(-4, 4, (5, 2)))],
        ),
        Topic(
            "a robot at (2, -1) with heading 0",
            "this needs only the shift: subtract x from x and y from y",
            [(np.array([2.0, -1.0, 0.0]), rng.uniform(-4, 4, (5, 2)))],
        ),
        Topic(
            "a robot at the origin that faces +y, and a point 1 m up",
            "the point is straight ahead, so its local coordinates are (1, 0)",
            [(up, np.array([[0.0, 1.0]]))],
        ),
        Topic(
            "a robot at the origin that faces +y, and a point 1 m to the west",
            "the point is to the robot's left, so its local coordinates are (0, 1)",
            [(up, np.array([[-1.0, 0.0]]))],
        ),
        Topic(
            "a robot at (1, 2) with heading +0.7, and five points on all sides",
            "shift first, then two dot products: one with the robot's heading, one with its left",
            [(np.array([1.0, 2.0, 0.7]), rng.uniform(-4, 4, (5, 2)))],
        ),
        Topic(
            "a robot with a negative heading",
            "a negative heading is a turn to the right; the same formula holds",
            [(np.array([1.0, 2.0, -0.7]), rng.uniform(-4, 4, (5, 2)))],
        ),
        Topic(
            "points at whole numbers of metres",
            "their local coordinates have digits: np.zeros_like and astype take over the type of "
            "whole numbers, which cuts them off",
            [(np.array([1.0, 2.0, 0.7]), np.array([[2, 1], [-1, 3], [0, 0]]))],
        ),
        Topic(
            "points within 5 cm of the robot, and a heading of 0.03",
            "a near point is a point like any other, and a small turn a turn: leave nothing out",
            [(np.array([1.0, 2.0, 0.03]), np.array([[1.03, 2.02], [0.96, 1.99], [1.001, 2.0]]))],
        ),
        Topic(
            "20 random poses with one to nine points",
            "the simple cases are right; does a part of your formula hold for some headings only?",
            [(pose, rng.uniform(-9, 9, (1 + i % 9, 2))) for i, pose in enumerate(poses)],
        ),
    ]


@check(geometry.to_local, (np.array([1.0, 2.0, 0.5]), np.ones((100, 2))))
def check_to_local(student: Callable[..., Array]) -> None:
    """Points of the world in the robot's frame."""
    judge_topics("to_local", student, _topics(), geometry.to_local, _FAULTS, form=_form)


def _form(what: str, answer: object, pose: Array, points: Array) -> Array:
    return numbers(what, answer, points.shape)
