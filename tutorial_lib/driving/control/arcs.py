"""A driver that needs only a laser: try arcs, forwards and in reverse, and take the best.

Each arc is a steering angle held for a while; some swerve half way. An arc ends before it would
touch what the laser saw; what is left to do from a place on it is judged by distance and by how
much the car still has to turn. A car that faces the wrong way thus turns in several moves where
there is room, and reverses where there is none.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.driving.control.composed import checked_waypoints
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.sensors import full_circle

_SLACK = 0.001  # metres by which a corner may swing closer while leaving
_STUCK = -0.02  # metres inside the car at which something is more than touching it
_HORIZON = 2.5  # metres within which the laser's points matter


@dataclass(frozen=True)
class ArcController:
    """Rollouts a car to a waypoint by the laser; a `Controller`.

    Attributes:
        car: the body.
        steerings: how many steering angles are tried.
        ahead, behind: metres that an arc is long at most.
        stride: metres between the places on an arc that are looked at.
        margin: metres that the car keeps from everything.
        comfort: metres of clearance from which on it is content.
        discomfort: metres that touching the margin feels like.
        reverse_cost: a metre in reverse feels like so many ahead.
        shift_cost: metres that a change between forwards and reverse feels like.
        detour: metres that it takes to get around what hides the waypoint.
        arrived: metres from the waypoint at which the car stops.
        braking: m/s^2 that it counts on.
        crawl: m/s where there is no room at all.
        hurry: m/s more for each metre of room.
    """

    car: BicycleCar = field(default_factory=BicycleCar)
    steerings: int = 11
    ahead: float = 1.4
    behind: float = 1.0
    stride: float = 0.05
    margin: float = 0.04
    comfort: float = 0.15
    discomfort: float = 0.6
    reverse_cost: float = 3.0
    shift_cost: float = 0.25
    detour: float = 1.2
    arrived: float = 0.1
    braking: float = 1.0
    crawl: float = 0.2
    hurry: float = 3.0

    @cached_property
    def _arcs(self) -> Array:
        """(A, 4) each arc's steering in rad, that of its second half, direction and length."""
        angles = np.linspace(-self.car.max_steering, self.car.max_steering, self.steerings)
        swerves = [(a, -a, 1.0, self.ahead) for a in angles if a]
        ahead = [(a, a, 1.0, self.ahead) for a in angles]
        behind = [(a, a, -1.0, self.behind) for a in angles]
        return np.array(ahead + swerves + behind)

    @cached_property
    def _limits(self) -> Array:
        """What `_choose` must know of the car and of taste, in its order."""
        car, box = self.car, [*self.car.footprint.min(axis=0), *self.car.footprint.max(axis=0)]
        body = [car.wheelbase, car.steering_rate, car.turning_radius]
        taste = [self.margin, self.comfort, self.discomfort]
        costs = [self.reverse_cost, self.shift_cost, self.detour]
        return np.array([*box, *body, self.stride, *taste, *costs])

    def act(self, observations: Observation, waypoints: Array) -> Array:
        """Actions (N, 2): speed in m/s and steering in rad, for waypoints (N, 2).

        Raises:
            InputError: when a waypoint is missing or not finite.
        """
        waypoints = checked_waypoints(waypoints, len(observations))
        angles = full_circle(observations.laser.shape[1])
        state = np.stack([observations.speed, observations.steering], axis=1)
        best, free, gap = _choose(
            observations.laser, angles, waypoints, state, self._arcs, self._limits
        )
        steering, _, sign, _ = self._arcs[best].T
        left = np.linalg.norm(waypoints, axis=1)
        limit = np.where(sign > 0, self.car.max_speed, self.car.max_reverse)
        # Slow enough to stop in time, and where it is tight.
        speed = np.sqrt(2 * self.braking * np.minimum(free, left))
        speed = np.minimum(np.minimum(speed, limit), self.crawl + self.hurry * gap)
        stop = (left < self.arrived) | (free <= 0.0)
        return np.stack([np.where(stop, 0.0, sign * speed), steering], axis=1)


@njit(cache=True, nogil=True, error_model="numpy")
def _choose(
    lasers: Array, angles: Array, waypoints: Array, state: Array, arcs: Array, limits: Array
) -> tuple[NDArray[np.intp], Array, Array]:
    """For each robot the best arc's number, how many metres of it are free, and its least gap."""
    box = limits[:4]
    wheelbase, steering_rate, radius, stride = limits[4:8]
    margin, comfort, discomfort, reverse_cost, shift_cost, detour = limits[8:]
    count, beams = lasers.shape
    best, free, least = np.zeros(count, np.intp), np.zeros(count), np.zeros(count)
    px, py = np.empty(beams), np.empty(beams)
    for robot in range(count):
        near = 0
        for beam in range(beams):
            angle, distance = angles[beam], lasers[robot, beam]
            if distance < _HORIZON:
                px[near], py[near] = distance * np.cos(angle), distance * np.sin(angle)
                near += 1
        # Whoever is too close already may leave, but not come closer.
        here = _gap(px, py, near, 0.0, 0.0, 1.0, 0.0, box)
        tight = min(margin, here - _SLACK)
        if here < _STUCK:
            continue
        speed, steering = state[robot]
        swing = steering_rate * stride / max(abs(speed), 0.3)
        lowest = np.inf
        for arc in range(len(arcs)):
            first, second, sign, longest = arcs[arc]
            shift = shift_cost if speed * sign < -0.02 else 0.0
            x, y, heading, delta, length = 0.0, 0.0, 0.0, steering, 0.0
            roughness, arc_gap, arc_cost = 0.0, np.inf, np.inf
            while length < longest - 1e-9:
                wanted = first if length < 0.5 * longest else second
                delta += min(max(wanted - delta, -swing), swing)
                turn = sign * stride * np.tan(delta) / wheelbase
                x += sign * stride * np.cos(heading + turn / 2)
                y += sign * stride * np.sin(heading + turn / 2)
                heading += turn
                gap = _gap(px, py, near, x, y, np.cos(heading), np.sin(heading), box)
                if gap < tight:
                    break
                length += stride
                if length < 0.6:
                    arc_gap = min(arc_gap, gap)
                roughness = max(roughness, 1.0 - (gap - margin) / comfort)
                gone = shift + (length if sign > 0 else length * reverse_cost)
                dx, dy = waypoints[robot, 0] - x, waypoints[robot, 1] - y
                to_go = _to_go(dx, dy, heading, radius, reverse_cost)
                # Only what would be better if in sight needs looking at; detours are not free.
                cost = gone + to_go + discomfort * roughness
                if cost < min(arc_cost, lowest):
                    if _is_hidden(px, py, near, x, y, dx, dy, box[3]):
                        cost = gone + (to_go + detour) + discomfort * roughness
                    arc_cost = min(arc_cost, cost)
                # A metre more costs at least one, and brings the waypoint at most one nearer.
                bound = gone + np.sqrt(dx * dx + dy * dy) + discomfort * roughness
                if arc_cost >= lowest and bound > lowest + 1e-9:
                    break
            if arc_cost < lowest:
                lowest, best[robot], free[robot], least[robot] = arc_cost, arc, length, arc_gap
    return best, free, least


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _gap(
    px: Array, py: Array, near: int, x: float, y: float, cos: float, sin: float, box: Array
) -> float:
    """Metres from the car at (x, y) to the nearest of the points; negative if one is inside."""
    inner, outer = 0.0, np.inf
    for i in range(near):
        ux, uy = px[i] - x, py[i] - y
        along, aside = cos * ux + sin * uy, cos * uy - sin * ux
        out_x, out_y = max(box[0] - along, along - box[2]), max(box[1] - aside, aside - box[3])
        inner = min(inner, max(out_x, out_y))
        outer = min(outer, max(out_x, 0.0) ** 2 + max(out_y, 0.0) ** 2)
    return inner + np.sqrt(outer)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _is_hidden(
    px: Array, py: Array, near: int, x: float, y: float, dx: float, dy: float, half: float
) -> bool:
    """Whether a point is less than `half` metres off the line from (x, y) along (dx, dy)."""
    length2 = dx * dx + dy * dy
    limit = half * half * length2
    for i in range(near):
        ux, uy = px[i] - x, py[i] - y
        along, aside = ux * dx + uy * dy, ux * dy - uy * dx
        if 0.0 < along < length2 and aside * aside < limit:
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _to_go(dx: float, dy: float, heading: float, radius: float, reverse_cost: float) -> float:
    """About how far it still is: the distance, and the arc to turn towards or away from it."""
    distance = np.sqrt(dx * dx + dy * dy)
    bearing = abs((np.arctan2(dy, dx) - heading + np.pi) % (2 * np.pi) - np.pi)
    # Very near, the bearing says nothing.
    weight = radius * min(1.0, distance / 0.3)
    ahead = distance + weight * bearing
    back = reverse_cost * (distance + weight * (np.pi - bearing))
    return min(ahead, back)
