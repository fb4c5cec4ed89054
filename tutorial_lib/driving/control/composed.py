"""Local control: C = C_RMP after C_WP (Meng 2020, III-B), and a random one to compare with."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import (
    Controller,
    LocalController,
    Observation,
    Robots,
    Targets,
    View,
    WaypointPredictor,
)
from tutorial_lib.validation import floats, instance, integers, whole, with_methods


def checked_waypoints(waypoints: ArrayLike, robots: int) -> Array:
    """Waypoints as (N, 2) float64, one for each of N robots.

    Raises:
        InputError: when one is missing or not finite.
    """
    waypoints = floats("waypoints", waypoints, ("N", 2))
    if len(waypoints) != whole("robots", robots, least=0):
        raise InputError(f"waypoints: {waypoints.shape}; give (N, 2) for {robots} robots")
    return np.ascontiguousarray(waypoints)


def checked_robots(observations: Observation, robots: Robots, targets: Targets) -> Robots:
    """Indices (M,) of robots that have targets, one for each observation.

    Raises:
        InputError: when there is another number of them, or one that has none.
    """
    most = len(targets) - 1 if hasattr(targets, "__len__") else None
    robots = integers("robots", robots, ("M",), least=0, most=most)
    if len(robots) != len(instance("observations", observations, Observation)):
        raise InputError(f"robots: {len(robots)}, observations: {len(observations)}; give as many")
    return robots


@dataclass(frozen=True)
class ComposedController:
    """C: predicts a waypoint, and drives to it by the laser; a `LocalController`.

    Attributes:
        predictor: C_WP, independent of the body.
        controller: C_RMP, independent of the target.
    """

    predictor: WaypointPredictor
    controller: Controller

    def __post_init__(self) -> None:
        with_methods("predictor", self.predictor, "predict")
        with_methods("controller", self.controller, "act")

    def act(self, observations: Observation, targets: Targets) -> Array:
        """Actions (N, 2) for robots that are to reach `targets`."""
        instance("observations", observations, Observation)
        waypoints, _ = self.predictor.predict(observations, targets)
        return self.controller.act(observations, waypoints)


class _Images:
    """A `View`: the camera's images as they are."""

    def of(self, observations: Observation) -> NDArray:
        """(N, H, W, 3)."""
        return observations.image


@dataclass(frozen=True)
class RandomWaypoints:
    """A `WaypointPredictor` that ignores its input: a waypoint somewhere 1 m behind to 3 m ahead.

    Attributes:
        rng: draws them.
    """

    rng: np.random.Generator
    view: View = field(default=_Images(), init=False)
    k: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        instance("rng", self.rng, np.random.Generator)

    def prepare(self, contexts: NDArray) -> Targets:
        """The contexts as they are."""
        return contexts

    def predict(self, observations: Observation, targets: Targets) -> tuple[Array, Array]:
        """Random waypoints (N, 2), and overlaps (N, 2) of one half."""
        del targets
        count = len(instance("observations", observations, Observation))
        waypoints = self.rng.uniform([-1.0, -1.5], [3.0, 1.5], size=(count, 2))
        return waypoints, np.full((count, 2), 0.5)


@dataclass(frozen=True)
class TargetPolicy:
    """A `Policy`: a local controller drives each robot to a target of its own.

    Attributes:
        controller: C, or any other `LocalController`.
        targets: N of them; an array of indices selects from them.
    """

    controller: LocalController
    targets: Targets

    def __post_init__(self) -> None:
        with_methods("controller", self.controller, "act")

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,)."""
        robots = checked_robots(observations, robots, self.targets)
        return self.controller.act(observations, self.targets[robots])
