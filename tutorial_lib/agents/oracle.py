"""An oracle to compare with: it knows the map, its pose, and where the goals are."""

import numpy as np

from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.validation import floats, instance, integers
from tutorial_lib.world.simulation import Simulation


class OracleNavigation:
    """A `Navigation` of robots that follow geodesics.

    Attributes:
        arrived: (N,) is at its goal.
        given_up: (N,) always false.
    """

    def __init__(self, simulation: Simulation, paths: GridPaths, goals: Array) -> None:
        """Send the robots of a simulation to `goals` (N, 2 or 3), metres."""
        goals = floats("goals", goals)
        if goals.ndim != 2 or goals.shape[1] not in (2, 3):
            raise InputError(f"goals: shape {goals.shape}; give (N, 2) or (N, 3), one a robot")
        self._policy = OraclePolicy(simulation, paths, goals[:, :2])
        self.arrived, self.given_up = np.zeros((2, len(goals)), dtype=bool)

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2); a robot that has arrived stands still."""
        instance("observations", observations, Observation)
        most = len(self.arrived) - 1
        robots = integers("robots", robots, (len(observations),), least=0, most=most)
        gap = self._policy.simulation.poses[robots, :2] - self._policy.goals[robots]
        self.arrived[robots] = np.linalg.norm(gap, axis=1) < REACHED
        actions = self._policy.act(observations, robots)
        return np.where(self.arrived[robots, None], 0.0, actions)
