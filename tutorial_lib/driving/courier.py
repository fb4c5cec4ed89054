"""An oracle that drives a fleet along geodesics: it knows the map and its own pose."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.arcs import ArcController
from tutorial_lib.driving.gridpath import DistanceFields, GridPaths
from tutorial_lib.driving.metrics import REACHED, time_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.interfaces import Controller
from tutorial_lib.world.simulation import STEP, Simulation


@dataclass(frozen=True)
class Drives:
    """How a fleet's drives ended.

    Attributes:
        reached: (N,) the target was reached in time, and nothing was touched.
        collided: (N,) something was touched.
        seconds: (N,) until the drive ended.
        poses: (T, N, 3) where the robots were; one that is done rolls to a stop.
    """

    reached: NDArray[np.bool_]
    collided: NDArray[np.bool_]
    seconds: Array
    poses: Array


class OracleCourier:
    """Drives each robot of a simulation to its own goal."""

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

    def act(self, simulation: Simulation) -> Array:
        """Actions (N, 2) for the robots where they are now."""
        poses, numbers = simulation.poses, np.arange(len(self.goals))
        if len(poses) != len(numbers):
            raise InputError(f"courier: {len(poses)} robots and {len(numbers)} goals; give as many")
        caster = simulation.scene.caster
        targets = self.fields.waypoints(poses[:, :2], numbers, caster, self.reach)
        return self.controller.act(simulation.observe(), to_local(poses, targets))

    def drive(self, simulation: Simulation) -> Drives:
        """Drive until every robot has reached its goal, touched something or run out of time.

        Raises:
            InputError: when no way leads a robot to its goal.
        """
        shortest = self.fields.paths.fields(self.goals, shortest=True)
        starts, count = simulation.poses[:, :2], len(simulation)
        limit = time_limit(shortest.distance(starts, np.arange(count)))
        for lost in np.flatnonzero(~np.isfinite(limit)):
            raise InputError(f"goal: no way leads robot {lost} to its goal; choose another goal")
        reached, over = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        seconds, track = np.zeros(count), [simulation.poses]
        while not over.all():
            actions = self.act(simulation)
            actions[over] = 0.0
            simulation.step(actions)
            track.append(simulation.poses)
            gap = np.linalg.norm(simulation.poses[:, :2] - self.goals, axis=1)
            seconds[~over] += STEP
            reached |= ~over & ~simulation.collided & (gap < REACHED)
            over |= reached | simulation.collided | (seconds >= limit)
        return Drives(reached, simulation.collided & ~reached, seconds, np.stack(track))
