"""Where paths turn: from an anchor to one that looks another way, at the same place."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.three_point import ThreePointTurn
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.validation import instance, number, whole

TURN_TIME = 16.0
"""Seconds of turning after which a robot that sees none of the next anchors is lost."""


def checked_turns(turns: Mapping[int, float] | None) -> Mapping[int, float]:
    """Turns by their places on a path, none unless given; an `InputError` if they are no such."""
    turns = instance("turns", {} if turns is None else turns, Mapping)
    for place, angle in turns.items():
        whole("turns", place, least=0)
        number("turns", angle)
    return turns


class PathTurns:
    """The turns on the paths of N robots, and how they make them.

    Attributes:
        seconds: (N,) since each robot began to turn.
    """

    def __init__(self, robots: int) -> None:
        """Paths without a turn."""
        self._angles: list[Mapping[int, float]] = [{} for _ in range(robots)]
        self._control = ThreePointTurn(robots)

    @property
    def seconds(self) -> Array:
        """(N,) since each robot began to turn."""
        return self._control.seconds

    def set(self, robot: int, angles: Mapping[int, float]) -> None:
        """Set the turns of a robot's path: by how many rad, before each of these places on it."""
        self._angles[robot] = dict(angles)

    def before(self, robots: Robots, places: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(M,) whether robots turn before these places (M,) on their paths."""
        return np.array(
            [place in self._angles[robot] for robot, place in zip(robots, places, strict=True)],
            dtype=bool,
        )

    def begin(self, robots: Robots, odometry: Array, places: NDArray[np.intp]) -> None:
        """Begin to turn towards these places (M,)."""
        if len(robots):
            angles = [self._angles[i][place] for i, place in zip(robots, places, strict=True)]
            self._control.begin(robots, odometry, np.array(angles))

    def look(self, robots: Robots, odometry: Array) -> None:
        """Begin to turn all around."""
        self._control.begin(robots, odometry, np.full(len(robots), 2 * np.pi))

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of robots that turn."""
        return self._control.act(observations, robots)
