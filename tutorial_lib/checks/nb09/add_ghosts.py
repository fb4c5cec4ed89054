"""The check of the bookkeeping of ghosts, in notebook 09."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.checks.nb09.calls import keeping
from tutorial_lib.se2 import Array, inverse

Ghosts = set[tuple[int, int]]
"""A node and one of its directions."""
_DIRECTIONS = 12


def add_ghosts(
    ghosts: Ghosts, node: int, explorable: NDArray[np.bool_], beside: dict[int, Array]
) -> Ghosts:
    """The ghosts after a node was added; see the exercise."""
    return _added(ghosts, node, explorable, beside)


def _added(
    ghosts: Ghosts,
    node: int,
    explorable: NDArray[np.bool_],
    beside: dict[int, Array],
    fault: str = "",
) -> Ghosts:
    """The rule, with a `fault` if one is named."""
    chosen = range(_DIRECTIONS) if fault == "all twelve" else np.flatnonzero(explorable).tolist()
    chosen = np.flatnonzero(~explorable).tolist() if fault == "not explorable" else chosen
    own = {(node, k) for k in chosen}
    grown = set(ghosts)
    if fault == "only new" or (fault == "alone" and not beside):
        grown = set()
    grown |= set() if fault == "adds none" else own
    for other, pose in {} if fault == "first of all" and not ghosts else beside.items():
        there = _direction(pose, fault)
        back = _direction(inverse(pose), fault)
        if fault == "heading for both":
            there = back = round(pose[2] * _DIRECTIONS / (2 * np.pi)) % _DIRECTIONS
        if fault == "opposite":
            back = (there + 6) % _DIRECTIONS
        if fault == "both the same":
            back = there
        if fault == "frames exchanged":
            there, back = back, there
        if fault != "new node only":
            grown.discard((other, back))
        if fault != "others only":
            grown.discard((node, there))
        if fault == "all of them":
            grown = {ghost for ghost in grown if ghost[0] != other}
        if fault == "neighbours":
            grown -= {(other, (back + k) % _DIRECTIONS) for k in (-1, 1)}
        if fault == "first only":
            break
    return grown


def _direction(pose: Array, fault: str) -> int:
    """The bin of the bearing of a place, with a `fault`."""
    x, y, heading = pose
    bearing = {"heading": heading, "swapped": np.arctan2(x, y), "clockwise": -np.arctan2(y, x)}.get(
        fault, np.arctan2(y, x)
    )
    if fault == "slope":
        bearing = np.arctan(y / x)
    share = bearing * _DIRECTIONS / (2 * np.pi)
    if fault == "floor":
        return int(np.floor(share)) % _DIRECTIONS
    if fault == "negative":
        return round(share)
    if fault == "bin 12":
        return round(share % _DIRECTIONS)
    if fault == "absolute":
        return abs(round(share)) % _DIRECTIONS
    return round(share) % _DIRECTIONS


_FAULTS = {
    "bearings from arctan2 may be negative, and so are yours in bins; % 12 makes -3 of them 9": (
        "negative"
    ),
    "a bearing of 350 degrees rounds to bin 12, which is bin 0: take % 12 after rounding": "bin 12",
    "a bearing of -90 degrees is bin 9, not bin 3: % 12, not abs": "absolute",
    "bins are centred on their bearings: round, do not cut off": "floor",
    "the direction in which a node stands is the bearing of its place, arctan2(y, x), not its "
    "heading": "heading",
    "np.arctan2 takes y first: arctan2(y, x)": "swapped",
    "the direction in which a node stands is the bearing of its place; yours is its heading, in "
    "both frames": "heading for both",
    "directions are counted counter-clockwise, as bearings are": "clockwise",
    "arctan(y / x) does not know ahead from behind: arctan2(y, x)": "slope",
    "a node also stands in a direction of the other one: remove that ghost, too, of the node that "
    "was there before": "new node only",
    "in the new node's own direction of the other node there is no ghost either: add the new "
    "ghosts first, then remove": "others only",
    "the other node sees the new one at the bearing of inverse(pose); half a turn more is right "
    "only where both look the same way": "opposite",
    "the other node has a frame of its own: the new one is at inverse(pose) there": "both the same",
    "`pose` is that of the other node in the frame of the new one; yours takes it the other way "
    "round": "frames exchanged",
    "only the ghost in the direction of the new node goes; the others of that node stay": (
        "all of them"
    ),
    "only the ghost in the direction of the new node goes, not those beside it": "neighbours",
    "the ghosts that were there before stay, unless the new node stands there": "only new",
    "the new node has ghosts of its own, one in each explorable direction": "adds none",
    "the other nodes count also where no ghost was left before": "first of all",
    "the ghosts that were there before stay also where no node is beside the new one": "alone",
    "a ghost only in directions that are explorable; yours has all twelve": "all twelve",
    "a ghost where explorable is True; yours has them where it is False": "not explorable",
    "several nodes may be beside the new one; yours looks at the first only": "first only",
}


def _seen(*directions: int) -> NDArray[np.bool_]:
    return np.isin(np.arange(_DIRECTIONS), directions)


def _pose(metres: float, bearing: float, heading: float) -> Array:
    angle = np.deg2rad(bearing)
    return np.array([metres * np.cos(angle), metres * np.sin(angle), np.deg2rad(heading)])


def _random(seed: int) -> tuple[Ghosts, int, NDArray[np.bool_], dict[int, Array]]:
    rng = np.random.default_rng([seed, 19])
    node = int(rng.integers(2, 6))
    ghosts = {(v, k) for v in range(node) for k in range(_DIRECTIONS) if rng.random() < 0.6}
    beside = {}
    for other in rng.choice(node, int(rng.integers(1, 3)), replace=False).tolist():
        bearings = 30 * rng.integers(0, 12, 2) + rng.uniform(-13, 13, 2)
        # The heading that makes the way back fall well inside a bin.
        beside[other] = _pose(float(rng.uniform(1.5, 3.5)), bearings[0], bearings[0] + bearings[1])
    return ghosts, node, rng.random(_DIRECTIONS) < 0.5, beside


_ALL = {(0, k) for k in range(_DIRECTIONS)}
_CASES = {
    "the first node": (set(), 0, _seen(0, 1, 6), {}),
    "the robot has driven straight ahead": (_ALL, 1, _seen(0, 3, 6, 9), {0: _pose(3, 180, 0)}),
    "the other node lies behind on the left, and looks elsewhere": (
        _ALL | {(1, 4)},
        2,
        _seen(*range(12)),
        {0: _pose(2.5, 130, 70)},
    ),
    "a bearing of nearly 360 degrees": (_ALL, 1, _seen(0, 6, 11), {0: _pose(3, -10, 175)}),
    "on the right": (_ALL, 1, _seen(*range(12)), {0: _pose(2, -62, 31)}),
    "two nodes beside the new one": (
        _ALL | {(1, k) for k in range(_DIRECTIONS)},
        2,
        _seen(*range(12)),
        {0: _pose(2.8, 95, -52), 1: _pose(1.9, -121, 201)},
    ),
    "no ghost was left": (set(), 1, _seen(0, 6), {0: _pose(3, 180, 0)}),
    "no node is beside the new one": ({(0, 1), (0, 4)}, 1, _seen(0, 6), {}),
    "nothing new, and nothing beside": ({(0, 1), (0, 4)}, 1, _seen(), {}),
    "the ghost there was removed already": ({(0, 2)}, 1, _seen(1, 2), {0: _pose(3, 62, 3)}),
    **{f"at random ({seed})": _random(seed) for seed in range(8)},
}


@check(add_ghosts, _random(3), calls=300)
def check_add_ghosts(student: Callable[..., Any]) -> None:
    """First nodes and later ones, ahead, behind and aside, with several beside them."""
    hints = {
        TypeError: "a ghost is a pair (node, direction) of whole numbers; a set takes .add(...), "
        "and .discard(...) where it may not be there",
        KeyError: ".remove complains where the ghost is not there; .discard does not",
        ValueError: "a pose has three numbers, x, y and heading",
    }
    compare(
        "add_ghosts",
        student,
        _CASES,
        add_ghosts,
        with_faults(_added, _FAULTS),
        invoke=keeping(add_ghosts, "work on copies, as in set(ghosts)", hints),
        form=_formed,
        difference=_why,
        broken=_broken,
    )


def _formed(what: str, got: object, *_: object) -> Ghosts:
    if not isinstance(got, set | frozenset):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return a set of ghosts")
    for ghost in got:
        if not (isinstance(ghost, tuple) and len(ghost) == 2):
            raise WrongAnswer(
                f"{what}: {ghost!r} is no ghost; a ghost is a pair, (node, direction)"
            )
        if not all(isinstance(part, int | np.integer) for part in ghost):
            words = "node and direction are whole numbers; int(...) or round(...) make them so"
            raise WrongAnswer(f"{what}: {ghost!r} is no ghost; {words}")
    return {(int(node), int(direction)) for node, direction in got}


def _broken(
    got: Ghosts, want: Ghosts, ghosts: Ghosts, node: int, explorable: NDArray[np.bool_], *_: object
) -> str:
    """Which part of the rule the first wrong ghost breaks."""
    if more := sorted(got - want):
        viewer, direction = more[0]
        if (viewer, direction) in ghosts:
            return (
                "the new node stands in that direction of the other one, by its own heading: that "
                "ghost goes, for every node beside and whatever ghosts the new one has"
            )
        if viewer == node and 0 <= direction < _DIRECTIONS and explorable[direction]:
            return "another node stands in that direction of the new one, so that it has no ghost"
        return (
            "a new ghost is (node, k), of the new node and each k from 0 to 11 that is explorable"
        )
    if sorted(want - got)[0][0] == node:
        return "the new node has a ghost in every explorable direction in which no node stands"
    return "a ghost stays unless the new node stands in its direction, the bin nearest to that"


def _why(got: Ghosts, want: Ghosts, *_: object) -> str:
    """A ghost too many, or one that is missing."""
    more, less = sorted(got - want), sorted(want - got)
    said = [f"{more[0]} should not be there"] if more else []
    said += [f"{less[0]} is missing"] if less else []
    return ", ".join(said)
