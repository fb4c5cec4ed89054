"""The check of which matches are believed, in notebook 10: judged by what is let through."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, calling, exercise, kind
from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.checks.nb10.fits import fit
from tutorial_lib.checks.nb10.match import match
from tutorial_lib.checks.nb10.small_rooms import scan
from tutorial_lib.geometry import Array
from tutorial_lib.se2 import compose, relative, wrap


def accept(node: NDArray, seen: NDArray, guess: Array, pose: Array) -> bool:
    """Whether a match at a pose (3,) is believed; see the exercise."""
    gap = relative(guess, pose)
    bearings = np.deg2rad(np.arange(0, 360, 5))
    aside = 0.5 * np.stack([np.cos(bearings), np.sin(bearings), 0 * bearings], axis=1)
    here, around = fit(node, seen, pose[None])[0], fit(node, seen, pose + aside)
    near = np.hypot(gap[0], gap[1]) <= 1.0 and abs(wrap(gap[2])) <= np.deg2rad(30.0)
    return bool(near and here >= 0.75 and around.max() < here - 0.1)


Case = tuple[Array, Array, Array, Array]


def _matched(room: str, node: tuple[float, ...], there: tuple[float, ...], *off: float) -> Case:
    """A match as it is found from a guess that is off."""
    first, second = np.array(node), np.array(there)
    scans, true = (scan(room, first), scan(room, second)), relative(first, second)
    guess = true + np.array([off[0], off[1], np.deg2rad(off[2])])
    return *scans, guess, match(*scans, guess)


def _elsewhere(room: str, other: str, node: tuple[float, ...], there: tuple[float, ...]) -> Case:
    """The best match of scans of two rooms."""
    scans = scan(room, np.array(node)), scan(other, np.array(there))
    pose = match(*scans, np.array([0.4, -0.3, 0.2]))
    return *scans, pose + np.array([0.1, 0.1, 0.05]), pose


def _moved(case: Case, x: float, y: float, degrees: float) -> Case:
    """A match, with a guess that is as far off."""
    node, seen, _, pose = case
    return node, seen, pose + np.array([x, y, np.deg2rad(degrees)]), pose


def _drifted(case: Case, x: float, y: float) -> Case:
    """A match, and odometry from which it lies as far ahead and to the left."""
    node, seen, _, pose = case
    return node, seen, compose(pose, np.array([-x, -y, 0.0])), pose


def _wrong(case: Case, x: float, y: float, degrees: float) -> Case:
    """A pose beside the match, and a guess that agrees with it."""
    node, seen, _, pose = case
    pose = pose + np.array([x, y, np.deg2rad(degrees)])
    return node, seen, pose + np.array([0.1, 0.1, 0.05]), pose


def _turned(case: Case, turn: float) -> Case:
    """The same match, of a robot whose heading in the node's frame is `turn`."""
    node, seen, guess, pose = case
    beams = len(seen)
    steps = round((turn - pose[2]) * beams / (2 * np.pi))
    by = steps * 2 * np.pi / beams
    ends = [np.array([*one[:2], wrap(one[2] + by)]) for one in (guess, pose)]
    return node, np.roll(seen, steps), ends[0], ends[1]


_ROOM = _matched("a room with a cupboard", (2.0, 1.5, 0.3), (2.8, 2.0, 0.9), 0.3, -0.2, 8)
_CORNER = _matched("a room with a corner", (1.5, 1.5, 0.0), (2.2, 1.1, 0.4), -0.2, 0.3, -10)
_SMALL = _matched("a small room", (1.1, 1.2, 2.0), (1.6, 1.5, 1.0), 0.3, 0.3, 12)
_DOORS = _matched("a corridor with doors", (-0.6, 0.8, 0.0), (0.6, 0.8, 0.2), 0.3, 0.0, 5)
_FAR = _matched("a room with a corner", (1.2, 3.6, 0.0), (3.6, 1.2, 0.2), 0.3, 0.2, -6)


def _across(turn: float) -> Case:
    """A bare corridor, seen by a node that looks aside from it by `turn` rad."""
    first = (0.0, 0.8, -turn)
    return _matched("a bare corridor", first, (0.7, 0.9, 0.2), 0.2, 0.1, 5)


_OBLIQUE = (15.0, 58.5, 79.0, 129.0, -20.0)
"""Degrees of corridors: of up to 40 directions all around, one of these lies between two."""

CASES: dict[str, tuple[Any, ...]] = {
    "a room": _ROOM,
    "a bare corridor": _across(0.0),
    "another room": _elsewhere(
        "a room with a cupboard", "a small room", (2.0, 1.5, 0.3), (1.3, 1.4, 0.0)
    ),
    "a room with a corner": _CORNER,
    "a small room": _SMALL,
    "a place beside the right one": _wrong(_ROOM, 0.45, 0.3, 0),
    "a heading beside the right one": _wrong(_CORNER, 0.0, 0.0, 25),
    "a match 2 m from where odometry says": _moved(_ROOM, 1.6, -1.2, 5),
    "a match 1.4 m from where odometry says": _moved(_CORNER, -1.0, 1.0, -5),
    "a match 1.2 m from where odometry says, ahead and beside it": _drifted(_ROOM, 0.85, 0.85),
    "a match 1.5 m ahead of where odometry says": _drifted(_ROOM, 1.5, 0.0),
    "a match 1.5 m beside where odometry says": _drifted(_SMALL, 0.0, 1.5),
    "a match that looks the other way": _moved(_SMALL, 0.1, 0.1, 180),
    "a match 60 degrees beside the odometry": _moved(_DOORS, 0.0, 0.2, -60),
    "a match 42 degrees beside the odometry": _moved(_DOORS, 0.1, 0.0, 42),
    "a match 0.8 m from where odometry says": _moved(_CORNER, 0.6, 0.5, 0),
    "a match 22 degrees beside the odometry": _moved(_ROOM, 0.1, 0.0, 22),
    "headings of nearly 180 degrees, on either side": _turned(_moved(_ROOM, 0.1, 0, 12), 3.1),
    "headings of nearly -180 degrees": _turned(_moved(_SMALL, 0.1, 0, -10), -3.1),
    "odometry that was right": (*_ROOM[:2], _ROOM[3] + np.array([0.01, 0.0, 0.01]), _ROOM[3]),
    "a robot that looks back": _turned(_CORNER, 2.4),
    "a robot that is far from the node": _FAR,
    "a bare corridor across the node": _across(np.pi / 2),
    "a bare corridor aslant": _across(np.pi / 4),
    **{f"a bare corridor at {angle:g} degrees": _across(np.deg2rad(angle)) for angle in _OBLIQUE},
    "a bare corridor, and a robot that looks back": _turned(_across(0.0), 3.0),
    "a room and a corridor": _elsewhere(
        "a room with a corner", "a corridor with doors", (1.5, 1.5, 0.0), (-0.6, 0.8, 0.3)
    ),
    "two rooms alike in one corner": _elsewhere(
        "a room with a corner", "a wide hall", (1.5, 1.2, 0.0), (1.5, 1.2, 0.0)
    ),
    "another room, from a robot that looks aside": _elsewhere(
        "a small room", "a room with a corner", (1.3, 1.4, -1.0), (2.2, 1.8, -1.2)
    ),
    "a room that shares two walls": _elsewhere(
        "a room with a cupboard", "a square room", (2.0, 1.5, 0.3), (2.0, 1.6, 0.0)
    ),
    "a small room and a square one": _elsewhere(
        "a small room", "a square room", (1.3, 1.2, 0.0), (1.6, 1.2, 0.0)
    ),
}
MISTAKES = """
one that believes nothing never corrects: a good match is refused
    bool(near and here >= 0.75 and around.max() < here - 0.1) -> False
you believe it whatever the scans say
    bool(near and here >= 0.75 and around.max() < here - 0.1) -> True
a corridor slides: half a metre on, one way, the scans fit just as well
    and around.max() < here - 0.1 -> and True
another room may be the best match that there is, and fit badly: look at the fit itself
    and here >= 0.75 -> and True
odometry is never that wrong: a match beyond 1 m or 30 degrees of the guess is another place
    near = -> near = True or
compare headings, too: odometry is never more than 30 degrees wrong
    and abs(wrap(gap[2])) <= np.deg2rad(30.0) -> and True
compare places, too: odometry is never more than 1 m wrong
    np.hypot(gap[0], gap[1]) <= 1.0 and -> True and
headings of 179 and -179 degrees are 2 degrees apart: wrap the difference
    gap = relative(guess, pose) -> gap = pose - guess
    abs(wrap(gap[2])) -> abs(gap[2])
measure from the guess, not from the node: the robot may be far from the node
    gap = relative(guess, pose) -> gap = pose
it may slide in every direction, not along x alone
    np.deg2rad(np.arange(0, 360, 5)) -> np.deg2rad(np.arange(0, 360, 180))
it may slide in every direction, not along y alone
    np.deg2rad(np.arange(0, 360, 5)) -> np.deg2rad(np.arange(90, 360, 180))
these directions are too few: a corridor that lies between two of them slides past all
    np.arange(0, 360, 5) -> np.arange(0, 360, 45)
0.4 is no fit: a wrong room gets that, too
    here >= 0.75 -> here >= 0.4
nothing fits to 0.97: something is always hidden from one of the two
    here >= 0.75 -> here >= 0.97
look at the fit at the pose, not at the guess
    fit(node, seen, pose[None]) -> fit(node, seen, guess[None])
the poses around it must fit clearly worse, not just a little
    here - 0.1 -> here
you ask for too much: half a metre off, the fit of a good match falls by a third or so
    here - 0.1 -> here - 0.4
yours is the other way round
    bool(near and here >= 0.75 and around.max() < here - 0.1)
        -> not (near and here >= 0.75 and around.max() < here - 0.1)
"""


def _form(what: str, got: object, *_: object) -> bool:
    got = returned(what, got)
    if not isinstance(got, bool | np.bool_):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return True or False")
    return bool(got)


def _fits(node: NDArray, seen: NDArray, pose: Array) -> tuple[float, float]:
    """The fit at a pose (3,), and the best half a metre off."""
    bearings = np.deg2rad(np.arange(0, 360, 5))
    aside = 0.5 * np.stack([np.cos(bearings), np.sin(bearings), 0 * bearings], axis=1)
    return fit(node, seen, pose[None])[0], fit(node, seen, pose + aside).max()


def _difference(got: bool, want: bool, *case: Array) -> str:
    node, seen, guess, pose = case
    gap = relative(guess, pose)
    here, around = _fits(node, seen, pose)
    return (
        f"{got}, but {want} is right; the fit is {here:.2f}, half a metre off up to {around:.2f}, "
        f"and the guess was {np.hypot(gap[0], gap[1]):.1f} m and "
        f"{np.rad2deg(abs(float(wrap(gap[2])))):.0f} degrees away"
    )


def _broken(got: bool, want: bool, node: NDArray, seen: NDArray, guess: Array, pose: Array) -> str:
    if want:
        return "a good match is refused: are you too strict?"
    here, around = _fits(node, seen, pose)
    if here >= 0.75 and around >= here - 0.1:
        return "you believe a corridor that slides; does it lie between two of your directions?"
    return "a match is believed that must not be"


check_accept = exercise(
    accept,
    CASES,
    MISTAKES,
    about="Rooms, corridors, other rooms, and matches that odometry contradicts.",
    example=_ROOM,
    calls=1_500,
    invoke=calling(said={"poses": "fit takes poses (P, 3): pose[None] is one of them"}),
    form=_form,
    difference=_difference,
    broken=_broken,
)
