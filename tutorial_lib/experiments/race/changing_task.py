"""A task whose building changes while its robots stand still."""

from __future__ import annotations

import numpy as np

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.scene import Scene


class ChangingTask(ExplorationTask):
    """Robots in one building, which may be rebuilt between two goals."""

    def rebuild(self, scene: Scene) -> None:
        """Let the building be another from now on.

        A robot that stands where something is put is pushed to the nearest free place; its odometry
        does not notice.
        """
        (name,) = self.scenes
        self.scenes = {name: scene}
        self._rows = [(scene, np.arange(len(self)))]
        poses = self.poses.copy()
        caught = scene.clearance.at(poses[:, :2]) < DifferentialDrive.radius
        paths = GridPaths(scene.clearance)
        free = paths.points[paths.largest]
        for number in np.flatnonzero(caught):
            nearest = np.linalg.norm(free - poses[number, :2], axis=1).argmin()
            poses[number, :2] = free[nearest]
        self.carry(poses)
