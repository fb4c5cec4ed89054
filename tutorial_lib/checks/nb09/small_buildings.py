"""Small buildings of places and links, for the check of the exploration loop in notebook 09."""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from tutorial_lib.geometry import Array


@dataclass(frozen=True, eq=False)
class Building:
    """Places, and what is special about some of them.

    Attributes:
        places: (P, 2) metres; the robot starts at the first.
        links: pairs of places between which one can drive.
        goal: the place of the goal.
        seen_from: places from which it is seen.
        deceptive: places at which the robot takes something else for the goal, once.
        persistent: places at which it does so whenever it looks.
        blocked: pairs (from, to) of places: the drive ends where it began.
        astray: for a drive from one place to the node at another, the place where it ends instead.
        short: places whose ghosts are so near that F_L still has the robot in the old node.
        alike: places that F_L takes for the first node, until they are one themselves.
        later: places from which the goal, or what is mistaken for it, is only seen when the robot
            comes back to them.
        misleading: for (from, to), what is added to the score.
        steps: actions that the robot may take.
    """

    places: Array
    links: tuple[tuple[int, int], ...]
    goal: int
    seen_from: tuple[int, ...]
    deceptive: tuple[int, ...] = ()
    persistent: tuple[int, ...] = ()
    blocked: tuple[tuple[int, int], ...] = ()
    astray: dict[tuple[int, int], int] = field(default_factory=dict)
    short: tuple[int, ...] = ()
    alike: tuple[int, ...] = ()
    later: tuple[int, ...] = ()
    misleading: dict[tuple[int, int], float] = field(default_factory=dict)
    steps: int = 500

    def beside(self, place: int) -> list[int]:
        """The places to which one can drive from a place."""
        pairs = [*self.links, *((second, first) for first, second in self.links)]
        return sorted(second for first, second in pairs if first == place)


def _grid(rows: list[str]) -> Array:
    """Places three metres apart, a little off the grid: one for each letter, by the alphabet."""
    found = {}
    for row, line in enumerate(rows):
        for column, letter in enumerate(line):
            if letter != ".":
                wobble = 0.13 * ((ord(letter) * 7) % 5 - 2)
                found[letter] = (3.0 * column + wobble, -3.0 * row - 0.7 * wobble)
    return np.array([found[letter] for letter in sorted(found)])


_ROW = _grid(["abcd"])
_row = partial(Building, _ROW, ((0, 1), (1, 2), (2, 3)))
_cross = partial(
    Building, _grid([".b..", "cade", ".f.."]), ((0, 1), (0, 2), (0, 3), (0, 5), (3, 4))
)
_rooms = partial(
    Building,
    _grid(["cb.gh", ".adef", ".i..j"]),
    ((0, 1), (1, 2), (0, 3), (3, 4), (4, 5), (4, 6), (6, 7), (0, 8), (5, 9)),
)
_LOOP = _grid(["abc", "h.d", "gfe"])
_SPUR = _grid(["abci", "h.d.", "gfe."])
_AROUND = tuple((v, (v + 1) % 8) for v in range(8))

BUILDINGS: dict[str, Building] = {
    "the goal is seen at once": Building(_ROW, ((0, 1),), 1, (0, 1)),
    "along a corridor": _row(3, (2, 3)),
    "a crossing with dead ends": _cross(4, (4,), misleading={(0, 1): 0.3, (0, 2): 0.2}),
    "rooms, the wrong ones first": _rooms(
        7, (6, 7), misleading={(0, 1): 0.4, (0, 8): 0.35, (1, 2): 0.5, (4, 5): 0.2}
    ),
    "a loop": Building(_LOOP, _AROUND, 4, (4,), misleading={(0, 7): 0.1, (6, 5): -0.5}),
    "a loop that closes": Building(
        _SPUR, (*_AROUND, (2, 8)), 8, (8,), misleading={(0, 7): 0.1, (2, 8): -0.6, (2, 1): 0.05}
    ),
    "something is mistaken for the goal": _rooms(
        7, (7,), deceptive=(0, 4), misleading={(0, 8): 0.3}
    ),
    "a ghost that cannot be reached": _cross(
        4, (4,), blocked=((0, 1), (0, 5)), misleading={(0, 1): 0.3, (0, 5): 0.25}
    ),
    "a ghost that is near its node": _row(3, (3,), short=(1, 2)),
    "a drive to a node that ends in none": _rooms(
        7, (6, 7), astray={(1, 0): 3}, misleading={(0, 1): 0.4, (1, 2): 0.5, (0, 8): -0.3}
    ),
    "a drive to a node that ends where the goal is seen": _rooms(
        7, (3, 6, 7), astray={(1, 0): 3}, misleading={(0, 1): 0.4, (1, 2): 0.5, (0, 8): -0.3}
    ),
    "the goal is seen where a ghost was near its node": _row(3, (2, 3), short=(1, 2)),
    "something is mistaken for the goal where a ghost was near its node": _row(
        3, (3,), deceptive=(1,), short=(1, 2)
    ),
    "a place that looks like the start": _row(3, (3,), alike=(1, 2)),
    "the goal is only seen on the way back": _rooms(
        7, (0, 7), later=(0,), misleading={(0, 1): 0.4, (1, 2): 0.5}
    ),
    "something is mistaken for the goal on the way back": _rooms(
        7, (7,), deceptive=(0,), later=(0,), misleading={(0, 1): 0.4, (1, 2): 0.5}
    ),
    "a ghost far inside that cannot be reached": _rooms(
        7, (7,), blocked=((3, 4),), misleading={(0, 3): 0.5}
    ),
    "steps that end where the goal is first seen": _row(3, (2, 3), steps=23),
    "one step is left where the goal is seen": Building(
        np.array([[0.0, 0.0], [3.0, 0.0], [6.0, 0.0], [6.25, 0.0]]),
        ((0, 1), (1, 2), (2, 3)),
        3,
        (2,),
        steps=25,
    ),
    "something is mistaken for the goal, and seen again where the robot stands": _rooms(
        7, (7,), persistent=(0, 4), misleading={(0, 8): 0.3}
    ),
    "a long corridor": Building(
        np.array([(3.0 * v, 0.0) for v in range(60)]),
        tuple((v, v + 1) for v in range(59)),
        59,
        (59,),
        steps=1_000,
    ),
    "too few steps": _rooms(7, (7,), steps=40, misleading={(0, 1): 0.4}),
    "a goal that is nowhere": _cross(4, ()),
}
"""What the loop is tried in."""
