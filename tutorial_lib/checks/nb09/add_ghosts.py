"""The check of the bookkeeping of ghosts, in notebook 09."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, calling, exercise, keeping, kind
from tutorial_lib.se2 import Array, inverse

Ghosts = set[tuple[int, int]]
"""A node and one of its directions."""
_DIRECTIONS = 12


def add_ghosts(
    ghosts: Ghosts, node: int, explorable: NDArray[np.bool_], beside: dict[int, Array]
) -> Ghosts:
    """The ghosts after a node was added; see the exercise."""

    def direction(pose: Array) -> int:
        bearing = np.arctan2(pose[1], pose[0])
        share = bearing * _DIRECTIONS / (2 * np.pi)
        return round(share) % _DIRECTIONS

    grown = ghosts | {(node, k) for k in np.flatnonzero(explorable).tolist()}
    for other, pose in beside.items():
        there, back = direction(pose), direction(inverse(pose))
        grown -= {(node, there), (other, back)}
    return grown


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
CASES = {
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
MISTAKES = """
bearings from arctan2 may be negative, and so are yours in bins; % 12 makes -3 of them 9
    round(share) % _DIRECTIONS -> round(share)
a bearing of 350 degrees rounds to bin 12, which is bin 0: take % 12 after rounding
    round(share) % _DIRECTIONS -> round(share % _DIRECTIONS)
a bearing of -90 degrees is bin 9, not bin 3: % 12, not abs
    round(share) % _DIRECTIONS -> abs(round(share)) % _DIRECTIONS
bins are centred on their bearings: round, do not cut off
    round(share) -> int(np.floor(share))
bins are centred on their bearings: round, since int(...) cuts off
    round(share) -> int(share)
the direction in which a node stands is the bearing of its place, arctan2(y, x), not its heading
    np.arctan2(pose[1], pose[0]) -> pose[2]
np.arctan2 takes y first: arctan2(y, x)
    np.arctan2(pose[1], pose[0]) -> np.arctan2(pose[0], pose[1])
the direction in which a node stands is the bearing of its place; yours is its heading, in both
frames
    np.arctan2(pose[1], pose[0]) -> pose[2]
    direction(inverse(pose)) -> direction(pose)
directions are counted counter-clockwise, as bearings are
    bearing = -> bearing = -
arctan(y / x) does not know ahead from behind: arctan2(y, x)
    np.arctan2(pose[1], pose[0]) -> np.arctan(pose[1] / pose[0])
a node also stands in a direction of the other one: remove that ghost, too, of the node that was
there before
    {(node, there), (other, back)} -> {(node, there)}
in the new node's own direction of the other node there is no ghost either: add the new ghosts
first, then remove
    {(node, there), (other, back)} -> {(other, back)}
the other node sees the new one at the bearing of inverse(pose); half a turn more is right only
where both look the same way
    direction(inverse(pose)) -> (direction(pose) + 6) % _DIRECTIONS
the other node has a frame of its own: the new one is at inverse(pose) there
    direction(inverse(pose)) -> direction(pose)
`pose` is that of the other node in the frame of the new one; yours takes it the other way round
    there, back = -> back, there =
only the ghost in the direction of the new node goes; the others of that node stay
    grown -= {(node, there), (other, back)}
        -> grown = {one for one in grown if one[0] != other and one != (node, there)}
only the ghost in the direction of the new node goes, not those beside it
    (other, back)} -> *((other, (back + k) % _DIRECTIONS) for k in (-1, 0, 1))}
the ghosts that were there before stay, unless the new node stands there
    ghosts | -> set() |
the new node has ghosts of its own, one in each explorable direction
    ghosts | {(node, k) for k in np.flatnonzero(explorable).tolist()} -> set(ghosts)
the other nodes count even where no ghost was left before
    in beside.items(): -> in beside.items() if ghosts else ():
the ghosts that were there before stay even where no node is beside the new one
    ghosts | -> (ghosts if beside else set()) |
a ghost only in directions that are explorable; yours has all twelve
    np.flatnonzero(explorable).tolist() -> range(_DIRECTIONS)
a ghost where explorable is True; yours has them where it is False
    flatnonzero(explorable) -> flatnonzero(~explorable)
several nodes may be beside the new one; yours looks at the first only
    in beside.items(): -> in list(beside.items())[:1]:
"""
_HINTS: dict[type[Exception], str] = {
    TypeError: "a ghost is a pair (node, direction) of whole numbers; a set takes .add(...), "
    "and .discard(...) where it may not be there",
    KeyError: ".remove complains where the ghost is not there; .discard does not",
    ValueError: "a pose has three numbers, x, y and heading",
}


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


def _broken(got: Ghosts, want: Ghosts, *case: Any) -> str:  # noqa: ANN401
    """Which part of the rule the first wrong ghost breaks."""
    ghosts, node, explorable, _ = case
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


check_add_ghosts = exercise(
    add_ghosts,
    CASES,
    MISTAKES,
    about="First nodes and later ones, ahead, behind and aside, with several beside them.",
    example=_random(3),
    calls=300,
    invoke=keeping(add_ghosts, "work on copies, as in set(ghosts)", calling(_HINTS)),
    form=_formed,
    difference=_why,
    broken=_broken,
)
