"""Small buildings of places, and a robot in them, for the exploration loop of notebook 09.

The robot looks another way after every drive: what it sees at a node that it comes back to does
not have the directions of that node.
"""

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer
from tutorial_lib.se2 import Array, relative, to_local

_DIRECTIONS = 12
_ASKED = 2_000  # questions without a drive in between
_STEP = 0.25  # metres of an action
_TIE = 0.001
_TURNED = np.deg2rad(150.0)  # by which it looks another way after a drive
Ghost = tuple[int, int]


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
    "the goal is only seen halfway back": _rooms(
        7, (1, 7), later=(1,), misleading={(0, 1): 0.4, (1, 2): 0.5}
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


class PlacesRobot:
    """The robot of the exercise, in a `Building`.

    Attributes:
        steps: actions left.
        log: the drives so far.
    """

    def __init__(self, building: Building) -> None:
        """Start at the first place."""
        self._building, self.steps = building, building.steps
        self.log: list[tuple[object, ...]] = []
        self._place, self._nodes, self._last = 0, dict[int, int](), -1
        self._heading, self._seen = 0.0, dict[int, Array]()  # of nodes: their poses
        self._false, self._visits = {*building.deceptive, *building.persistent}, Counter({0: 1})
        self._remembered = False  # since the last drive
        self._questions, self._arrived_short = Counter[str](), False
        self._arrived = False
        self._given: list[tuple[NDArray[Any], NDArray[Any]]] = []  # with copies

    def sees_goal(self) -> bool:
        """F_L of what is seen here and the goal's picture."""
        self._ask("sees_goal")
        return self._sees(self._building.seen_from) or self._sees(self._false)

    def node(self) -> int | None:
        """The node in which the robot is, by F_L; None if it is in none."""
        self._ask("node")
        if self._arrived_short:
            return self._last
        known = self._known(self._place)
        return 0 if known is None and self._place in self._building.alike else known

    def explorable(self) -> NDArray[np.bool_]:
        """F_G (12,)."""
        self._ask("explorable")
        found = np.zeros(_DIRECTIONS, bool)
        for other in self._building.beside(self._place):
            found[self._direction(self._pose, other)] = True
        return self._noted(found)

    def scores(self) -> Array:
        """F_S (12,)."""
        self._ask("scores")
        building, found = self._building, np.full(_DIRECTIONS, 0.1)
        less = _TIE * self._place  # two places have no ghosts with the same score
        for other in building.beside(self._place):
            metres = np.linalg.norm(building.places[other] - building.places[building.goal])
            more = building.misleading.get((self._place, other), 0.0)
            found[self._direction(self._pose, other)] = 0.95 - metres / 20 + more - less
        return self._noted(found)

    def beside(self) -> dict[int, Array]:
        """Poses, in the robot's frame, of nodes to which it can drive straight from here."""
        self._ask("beside")
        near = set(self._building.beside(self._place))
        return {
            node: relative(self._pose, self._seen[node])
            for node, place in self._nodes.items()
            if place in near
        }

    def remember(self, node: int) -> None:
        """Keep what is seen here as a node."""
        if isinstance(node, bool) or not isinstance(node, int | np.integer):
            raise WrongAnswer(f"remember got {node!r}; give it the number of the new node")
        if node in self._nodes:
            raise WrongAnswer(
                f"remember({node}): there is a node {node} already; number them 0, 1, 2, ..."
            )
        if node != len(self._nodes):
            raise WrongAnswer(f"remember({node}): the next number is {len(self._nodes)}")
        if (known := self._known(self._place)) is not None:
            words = self._why(known)
            raise WrongAnswer(f"remember({node}): the robot is in node {known}; {words}")
        self._nodes[int(node)], self._seen[int(node)] = self._place, self._pose
        self._last, self._arrived_short, self._remembered = int(node), False, True

    def to_node(self, node: int) -> None:
        """Drive to a node beside the one where the robot is."""
        self._drives("to_node", node)
        place = self._nodes.get(node) if isinstance(node, int | np.integer) else None
        if place is None:
            raise WrongAnswer(f"to_node({node!r}): there is no such node; `remember` makes one")
        if place not in self._building.beside(self._place):
            words = "drive from node to node, as global_policy returns them"
            raise WrongAnswer(f"to_node({node}): no edge leads there from where it is; {words}")
        self._go(self._building.astray.get((self._place, place), place))
        self._last = int(node)

    def to_ghost(self, ghost: Ghost) -> bool:
        """Drive to a ghost of the node where the robot is; whether it has arrived."""
        self._drives("to_ghost", ghost)
        if not (isinstance(ghost, tuple) and len(ghost) == 2):
            raise WrongAnswer(f"to_ghost({ghost!r}): a ghost is a pair, (node, direction)")
        if self._nodes.get(ghost[0]) != self._place:
            words = "drive to that node first, with to_node"
            if self.log[-2:-1] == [("to_ghost", ghost)]:
                words = "the robot has just driven to it"
            if ghost[0] not in self._nodes:
                words = "no node has this number; `remember` makes one"
            raise WrongAnswer(
                f"to_ghost({ghost}): it does not hang on the node of the robot; {words}"
            )
        node = self._seen[ghost[0]]
        there = {self._direction(node, o): o for o in self._building.beside(self._place)}
        if ghost[1] not in there:
            raise WrongAnswer(f"to_ghost({ghost}): there was never a ghost in this direction")
        place = there[ghost[1]]
        if (self._place, place) in self._building.blocked:
            self.steps, self._arrived = max(self.steps - 20, 0), False
            return False
        near = place in self._building.short and self._known(place) is None
        self._arrived = self._go(place)
        self._arrived_short = near and self._arrived
        return self._arrived

    def to_goal(self) -> bool:
        """Drive to the goal and stop there; False where it was something else."""
        self._drives("to_goal", None)
        if self._sees(self._building.seen_from):
            arrived = self._go(self._building.goal)
            self.steps = 0
            return arrived
        if self._sees(self._false):
            if self._place not in self._building.persistent:
                self._false.discard(self._place)
            self.steps = max(self.steps - 5, 0)
            return False
        words = "look first: only where robot.sees_goal() returns True"
        raise WrongAnswer(f"to_goal(): the goal is not seen from here; {words}")

    def demand_untouched(self) -> None:
        """Demand that nobody has changed what `explorable` and `scores` returned.

        Raises:
            WrongAnswer: when somebody has.
        """
        if any(not np.array_equal(given, kept) for given, kept in self._given):
            raise WrongAnswer(
                "your function changes the array that robot.explorable() or robot.scores() gave "
                "it; the robot may keep it, so make a new one"
            )

    def _noted(self, found: NDArray[Any]) -> NDArray[Any]:
        """An array that is given away, and must stay as it is."""
        self._given.append((found, found.copy()))
        return found

    def _known(self, place: int) -> int | None:
        """The node at a place."""
        return next((node for node, there in self._nodes.items() if there == place), None)

    def _sees(self, places: Collection[int]) -> bool:
        """Whether what is seen from these places is seen now."""
        again = self._place not in self._building.later or self._visits[self._place] > 1
        return again and self._place in places

    def _go(self, place: int) -> bool:
        """Drive to a place; False where the steps do not suffice, and the robot stays."""
        gap = self._building.places[place] - self._building.places[self._place]
        needed = round(float(np.linalg.norm(gap)) / _STEP)
        if needed > self.steps:
            self.steps = 0
            return False
        self._place, self.steps = place, self.steps - needed
        self._heading += _TURNED
        self._visits[place] += 1
        return True

    def _why(self, known: int) -> str:
        """Why no new node is due where the robot is in a `known` one."""
        if self._remembered and self.log:
            words = "Or does the loop go on where global_policy returns no ghost?"
            return f"it has been a node since the last drive: add each node once. {words}"
        if self.log and self.log[-1][0] == "to_ghost" and not self._arrived:
            return "to_ghost() returned False, so it has not arrived, and stands where it was"
        if self.log and self.log[-1][0] == "to_node" and self.log[-1][1] in self._nodes:
            return (
                "to_node() led to a node that is known: make one only where node() returns None, "
                "or where a ghost was just reached"
            )
        if self._arrived and self.log[-1][0] == "to_ghost":
            return (
                f"a ghost led to where node {known} stands, so it should have been gone: take the "
                "set that add_ghosts returns in place of the old one"
            )
        return "make one only where node() returns None, or where a ghost was just reached"

    def _drives(self, name: str, argument: object) -> None:
        if self.steps <= 0:
            raise WrongAnswer(f"{name}: no steps are left; the loop ends when robot.steps is 0")
        self.log.append((name, argument))
        self._questions.clear()
        self._remembered = False

    def _ask(self, name: str) -> None:
        self._questions[name] += 1
        if self._questions[name] > _ASKED:
            words = "does the loop never end, or not drive?"
            raise WrongAnswer(f"robot.{name}() was called {_ASKED} times without a drive; {words}")

    @property
    def _pose(self) -> Array:
        """(3,) where the robot is, and where it looks."""
        return np.array([*self._building.places[self._place], self._heading])

    def _direction(self, pose: Array, other: int) -> int:
        """The bin in which another place lies, as seen from a pose."""
        x, y = to_local(pose, self._building.places[other])
        return round(np.arctan2(y, x) * _DIRECTIONS / (2 * np.pi)) % _DIRECTIONS
