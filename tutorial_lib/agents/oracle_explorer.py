"""An oracle that knows the world and drives a short path that keeps off the walls."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.exploration.motion import actions_towards
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.validation import flags, instance
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.noise import STOP

_STOP = 0.6  # metres from the goal
_AIM = np.deg2rad(8.0)  # off which it turns
_REACH = 0.6  # metres of its path that it looks ahead: a longer line cuts corners


class OracleExplorer:
    """An `ExplorerAgent` that is given the task on purpose, and so knows poses and walls."""

    def __init__(self, task: ExplorationTask) -> None:
        """Read poses and walls from `task`."""
        self._task = instance("task", task, ExplorationTask)

    def start(self, goals: Observation) -> None:
        """Begin episodes; the pictures of the goals are not needed."""
        instance("goals", goals, Observation)
        task, self._fields = self._task, list[tuple[DistanceFields, NDArray[np.intp]]]()
        worlds = np.array(task.episodes.worlds)
        for name in dict.fromkeys(task.episodes.worlds):
            rows = np.flatnonzero(worlds == name)
            paths = GridPaths(task.scenes[name].clearance)
            self._fields.append((paths.fields(task.goal_poses[rows, :2]), rows))

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots, waypoints (N, 2) of cars; those not `running` (N,) stop."""
        task = self._task
        instance("observations", observations, Observation)
        running = flags("running", running, (len(task),))
        places = self._waypoints()
        gap = np.linalg.norm(task.goal_poses[:, :2] - task.poses[:, :2], axis=1)
        stop = (gap < _STOP) | ~running
        if isinstance(observations.body, BicycleCar):
            return np.where(stop[:, None], np.nan, to_local(task.poses, places))
        return np.where(stop, STOP, actions_towards(task.poses, places, _AIM))

    def _waypoints(self) -> Array:
        """(N, 2) the farthest point in sight of each robot's path."""
        found = np.zeros((len(self._task), 2))
        names = dict.fromkeys(self._task.episodes.worlds)
        for name, (fields, rows) in zip(names, self._fields, strict=True):
            caster, goals = self._task.scenes[name].caster, np.arange(len(rows))
            found[rows] = fields.waypoints(self._task.poses[rows, :2], goals, caster, _REACH)
        return found
