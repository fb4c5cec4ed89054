"""A robot that is told where to go by others."""

from __future__ import annotations

import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.observation import Observation


class StandStill:
    """A `Controller` that leaves the driving to the local policy."""

    def act(self, observations: Observation, waypoints: Array) -> Array:
        """Actions (N, 2): none."""
        del observations
        return np.zeros_like(waypoints)
