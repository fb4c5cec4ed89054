"""An oracle that drives a fleet along geodesics: it knows the map and every pose."""

from numpy.typing import ArrayLike

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.interfaces import Controller, Observation, Robots
from tutorial_lib.world.simulation import Simulation

PARKING = RMPController(begin=0.45, miss=0.08, arrived=0.08, lane_reach=1.2, crawl=0.15)
"""Parks exactly, since an oracle's waypoints are exact. All trajectories are recorded with it: with
other settings the networks that come with the library could not be trained again."""


class OraclePolicy:
    """A `Policy` that drives each robot of a simulation to its own goal.

    The waypoint is the farthest point of the geodesic in line of sight (Meng 2020, IV).
    """

    def __init__(
        self,
        simulation: Simulation,
        paths: GridPaths,
        goals: ArrayLike,
        controller: Controller | None = None,
        reach: float = 2.0,
    ) -> None:
        """Compute the distance fields of all goals.

        Args:
            simulation: N robots, whose poses it reads.
            paths: the free space.
            goals: (N, 2), one for each robot, in metres.
            controller: drives to the waypoints; `PARKING` unless given.
            reach: metres that a waypoint is ahead on the geodesic at most.

        Raises:
            InputError: when there are not as many goals as robots.
        """
        self.fields: DistanceFields = paths.fields(goals)
        self.goals = self.fields.goals
        if len(simulation) != len(self.goals):
            raise InputError(
                f"oracle: {len(simulation)} robots, {len(self.goals)} goals; give as many"
            )
        self.simulation = simulation
        self.controller = PARKING if controller is None else controller
        self.reach = reach

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,), from what they observe now."""
        poses, caster = self.simulation.poses[robots], self.simulation.scene.caster
        targets = self.fields.waypoints(poses[:, :2], robots, caster, self.reach)
        return self.controller.act(observations, to_local(poses, targets))
