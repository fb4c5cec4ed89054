"""Turning where a car stands, in arcs ahead and in reverse (a three-point turn), by the laser.

A controller that drives to waypoints turns in a circle, and ends a circle's width beside the place.
Here the wheels are always at full lock, to one side ahead and to the other in reverse, and the gear
changes before something is touched or the car has moved too far from its place.
"""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.rmp_arcs import free_travel, safe_speeds
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.se2 import Array, to_local, wrap
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.sensors import full_circle
from tutorial_lib.world.simulation import STEP

BEHIND, AHEAD = np.pi / 2, 0.5
"""Bearings in rad beyond which a turn towards a waypoint begins, and below which it is over."""
STILL, STUCK = 1e-3, 1.0
"""Metres or rad a step that are no motion; seconds of that after which a robot is stuck."""
_OVER = 0.7  # rad that it turns beyond the wanted heading, and then back
_STEP_OUT = 0.35  # metres ahead of and behind its place between which it drives to and fro
_BEGIN, _GO_ON = 0.1, 0.03  # metres that must be free to begin with an arc, and to go on
_SETTLE = 0.15  # rad; until the wheels are turned so far, it stands


class Stillness:
    """For how long each of N robots has stood still."""

    def __init__(self, robots: int) -> None:
        """Begin with so many robots that move."""
        self._seconds, self._before = np.zeros(robots), np.full((robots, 3), np.inf)

    def begin(self, robots: Robots) -> None:
        """Count anew for robots (M,)."""
        self._seconds[robots] = 0.0

    def stuck(self, robots: Robots, odometry: Array) -> NDArray[np.bool_]:
        """(M,) whether robots have stood still for `STUCK` seconds; the count then begins anew."""
        still = np.abs(odometry - self._before[robots]).max(axis=1) < STILL
        seconds = np.where(still, self._seconds[robots] + STEP, 0.0)
        stuck = seconds > STUCK
        self._seconds[robots], self._before[robots] = np.where(stuck, 0.0, seconds), odometry
        return stuck


class ThreePointTurn:
    """How N cars turn in place; a differential drive simply does.

    Attributes:
        seconds: (N,) since each began to turn.
    """

    def __init__(self, robots: int) -> None:
        """Begin with so many robots that do not turn."""
        self.seconds = np.zeros(robots)
        self._safety = RMPController()
        self._angle, self._turned, self._heading = np.zeros((3, robots))
        self._place = np.zeros((robots, 3))
        self._side, self._gear = np.ones((2, robots))

    def begin(self, robots: NDArray[np.intp], odometry: Array, angles: Array) -> None:
        """Begin to turn robots (M,) with `odometry` (M, 3) by `angles` (M,) rad."""
        self.seconds[robots], self._turned[robots] = 0.0, 0.0
        self._place[robots], self._heading[robots] = odometry, odometry[:, 2]
        self._angle[robots], self._side[robots] = angles, np.where(angles < 0, -1.0, 1.0)
        self._gear[robots] = 1.0

    def turn_back(self, robots: NDArray[np.intp], odometry: Array) -> None:
        """Turn robots (M,) that are stuck to the other side, to the same heading.

        Those that were to turn by more than a circle turn as far, to the other side.
        """
        side, angle = self._side[robots], self._angle[robots]
        left = np.mod(side * (self._turned[robots] - angle), 2 * np.pi)
        seconds = self.seconds[robots]
        whole = np.abs(angle) > 2 * np.pi
        self.begin(robots, odometry, -side * np.where(whole, np.abs(angle), left))
        self.seconds[robots] = seconds

    def act(self, observations: Observation, robots: NDArray[np.intp]) -> Array:
        """Actions (M, 2) of robots (M,): speed in m/s, and steering in rad."""
        lasers = np.ascontiguousarray(observations.laser, dtype=float)
        side = self._sides(observations.odometry, robots)
        rule = self._safety.for_robots(observations)
        car = rule.body
        if not isinstance(car, BicycleCar):
            return np.stack([np.zeros(len(robots)), side * car.max_turn], axis=1)
        gear = self._gears(lasers, observations, robots, side, rule, car)
        steering = gear * side * car.max_steering
        arcs = np.stack([gear * side / car.turning_radius, gear], axis=1)
        taste = (rule.braking, rule.reserve, rule.crawl, rule.hurry)
        far = np.full(len(robots), np.inf)
        safe = safe_speeds(lasers, arcs, rule.discs, rule.margin, far, *taste)
        speed = np.minimum(safe, np.where(gear > 0, car.max_speed, car.max_reverse))
        speed[np.abs(observations.steering - steering) > _SETTLE] = 0.0
        return np.stack([gear * speed, steering], axis=1)

    def _sides(self, odometry: Array, robots: NDArray[np.intp]) -> Array:
        """The side (M,) to which robots turn: on, or back when they turned too far."""
        self.seconds[robots] += STEP
        self._turned[robots] += wrap(odometry[:, 2] - self._heading[robots])
        self._heading[robots] = odometry[:, 2]
        over, side = self._turned[robots] - self._angle[robots], self._side[robots]
        self._side[robots] = side = np.where(side * over > _OVER, -side, side)
        return side

    def _gears(
        self,
        lasers: Array,
        seen: Observation,
        robots: NDArray[np.intp],
        side: Array,
        rule: RMPController,
        car: BicycleCar,
    ) -> Array:
        """The gear (M,), 1 or -1: changed where there is no room, or too far from the place."""
        gear, angles = self._gear[robots], full_circle(lasers.shape[1])
        radius = car.turning_radius
        free, other = (
            free_travel(
                lasers,
                angles,
                np.stack([tried * side / radius, tried], axis=1),
                rule.discs,
                rule.margin,
            )[:, 0]
            for tried in (gear, -gear)
        )
        away = -gear * to_local(seen.odometry, self._place[robots, :2])[:, 0] > _STEP_OUT
        blocked = (free < _GO_ON) & (other > free)
        change = blocked | (away & (other > _BEGIN))
        self._gear[robots] = gear = np.where(change, -gear, gear)
        return gear
