"""Riemannian motion policies: C_RMP of Meng 2020 (III-B), for a car and for a differential drive.

A *policy* says how something should accelerate - a point of the body, its distance from a wall, the
steering angle - and with its *metric* how much that matters, and in which directions. The
*pull-back* through a Jacobian maps this to the body's controls. The policies' accelerations are
*resolved* by least squares, weighted with the metrics.

Before, `rmp_arcs` turns the waypoint into an arc, ahead or in reverse; afterwards it limits speed.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from tutorial_lib.driving.control import rmp_arcs as moves
from tutorial_lib.driving.control import rmp_arithmetic as raw
from tutorial_lib.driving.control.composed import checked_waypoints
from tutorial_lib.driving.control.rmp_policies import (
    control_jacobian,
    goal_policy,
    heading_policy,
    obstacle_policy,
    point_jacobian,
    pull_back,
    resolve,
)
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.validation import floats, instance, number
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive, moved
from tutorial_lib.world.sensors import full_circle
from tutorial_lib.world.simulation import STEP

__all__ = [
    "RMPController",
    "control_jacobian",
    "goal_policy",
    "heading_policy",
    "obstacle_policy",
    "point_jacobian",
    "pull_back",
    "resolve",
]
_ABOVE_ZERO = ("near", "fade", "braking")


@dataclass(frozen=True)
class RMPController:
    """Drives a body to a waypoint by the laser and policies; a `Controller`.

    Attributes:
        body: a car or a differential drive; robots that know their own body are driven as that.
        goal_gain, goal_damping, near: see `goal_policy`; push, brake, weight, fade: see
            `obstacle_policy`; heading_gain, heading_weight: see `heading_policy`.
        turning: 1/s, turning rate that a differential drive wants for each rad of bearing.
        horizon: metres from the pose within which obstacles push.
        authority: m/s; a car that is slower counts its steering as if it drove so fast.
        lane, lane_reach: metres that the lane to a waypoint has beside the body, and is long.
        swing: rad by which lanes are preferred on the side to which the body turns already.
        reverse_cost, turn_cost, go_on, begin, miss: see `rmp_arcs.choose_moves`.
        carrot: metres ahead on the arc at which the goal policy pulls a car.
        arrived: metres from the waypoint at which the body stops.
        margin: metres that the body keeps from everything.
        braking, reserve, crawl, hurry: see `rmp_arcs.safe_speeds`.
        settle: rad; while a car's steering has to turn by more than this, it slows down.
    """

    body: BicycleCar | DifferentialDrive = field(default_factory=BicycleCar)
    goal_gain: float = 2.4
    goal_damping: float = 3.0
    near: float = 0.35
    push: float = 0.12
    brake: float = 0.12
    weight: float = 0.3
    fade: float = 0.08
    heading_gain: float = 6.0
    heading_weight: float = 1.0
    turning: float = 3.0
    horizon: float = 0.75
    authority: float = 0.25
    lane: float = 0.065
    lane_reach: float = 2.2
    swing: float = 0.15
    reverse_cost: float = 2.3
    turn_cost: float = 0.5
    go_on: float = 0.05
    begin: float = 0.6
    miss: float = 0.2
    carrot: float = 0.5
    arrived: float = 0.03
    margin: float = 0.03
    braking: float = 0.7
    reserve: float = 0.02
    crawl: float = 0.2
    hurry: float = 3.0
    settle: float = 0.12

    def __post_init__(self) -> None:
        raw.check_body(self.body)
        for one in fields(self)[1:]:
            amount = getattr(self, one.name)
            if one.name in _ABOVE_ZERO:
                number(one.name, amount, above=0.0)
            else:
                number(one.name, amount, least=0.0)

    @cached_property
    def discs(self) -> Array:
        """Discs (D, 2) that cover the body, place on its long axis and radius; they are pushed."""
        return moves.cover(self.body)

    def for_robots(self, observations: Observation) -> "RMPController":
        """The controller for the body of the robots that observe this: itself if it fits.

        Args:
            observations: of the robots; recorded ones do not say which body it was.

        Raises:
            InputError: when the body is neither a car nor a differential drive.
        """
        body = instance("observations", observations, Observation).body
        if body is None or body == self.body:
            return self
        if not isinstance(body, BicycleCar | DifferentialDrive):
            raise InputError(
                f"body: a {type(body).__name__} is neither a BicycleCar nor a DifferentialDrive; "
                "drive it with a controller of its own"
            )
        return _for_body(self, body)

    def act(self, observations: Observation, waypoints: Array) -> Array:
        """Actions (N, 2): speed in m/s, and steering in rad (car) or rad/s, for waypoints (N, 2).

        Raises:
            InputError: when a waypoint is missing or not finite, or the body is of another kind.
        """
        if (fits := self.for_robots(observations)) is not self:
            return fits.act(observations, waypoints)
        waypoints = checked_waypoints(waypoints, len(observations))
        lasers = np.ascontiguousarray(observations.laser, dtype=float)
        controls = np.stack([observations.speed, observations.steering], axis=1)
        floats("observations", controls)  # a speed that is none would give such an action
        carrots, gears, steerings = self._aim(lasers, controls, waypoints)
        after = controls + STEP * self._accelerate(lasers, controls, carrots, gears, steerings)
        return self._limit(lasers, controls, after, gears, np.linalg.norm(waypoints, axis=1))

    def _aim(self, lasers: Array, controls: Array, waypoints: Array) -> tuple[Array, Array, Array]:
        """Where to now: points (N, 2), ahead (+1) or in reverse (-1), and the steering for it."""
        body, angles = self.body, full_circle(lasers.shape[1])
        swings = self.swing * np.sign(body.twist(controls)[:, 1]) * (abs(controls[:, 0]) > 0.02)
        half = self.lane + float(np.abs(body.footprint[:, 1]).max())
        points = moves.clear_lanes(lasers, angles, waypoints, swings, half, self.lane_reach)
        if not isinstance(body, BicycleCar):
            turns = self.turning * np.arctan2(points[:, 1], points[:, 0])
            return points, np.ones(len(points)), np.clip(turns, -body.max_turn, body.max_turn)
        taste = (self.reverse_cost, self.turn_cost, self.go_on, self.begin, self.miss)
        limits = np.array([body.turning_radius, *taste])
        room = (self.discs, self.margin)
        arcs = moves.choose_moves(lasers, angles, points, controls[:, 0], *room, limits)
        curvatures, gears, lengths = arcs.T
        twists = gears[:, None] * np.stack([np.ones(len(arcs)), curvatures], axis=1)
        ahead = moved(np.zeros((len(arcs), 3)), twists, np.minimum(lengths, self.carrot))
        return ahead[:, :2], gears, np.arctan(body.wheelbase * curvatures)

    def _accelerate(
        self, lasers: Array, controls: Array, carrots: Array, gears: Array, steerings: Array
    ) -> Array:
        """Accelerations (N, 2) of the controls: all policies, pulled back and resolved."""
        twists, effective = self.body.twist(controls), controls.copy()
        if isinstance(self.body, BicycleCar):
            # At rest no steering turns the car; the policies must see what it will do.
            effective[:, 0] = gears * np.maximum(np.abs(controls[:, 0]), self.authority)
        jacobians = raw.control_jacobian(self.body, effective)
        # The point that is pulled is the pose, which moves straight ahead.
        ahead = twists * [1.0, 0.0]
        pull = raw.goal_policy(carrots, ahead, self.goal_gain, self.goal_damping, self.near)
        forces, metrics = raw.pull_back(raw.point_jacobian([0.0, 0.0]) @ jacobians, *pull)
        turn = raw.heading_policy(controls[:, 1], steerings, self.heading_gain, self.heading_weight)
        only_steering = np.array([[0.0, 1.0]])
        more = raw.pull_back(only_steering, turn[0][:, None], turn[1][:, None, None])
        push, weight = self._obstacles(lasers, twists)
        back = np.swapaxes(jacobians, 1, 2)
        forces = forces + more[0] + (back @ push[..., None])[..., 0]
        return raw.resolve(forces, metrics + more[1] + back @ weight @ jacobians)

    def _obstacles(self, lasers: Array, twists: Array) -> tuple[Array, Array]:
        """Forces (N, 2) and metrics (N, 2, 2) on the twists, of each beam on each disc."""
        robots, beams = np.nonzero(lasers < self.horizon)
        angles = full_circle(lasers.shape[1])[beams]
        points = lasers[robots, beams, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        places, radii = self.discs[:, None].transpose(2, 0, 1)  # (D, 1) each
        ahead, aside = points[:, 0] - places, points[:, 1]
        far = np.maximum(np.hypot(ahead, aside), 1e-9)  # (D, B) from every disc to every beam's end
        # How the distance grows with the twist: the disc's Jacobian, along the line of sight.
        rows = np.stack([-ahead / far, -aside / far * places])
        closing = -(rows * twists[robots].T[:, None]).sum(axis=0)
        away, weight = raw.obstacle_policy(
            far - radii, closing, self.push, self.brake, self.weight, self.fade
        )
        weighted = weight * rows
        of_each = partial(np.bincount, robots, minlength=len(lasers))
        forces = [of_each((row * away).sum(axis=0)) for row in weighted]
        metrics = [[of_each((row * other).sum(axis=0)) for other in rows] for row in weighted]
        return np.stack(forces, axis=-1, dtype=float), np.moveaxis(np.array(metrics, float), -1, 0)

    def _limit(
        self, lasers: Array, controls: Array, after: Array, gears: Array, left: Array
    ) -> Array:
        """Controls (N, 2) `after` a step within what the body can do, and safe."""
        body, (speeds, steerings) = self.body, after.T
        if isinstance(body, BicycleCar):
            steerings = np.clip(steerings, -body.max_steering, body.max_steering)
            curvatures = np.tan(steerings) / body.wheelbase
            most = np.where(gears > 0, body.max_speed, body.max_reverse)
            # A car that sets off before it has turned its wheels leaves on another arc.
            swinging = np.abs(steerings - controls[:, 1]) > self.settle
            most = np.where(swinging, np.minimum(most, 0.7 * np.abs(controls[:, 0])), most)
        else:
            steerings = np.clip(steerings, -body.max_turn, body.max_turn)
            curvatures, most = steerings / np.maximum(np.abs(speeds), 0.1), body.max_speed
        arcs, room = np.stack([curvatures, gears], axis=1), (self.discs, self.margin)
        taste = (self.braking, self.reserve, self.crawl, self.hurry)
        most = np.minimum(most, moves.safe_speeds(lasers, arcs, *room, left, *taste))
        most = np.where(left < self.arrived, 0.0, most)
        return np.stack([gears * np.clip(gears * speeds, 0.0, most), steerings], axis=1)


@lru_cache(maxsize=16)
def _for_body(controller: RMPController, body: BicycleCar | DifferentialDrive) -> RMPController:
    return replace(controller, body=body)
