"""The check of points in the robot's frame, in notebook 01."""

import numpy as np

from tutorial_lib.checks.engine import case, exercise, hint, numbers, topics
from tutorial_lib.se2 import to_local

_RNG = np.random.default_rng(1)
_POSES = _RNG.uniform([-5, -5, -7], [5, 5, 7], (20, 3))
_UP = np.array([0.0, 0.0, np.pi / 2])
TOPICS = {
    "a robot at the origin with heading 0": hint(
        "its frame is that of the world: each point comes back as it is, in its own row",
        case(np.zeros(3), _RNG.uniform(-4, 4, (5, 2))),
        case(np.zeros(3), np.array([[1.0, 2.0], [0.5, -1.0], [1.0, 2.0]])),
    ),
    "a robot at (2, -1) with heading 0": hint(
        "this needs only the shift: subtract x from x and y from y",
        case(np.array([2.0, -1.0, 0.0]), _RNG.uniform(-4, 4, (5, 2))),
    ),
    "a robot at the origin that faces +y, and a point 1 m up": hint(
        "the point is straight ahead, so its local coordinates are (1, 0)",
        case(_UP, np.array([[0.0, 1.0]])),
    ),
    "a robot at the origin that faces +y, and a point 1 m to the west": hint(
        "the point is to the robot's left, so its local coordinates are (0, 1)",
        case(_UP, np.array([[-1.0, 0.0]])),
    ),
    "a robot at (1, 2) with heading +0.7, and five points on all sides": hint(
        "shift first, then two dot products: one with the robot's heading, one with its left",
        case(np.array([1.0, 2.0, 0.7]), _RNG.uniform(-4, 4, (5, 2))),
    ),
    "a robot with a negative heading": hint(
        "a negative heading is a turn to the right; the same formula holds",
        case(np.array([1.0, 2.0, -0.7]), _RNG.uniform(-4, 4, (5, 2))),
    ),
    "points at whole numbers of metres": hint(
        "their local coordinates have digits: np.zeros_like and astype take over the type of "
        "whole numbers, which cuts them off",
        case(np.array([1.0, 2.0, 0.7]), np.array([[2, 1], [-1, 3], [0, 0]])),
        case(np.array([0.5, 0.5, 0.0]), np.array([[1, 2], [3, 4]])),
    ),
    "points within 5 cm of the robot, and a heading of 0.03": hint(
        "a near point is a point like any other, and a small turn a turn: leave nothing out",
        case(np.array([1.0, 2.0, 0.03]), np.array([[1.03, 2.02], [0.96, 1.99], [1.001, 2.0]])),
    ),
    "20 random poses with one to nine points": hint(
        "the simple cases are right; does a part of your formula hold for some headings only?",
        *(case(pose, _RNG.uniform(-9, 9, (1 + i % 9, 2))) for i, pose in enumerate(_POSES)),
    ),
    "70 points": hint(
        "each point has its own row, however many there are: write no number in its place",
        case(np.array([1.0, 2.0, 0.7]), _RNG.uniform(-4, 4, (70, 2))),
    ),
}
MISTAKES = """
the robot's frame is turned the wrong way; use minus the heading
    np.sin(pose[..., 2]) -> -np.sin(pose[..., 2])
subtract the robot's position before you turn
    points[..., 0] - pose[..., 0], points[..., 1] - pose[..., 1] -> points[..., 0], points[..., 1]
in the wrong order: shift first, then turn
    points[..., 0] - pose[..., 0], points[..., 1] - pose[..., 1] -> points[..., 0], points[..., 1]
    axis=-1) -> axis=-1) - pose[..., :2]
the robot's position is added; subtract it
    points[..., 0] - -> points[..., 0] +
    points[..., 1] - -> points[..., 1] +
the offset is from the point to the robot; it must be point minus robot
    return np.stack -> return -np.stack
the points are shifted but not turned; undo the heading
    [cos * dx + sin * dy, cos * dy - sin * dx] -> [dx, dy]
headings are in radians; do not convert them from degrees
    np.asarray(pose, dtype=float) -> pose * [1, 1, np.pi / 180]
headings are in radians; do not convert them to degrees
    np.asarray(pose, dtype=float) -> pose * [1, 1, 180 / np.pi]
y points to the right here; it must be positive to the left
    cos * dy - sin * dx -> sin * dx - cos * dy
left first, then ahead; it is metres ahead first, then metres to the left
    [cos * dx + sin * dy, cos * dy - sin * dx] -> [cos * dy - sin * dx, cos * dx + sin * dy]
polar coordinates (distance and angle) came back; metres ahead and to the left are asked
    [cos * dx + sin * dy, cos * dy - sin * dx]
        -> [np.hypot(dx, dy), np.arctan2(dy, dx) - pose[..., 2]]
the new x stands in the formula of the new y; keep the old offset until both are done
    cos * dy - sin * dx -> cos * dy - sin * (cos * dx + sin * dy)
the sign of the heading is lost: a negative heading is a turn to the right
    np.sin(pose[..., 2]) -> np.sin(abs(pose[..., 2]))
points behind the robot lie at a negative x; do not cut or drop the sign
    cos * dx + sin * dy -> np.maximum(cos * dx + sin * dy, 0)
points to the right of the robot lie at a negative y; do not drop the sign
    cos * dy - sin * dx -> abs(cos * dy - sin * dx)
the formula of the new y is that of x with another sign; it is cos * dy - sin * dx
    cos * dy - sin * dx -> cos * dx - sin * dy
the heading goes through an arctan, which takes half a turn from some
    np.cos(pose[..., 2]), np.sin(pose[..., 2])
        -> np.cos(np.arctan(np.tan(pose[..., 2]))), np.sin(np.arctan(np.tan(pose[..., 2])))
"""
check_to_local = exercise(
    to_local,
    topics(TOPICS),
    MISTAKES,
    about="Points of the world in the robot's frame.",
    example=case(np.array([1.0, 2.0, 0.5]), np.ones((100, 2))),
    form=lambda what, answer, pose, points: numbers(what, answer, points.shape),
)
