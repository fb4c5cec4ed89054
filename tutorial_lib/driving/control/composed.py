"""Local control: C = C_RMP after C_WP (Meng 2020, III-B), and a random one to compare with."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Controller, Observation, Targets, WaypointPredictor


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
        predictor: C_WP, which knows nothing of the body.
        controller: C_RMP, which knows nothing of the target.
    """

    predictor: WaypointPredictor
    controller: Controller

    def act(self, observations: Observation, targets: Targets) -> Array:
        """Actions (N, 2) for robots that are to reach `targets`."""
        waypoints, _ = self.predictor.predict(observations, targets)
        return self.controller.act(observations, waypoints)


@dataclass(frozen=True)
class RandomWaypoints:
    """A `WaypointPredictor` that does not look: a waypoint somewhere 1 m behind to 3 m ahead.

    Attributes:
        rng: draws them.
    """

    rng: np.random.Generator

    def predict(self, observations: Observation, targets: Targets) -> tuple[Array, Array]:
        """Random waypoints (N, 2), and overlaps (N, 2) of one half."""
        del targets
        count = len(observations)
        waypoints = self.rng.uniform([-1.0, -1.5], [3.0, 1.5], size=(count, 2))
        return waypoints, np.full((count, 2), 0.5)
