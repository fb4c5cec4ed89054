"""The check of the correction that follows from a match, in notebook 10."""

import numpy as np

from tutorial_lib.checks.engine import calling, exercise, numbers
from tutorial_lib.geometry import Array
from tutorial_lib.se2 import compose, inverse, wrap


def correct(node: Array, pose: Array, odometry: Array) -> Array:
    """The correction (3,) after which odometry says where the robot is; see the exercise."""
    here = compose(node, pose)
    return compose(here, inverse(odometry))


def _off_by(metres: float, degrees: float) -> tuple[Array, Array, Array]:
    """A robot beside a node whose odometry is off by little."""
    node, pose = np.array([2.0, 1.0, 0.7]), np.array([0.6, -0.3, 0.2])
    drift = np.array([0.8 * metres, -0.6 * metres, np.deg2rad(degrees)])
    return node, pose, compose(compose(node, pose), drift)


def _random(seed: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng([seed, 31])
    node, pose = rng.uniform(-4, 4, 3), rng.uniform(-2, 2, 3)
    drift = np.array([*rng.uniform(-1, 1, 2), rng.uniform(-2, 2)])
    return node, pose, compose(drift, compose(node, pose))


def _poses(*poses: tuple[float, float, float]) -> tuple[Array, ...]:
    return tuple(map(np.array, poses))


CASES = {
    "a robot at the node, 1 m off by odometry": _poses(
        (2.0, 1.0, 0.0), (0.0, 0.0, 0.0), (3.0, 1.0, 0.0)
    ),
    "a robot a metre from the node": _poses((2.0, 1.0, 0.0), (1.0, 0.0, 0.0), (2.5, 1.5, 0.0)),
    "a heading that is off": _poses((2.0, 1.0, 0.0), (1.0, 0.0, 0.0), (3.0, 1.0, np.pi / 2)),
    "a node that looks to the left": _poses(
        (2.0, 1.0, np.pi / 2), (1.0, 0.5, -0.5), (1.0, 2.0, 0.7)
    ),
    "odometry that is right": (
        np.array([1.0, -2.0, 0.4]),
        np.array([0.5, 0.5, 1.0]),
        compose(np.array([1.0, -2.0, 0.4]), np.array([0.5, 0.5, 1.0])),
    ),
    "odometry that is 4 cm and 2 degrees off": _off_by(0.04, 2.0),
    "odometry that is 1 cm off": _off_by(0.01, 0.0),
    "a heading that is 1 degree off": _off_by(0.0, 1.0),
    **{f"at random ({seed})": _random(seed) for seed in range(6)},
}
MISTAKES = """
the correction goes before the odometry: compose(correction, odometry), not the other way round
    compose(here, inverse(odometry)) -> compose(inverse(odometry), here)
from the odometry to the map; yours goes from the map back to the odometry
    compose(here, inverse(odometry)) -> compose(odometry, inverse(here))
poses aren't subtracted number by number: once the heading is off, the place turns with it
    compose(here, inverse(odometry)) -> here - odometry
the place is off, too, not the heading alone
    compose(here, inverse(odometry)) -> np.array([0, 0, here[2] - odometry[2]])
the heading is off, too, not the place alone
    compose(here, inverse(odometry)) -> np.array([*(here - odometry)[:2], 0])
pose is in the node's frame: bring it onto the map with the node's own pose
    compose(node, pose) -> pose
the robot isn't at the node, but at `pose` in its frame
    compose(node, pose) -> node
first the node, then the pose in it: compose(node, pose)
    compose(node, pose) -> compose(pose, node)
that's where the robot is, and not what the odometry must be moved by
    return compose(here, inverse(odometry)) -> return here
undo the odometry first: its inverse
    inverse(odometry) -> odometry
pose is the robot in the node's frame; yours takes it for the node in the robot's frame
    compose(node, pose) -> compose(node, inverse(pose))
a small error of odometry is an error too: correct it
    here = compose(node, pose)
        -> here = compose(node, pose); off = np.abs(compose(inverse(here), odometry)).max()
    inverse(odometry)) -> inverse(odometry)) * (off > 0.0524)
the heading is in radians
    inverse(odometry)) -> inverse(odometry)) * np.array([1, 1, 180 / np.pi])
"""


def _same(got: Array, want: Array, *_: object) -> bool:
    off = got - want
    return bool(np.abs(off[:2]).max() < 1e-6 and abs(float(wrap(off[2]))) < 1e-6)


def _difference(got: Array, want: Array, node: Array, pose: Array, odometry: Array) -> str:
    true, here = compose(node, pose), compose(got, odometry)
    metres = np.hypot(*(here - true)[:2])
    turn = np.rad2deg(abs(float(wrap(here[2] - true[2]))))
    return (
        f"with your correction the robot is {metres:.2f} m and {turn:.0f} degrees from where it is"
    )


def _broken(got: Array, want: Array, *_: Array) -> str:
    if not got.any() and np.abs(want).max() < 0.2:
        return "a small error of odometry is an error too: correct it"
    return "compose(correction, odometry) must be where the robot is on the map"


check_correct = exercise(
    correct,
    CASES,
    MISTAKES,
    about="Robots at a node and beside it, with places and headings that are off.",
    example=_random(1),
    calls=1_500,
    invoke=calling(),
    form=lambda what, got, *_: numbers(what, got, (3,)),
    same=_same,
    difference=_difference,
    broken=_broken,
)
