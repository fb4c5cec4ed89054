"""The check of matching two scans, in notebook 10: judged by the pose that is found."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, calling, exercise, numbers
from tutorial_lib.checks.nb10.fits import fit
from tutorial_lib.checks.nb10.small_rooms import scan
from tutorial_lib.geometry import Array
from tutorial_lib.se2 import relative, wrap

NEAR, TURNED = 0.1, float(np.deg2rad(3.0))
"""Metres and rad by which an answer may be off."""
_OFF, _ASKEW = 0.5, float(np.deg2rad(15.0))  # of guesses, at most
_GRID = np.stack(np.meshgrid(*[np.arange(-2.0, 3.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
_STEP = np.array([0.3, 0.3, np.deg2rad(10.0)])


def match(node: NDArray, seen: NDArray, guess: Array) -> Array:
    """The pose (3,) near a guess (3,) at which two scans (B,) fit best; see the exercise."""
    pose = guess
    for shrink in 0.5 ** np.arange(4):
        poses = pose + _GRID * _STEP * shrink
        pose = poses[fit(node, seen, poses).argmax()]
    return pose


def _case(
    room: str, node: tuple[float, ...], there: tuple[float, ...], off: tuple[float, ...]
) -> tuple[Array, Array, Array]:
    """Scans of a room at the pose of a node and at another one, and a guess that is off."""
    first, second = np.array(node), np.array(there)
    found = relative(first, second)
    askew = np.deg2rad(off[2])
    return scan(room, first), scan(room, second), found + np.array([off[0], off[1], askew])


def _random(seed: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng([seed, 10])
    room, (x, y) = (
        ("a room with a cupboard", (2.0, 1.6)),
        ("a room with a corner", (1.6, 1.4)),
        ("a small room", (1.3, 1.2)),
        ("a wide hall", (3.0, 2.4)),
    )[seed % 4]
    poses = np.column_stack(
        [x + rng.uniform(-0.6, 0.6, 2), y + rng.uniform(-0.6, 0.6, 2), rng.uniform(-3, 3, 2)]
    )
    angle, far = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, _OFF)
    off = far * np.cos(angle), far * np.sin(angle), np.rad2deg(rng.uniform(-_ASKEW, _ASKEW))
    return _case(room, tuple(poses[0]), tuple(poses[1]), off)


CASES = {
    "a metre from the node, odometry a little off": _case(
        "a room with a cupboard", (2.0, 1.5, 0.0), (2.9, 1.9, 0.0), (0.2, -0.1, 5.0)
    ),
    "odometry that is right": _case(
        "a room with a corner", (1.5, 1.2, 0.5), (2.2, 1.4, 0.2), (0.0, 0.0, 0.0)
    ),
    "a heading that is 14 degrees off": _case(
        "a room with a cupboard", (2.0, 2.0, 1.0), (2.6, 1.6, 0.4), (0.0, 0.0, 14.0)
    ),
    "a place that is half a metre off": _case(
        "a room with a corner", (1.8, 1.2, 0.0), (1.2, 2.2, 0.8), (0.35, 0.35, 0.0)
    ),
    "the place itself, half a metre off": _case(
        "a small room", (1.2, 1.2, 0.0), (1.2, 1.2, 0.3), (-0.49, 0.0, -8.0)
    ),
    "a robot that looks back": _case(
        "a room with a corner", (1.5, 1.5, 0.0), (2.0, 1.0, 3.0), (0.2, 0.3, 12.0)
    ),
    "a corridor with doors, from one side of them to the other": _case(
        "a corridor with doors", (-0.4, 0.8, 0.0), (0.7, 0.8, 0.1), (0.4, 0.0, -5.0)
    ),
    "a square room, of which only the guess says which corner is which": _case(
        "a square room", (2.6, 1.6, 0.0), (1.4, 2.2, 1.5), (0.2, 0.2, 8.0)
    ),
    **{f"at random ({seed})": _random(seed) for seed in range(6)},
}
MISTAKES = """
that's the guess itself; look around it for the pose that fits best
    return pose -> return guess
the best pose of one grid is too coarse; search again around it, with smaller steps
    np.arange(4) -> np.arange(1)
the best pose has the highest fit, not the lowest
    argmax -> argmin
the heading drifts, too: try others
    _GRID * _STEP -> _GRID * _STEP * np.array([1, 1, 0])
the place drifts, too: try others
    _GRID * _STEP -> _GRID * _STEP * np.array([0, 0, 1])
search around the guess: the robot is somewhere there, and not at the node
    pose = guess -> pose = np.zeros(3)
the first scan is the node's, the second the robot's; yours has them the other way round
    fit(node, seen, poses) -> fit(seen, node, poses)
return the pose itself, not what was added to the guess
    return pose -> return pose - guess
return the pose of the robot in the node's frame, not the node in the robot's
    return pose -> return relative(pose, np.zeros(3))
return where the robot is in the node's frame, not in that of the guess
    return pose -> return relative(guess, pose)
the heading comes back in degrees: np.deg2rad makes radians of them
    return pose -> return pose * np.array([1, 1, 180 / np.pi])
headings are in radians; yours tries degrees
    _GRID * _STEP -> _GRID * _STEP * np.array([1, 1, 180 / np.pi])
steps that begin so small get stuck: what you try first reaches 0.5 m and 15 degrees
    _STEP * shrink -> _STEP * shrink * 0.2
stay near the guess: farther away another corner may look the same
    _STEP * shrink -> _STEP * shrink * np.array([5, 5, 9])
take smaller steps from round to round
    _STEP * shrink -> _STEP
"""


def _gap(got: Array, want: Array) -> tuple[float, float]:
    """Metres and rad between two poses."""
    off = got - want
    return float(np.hypot(off[0], off[1])), abs(float(wrap(off[2])))


def _form(what: str, got: object, *_: object) -> Array:
    if isinstance(got, tuple) and np.shape(got[:1]) == (1, 3):
        raise WrongAnswer(f"{what}: {len(got)} things came back; return the pose alone")
    return numbers(what, got, (3,))


def _same(got: Array, want: Array, *_: object) -> bool:
    metres, turn = _gap(got, want)
    return metres <= NEAR and turn <= TURNED


def _difference(got: Array, want: Array, node: NDArray, seen: NDArray, guess: Array) -> str:
    metres, turn = _gap(got, want)
    fits = fit(node, seen, np.array([got, want]))
    return (
        f"{metres:.2f} m and {np.rad2deg(turn):.0f} degrees off; it fits to {fits[0]:.2f} there, "
        f"and to {fits[1]:.2f} where it is"
    )


def _broken(got: Array, want: Array, node: NDArray, seen: NDArray, guess: Array) -> str:
    metres, turn = _gap(got, guess)
    if turn > np.deg2rad(40) and _same(got * np.array([1.0, 1.0, np.pi / 180]), want):
        return "the heading comes back in degrees: np.deg2rad makes radians of them"
    if metres > 1.0 or turn > np.deg2rad(40):
        return "stay near the guess, which is at most 0.5 m and 15 degrees off"
    fits = fit(node, seen, np.array([got, want]))
    metres, turn = _gap(got, want)
    if metres <= NEAR and turn > TURNED:
        return "the place is right, the heading isn't: are your steps in radians, and small enough?"
    if fits[0] < fits[1] - 0.02:
        return "another pose near the guess fits better: try more of them, and smaller steps"
    return "the fit is as good, but it's another place: which one did the guess mean?"


check_match = exercise(
    match,
    CASES,
    MISTAKES,
    about="Rooms, a corridor with doors, and guesses that are up to half a metre off.",
    example=_random(5),
    calls=1_500,
    invoke=calling({TypeError: "fit(node, seen, poses) takes poses (P, 3), a row for each"}),
    form=_form,
    same=_same,
    difference=_difference,
    broken=_broken,
)
