"""Robot bodies: what an action does to speed and steering, and those to the pose.

A body has a footprint and two functions. `respond` turns commanded into actual controls, with the
limits of motors and servos; `twist` turns controls into a velocity ahead and a turning rate.
"""

from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, compose
from tutorial_lib.validation import floats, match, number


class Body(Protocol):
    """What the simulation asks of a robot."""

    @property
    def footprint(self) -> Array:
        """(K, 2) convex outline in the robot's frame, metres."""

    def respond(self, controls: Array, actions: Array, seconds: float) -> Array:
        """Controls (N, 2) after `seconds` under `actions` (N, 2), from `controls` (N, 2)."""

    def twist(self, controls: Array) -> Array:
        """Velocity ahead in m/s and turning rate in rad/s, (N, 2), for controls (N, 2)."""


@dataclass(frozen=True)
class BicycleCar:
    """A car with front steering; its pose is that of the middle of the rear axle.

    Controls are speed in m/s and steering angle in rad. It cannot turn on the spot: its tightest
    circle has the radius wheelbase / tan(max_steering), 0.62 m.

    Attributes:
        wheelbase: metres between the axles, at most its length.
        length, width: metres; both overhangs are equal.
        max_steering: rad.
        steering_rate: rad/s.
        max_reverse, max_speed: m/s.
        acceleration: m/s^2, also when braking.
    """

    wheelbase: float = 0.30
    length: float = 0.42
    width: float = 0.24
    max_steering: float = 0.45
    steering_rate: float = 3.2
    max_reverse: float = 0.3
    max_speed: float = 0.8
    acceleration: float = 2.0

    def __post_init__(self) -> None:
        _check_amounts(self, "max_reverse")
        if not self.max_steering < np.pi / 2:
            raise InputError(f"max_steering: {self.max_steering}; give rad below pi / 2")
        if self.wheelbase > self.length:
            raise InputError(
                f"wheelbase: {self.wheelbase}; give at most the length, {self.length} m"
            )

    @property
    def footprint(self) -> Array:
        """(4, 2) corners, counter-clockwise from the rear right."""
        rear, side = -(self.length - self.wheelbase) / 2, self.width / 2
        front = rear + self.length
        return np.array([[rear, -side], [front, -side], [front, side], [rear, side]])

    @property
    def turning_radius(self) -> float:
        """Radius in metres of the tightest circle of the rear axle."""
        return self.wheelbase / float(np.tan(self.max_steering))

    def respond(self, controls: Array, actions: Array, seconds: float) -> Array:
        """Speed and steering move towards what is commanded, as fast as motor and servo can."""
        low = [-self.max_reverse, -self.max_steering]
        high = [self.max_speed, self.max_steering]
        rates = [self.acceleration, self.steering_rate]
        return _approach(controls, np.clip(actions, low, high), np.multiply(rates, seconds))

    def twist(self, controls: Array) -> Array:
        """The kinematic bicycle: turning rate = speed * tan(steering) / wheelbase."""
        speed, steering = controls[..., 0], controls[..., 1]
        return np.stack([speed, speed * np.tan(steering) / self.wheelbase], axis=-1)


@dataclass(frozen=True)
class DifferentialDrive:
    """A round robot with two driven wheels, which turns in place; its pose is its middle.

    Controls are speed in m/s and turning rate in rad/s.

    Attributes:
        radius: metres.
        max_speed: m/s, either way.
        max_turn: rad/s.
        acceleration: m/s^2.
        turn_acceleration: rad/s^2.
    """

    radius: float = 0.18
    max_speed: float = 0.5
    max_turn: float = 1.5
    acceleration: float = 2.0
    turn_acceleration: float = 10.0

    def __post_init__(self) -> None:
        _check_amounts(self)

    @property
    def footprint(self) -> Array:
        """(12, 2) a regular polygon just around the robot's circle."""
        angles = np.arange(12) * np.pi / 6
        outer = self.radius / np.cos(np.pi / 12)
        return outer * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    def respond(self, controls: Array, actions: Array, seconds: float) -> Array:
        """Speed and turning rate move towards what is commanded, as fast as the motors can."""
        high = np.array([self.max_speed, self.max_turn])
        rates = [self.acceleration, self.turn_acceleration]
        return _approach(controls, np.clip(actions, -high, high), np.multiply(rates, seconds))

    def twist(self, controls: Array) -> Array:
        """The controls are the twist."""
        return np.asarray(controls)


def advance(poses: ArrayLike, twists: ArrayLike, seconds: ArrayLike) -> Array:
    """Poses (..., 3) after moving with constant twists (..., 2) on an arc, without contact.

    >>> advance([0.0, 0.0, 0.0], [1.0, np.pi / 2], 1.0).round(4).tolist()
    [0.6366, 0.6366, 1.5708]
    """
    poses, twists = floats("poses", poses, (..., 3)), floats("twists", twists, (..., 2))
    seconds = floats("seconds", seconds)
    match(poses=poses.shape[:-1], twists=twists.shape[:-1], seconds=seconds.shape)
    return moved(poses, twists, seconds)


def moved(poses: Array, twists: Array, seconds: Array | float) -> Array:
    """`advance` for arrays that are right already."""
    turn = twists[..., 1] * seconds
    # The chord of the arc is its length times sinc, and points halfway through the turn.
    chord = twists[..., 0] * seconds * np.sinc(turn / (2 * np.pi))
    motion = np.stack([chord * np.cos(turn / 2), chord * np.sin(turn / 2), turn], axis=-1)
    return compose(poses, motion)


def _check_amounts(body: "BicycleCar | DifferentialDrive", *may_be_zero: str) -> None:
    """Check that all that a body is made of are numbers above 0, or 0 where that makes sense.

    Raises:
        InputError: naming the first that is not.
    """
    for field in fields(body):
        amount = getattr(body, field.name)
        if field.name in may_be_zero:
            number(field.name, amount, least=0.0)
        else:
            number(field.name, amount, above=0.0)


def _approach(values: Array, goals: Array, most: Array) -> Array:
    """Move each value towards its goal by at most `most`."""
    return values + np.clip(goals - values, -most, most)
