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


def checked_waypoints(waypoints: ArrayLike, robots: int) -> Array:
    """Waypoints as (N, 2) float64, one for each of N robots.

    Raises:
        InputError: when one is missing or not finite.
    """
    waypoints = np.ascontiguousarray(waypoints, dtype=float)
    if waypoints.shape != (robots, 2) or not np.isfinite(waypoints).all():
        raise InputError(f"waypoints: {waypoints.shape}; give finite (N, 2) for {robots} robots")
    return waypoints


@dataclass(frozen=True)
class ComposedController:
    """C: predicts a waypoint, and drives to it by the laser; a `LocalController`.

    Attributes:
        predictor: C_WP, independent of the body.
        controller: C_RMP, independent of the target.
    """

    predictor: WaypointPredictor
    controller: Controller

    def act(self, observations: Observation, targets: Targets) -> Array:
        """Actions (N, 2) for robots that are to reach `targets`."""
        waypoints, _ = self.predictor.predict(observations, targets)
        return self.controller.act(observations, waypoints)


@dataclass(frozen=True)
class RandomWaypoints:
    """A `WaypointPredictor` that ignores its input: a waypoint somewhere 1 m behind to 3 m ahead.

    Attributes:
        rng: draws them.
    """

    rng: np.random.Generator
    view: View = field(default=None, init=False)
    k: int = field(default=0, init=False)

    def prepare(self, contexts: NDArray) -> Targets:
        """The contexts as they are."""
        return contexts

    def predict(self, observations: Observation, targets: Targets) -> tuple[Array, Array]:
        """Random waypoints (N, 2), and overlaps (N, 2) of one half."""
        del targets
        count = len(observations)
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

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,)."""
        return self.controller.act(observations, self.targets[robots])
