"""An oracle that drives a fleet along geodesics: it knows the map and every pose."""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.driving.control.composed import checked_robots
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.three_point import AHEAD, BEHIND, Stillness, ThreePointTurn
from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Controller, Observation, Robots
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.validation import instance, integers, with_methods
from tutorial_lib.world.simulation import STEP, Simulation

PARKING = RMPController(begin=0.45, miss=0.08, arrived=0.08, lane_reach=1.2, crawl=0.15)
"""Parks exactly, since an oracle's waypoints are exact. All trajectories are recorded with it: with
other settings the networks that come with the library could not be trained again."""
TURN_ROUND = 16.0
"""Seconds after which `TurnFirst` drives on, wherever the robot looks."""
_REACH = 2.0  # metres that a waypoint is ahead on the geodesic at most


class OraclePolicy:
    """A `Policy` that drives each robot of a simulation to its own goal.

    The waypoint is the farthest point of the geodesic in line of sight, as in Meng 2020's code.
    """

    def __init__(
        self,
        simulation: Simulation,
        paths: GridPaths,
        goals: ArrayLike,
        controller: Controller | None = None,
    ) -> None:
        """Compute the distance fields of all goals.

        Args:
            simulation: N robots, whose poses it reads.
            paths: the free space.
            goals: (N, 2), one for each robot, in metres.
            controller: drives to the waypoints; `PARKING` unless given.

        Raises:
            InputError: when there are not as many goals as robots.
        """
        instance("simulation", simulation, Simulation)
        self.fields: DistanceFields = instance("paths", paths, GridPaths).fields(goals)
        self.goals = self.fields.goals
        if len(simulation) != len(self.goals):
            raise InputError(
                f"goals: {len(self.goals)}, simulation: {len(simulation)} robots; give as many"
            )
        self.simulation = simulation
        controller = PARKING if controller is None else controller
        self.controller = with_methods("controller", controller, "act")

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,), from what they observe now."""
        robots = checked_robots(observations, robots, self.goals)
        return self.controller.act(observations, self.waypoints(robots))

    def waypoints(self, robots: Robots) -> Array:
        """Waypoints (M, 2) of the robots (M,), in metres as each sees them."""
        robots = integers("robots", robots, ("M",), least=0, most=len(self.goals) - 1)
        poses, caster = self.simulation.poses[robots], self.simulation.scene.caster
        return to_local(poses, self.fields.waypoints(poses[:, :2], robots, caster, _REACH))


class TurnFirst:
    """A `Policy`: robots whose first waypoint is behind turn in place, then an oracle drives.

    This is how a person leaves a narrow place: a controller that drives to waypoints begins with an
    arc to the side, and may not get out of a corner or a dead end. A robot that comes to a stand
    while it turns goes on to the other side.
    """

    def __init__(self, oracle: OraclePolicy) -> None:
        """Begin when the robots act for the first time."""
        self.oracle = instance("oracle", oracle, OraclePolicy)
        count = len(oracle.goals)
        self._control = ThreePointTurn(count)
        self._turning, self._other = np.zeros((2, count), dtype=bool)
        self._seconds, self._stillness = np.zeros(count), Stillness(count)

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,), from what they observe now."""
        waypoints = self.oracle.waypoints(robots)
        self._decide(robots, np.arctan2(waypoints[:, 1], waypoints[:, 0]), observations.odometry)
        actions, rows = self.oracle.act(observations, robots), self._turning[robots]
        actions[rows] = self._control.act(observations[rows], robots[rows])
        return actions

    def _decide(self, robots: Robots, bearings: Array, odometry: Array) -> None:
        """Which robots turn, given the bearings (M,) of their waypoints, and to which side."""
        begin = (self._seconds[robots] == 0.0) & (np.abs(bearings) > BEHIND)
        poses = self.oracle.simulation.poses[robots]
        stuck = self._turning[robots] & self._stillness.stuck(robots, poses)
        self._turning[robots] |= begin
        self._other[robots] ^= stuck
        rows = np.flatnonzero(begin | stuck)
        other = np.where(self._other[robots[rows]], -2 * np.pi * np.sign(bearings[rows]), 0.0)
        self._control.begin(robots[rows], odometry[rows], bearings[rows] + other)
        self._seconds[robots] += STEP
        late = self._seconds[robots] > TURN_ROUND
        self._turning[robots] &= (np.abs(bearings) > AHEAD) & ~late
