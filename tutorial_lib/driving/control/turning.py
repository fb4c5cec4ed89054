"""Driving to waypoints with three-point turns: towards what is behind, and out of corners."""

import numpy as np

from tutorial_lib.driving.control.oracle import TURN_ROUND
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.three_point import AHEAD, BEHIND, Stillness, ThreePointTurn
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.se2 import Array

_NEAR = 0.2  # metres from a waypoint within which no turn begins: it is reached already


class TurningController:
    """Drives N cars to waypoints by `RMPController`, or turns them in place towards these.

    A car turns where its waypoint is behind it, and where it came to a stand. One that comes to a
    stand while it turns goes on to the other side.
    """

    def __init__(self, robots: int) -> None:
        """Begin with so many cars that do not turn."""
        self._drive, self._turn = RMPController(), ThreePointTurn(robots)
        self._turning, self._other = np.zeros((2, robots), bool)
        self._stillness = Stillness(robots)

    def act(self, observations: Observation, robots: Robots, waypoints: Array) -> Array:
        """Actions (M, 2) of robots (M,), from what they observe now, for waypoints (M, 2)."""
        self._decide(observations.odometry, robots, waypoints)
        actions, rows = self._drive.act(observations, waypoints), self._turning[robots]
        actions[rows] = self._turn.act(observations[rows], robots[rows])
        return actions

    def _decide(self, odometry: Array, robots: Robots, waypoints: Array) -> None:
        """Which robots turn, and to which side."""
        bearings = np.arctan2(waypoints[:, 1], waypoints[:, 0])
        far = np.linalg.norm(waypoints, axis=1) > _NEAR
        stuck = self._stillness.stuck(robots, odometry) & far
        turning = self._turning[robots]
        begin = stuck | (far & ~turning & (np.abs(bearings) > BEHIND))
        self._other[robots] = np.where(
            begin, stuck & turning & ~self._other[robots], self._other[robots]
        )
        rows = np.flatnonzero(begin)
        other = np.where(self._other[robots[rows]], -2 * np.pi * np.sign(bearings[rows]), 0.0)
        self._turn.begin(robots[rows], odometry[rows], bearings[rows] + other)
        late = self._turn.seconds[robots] > TURN_ROUND
        self._turning[robots] = (turning | begin) & (np.abs(bearings) > AHEAD) & ~late
