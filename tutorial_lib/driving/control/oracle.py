"""An oracle that drives a fleet along geodesics: it knows the map and its own pose."""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.driving.control.arcs import ArcController
from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.driving.rollouts import Robots, Rollouts, drive, geodesic_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.interfaces import Controller
from tutorial_lib.world.simulation import Simulation


class OraclePolicy:
    """Rollouts each robot of a simulation to its own goal."""

    def __init__(
        self,
        paths: GridPaths,
        goals: ArrayLike,
        controller: Controller | None = None,
        reach: float = 2.0,
    ) -> None:
        """Work out the ways to `goals` (N, 2).

        Args:
            paths: the free space.
            goals: one for each robot, in metres.
            controller: drives to the waypoints; an `ArcController` unless given.
            reach: metres that a waypoint is ahead on the way at most.
        """
        self.fields: DistanceFields = paths.fields(goals)
        self.goals = self.fields.goals
        self.controller = ArcController() if controller is None else controller
        self.reach = reach

    def act(self, simulation: Simulation, robots: Robots | None = None) -> Array:
        """Actions for the robots where they are now.

        Args:
            simulation: as many robots as there are goals.
            robots: (M,) numbers of those to drive; all unless given.

        Returns:
            (M, 2), or (N, 2) for all.
        """
        count = len(self.goals)
        if len(simulation) != count:
            raise InputError(f"courier: {len(simulation)} robots, {count} goals; give as many")
        robots = np.arange(count) if robots is None else robots
        poses, caster = simulation.poses[robots], simulation.scene.caster
        targets = self.fields.waypoints(poses[:, :2], robots, caster, self.reach)
        return self.controller.act(simulation.observe(robots), to_local(poses, targets))

    def drive(self, simulation: Simulation) -> Rollouts:
        """Drive until every robot has reached its goal, touched something or run out of time.

        Raises:
            InputError: when no way leads a robot to its goal.
        """
        limit = geodesic_limit(self.fields.paths, simulation.poses, self.goals)
        return drive(simulation, self.act, self.goals, limit)
