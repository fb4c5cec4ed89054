"""Records what robots sense and do in a closed loop, as trajectories."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.validation import instance, whole, with_methods
from tutorial_lib.world.noise import OdometryNoise
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP, Simulation


class Recorder:
    """Records what the moving robots sense and do."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._steps: list[tuple[Robots, tuple[NDArray[np.floating], ...]]] = []

    def __call__(
        self, simulation: Simulation, robots: Robots, seen: Observation, actions: Array
    ) -> None:
        """Keep one step, before it is made."""
        laser = seen.laser.astype(np.float32)
        poses = simulation.poses[robots]
        row = (poses, seen.odometry, laser, seen.speed, seen.steering, actions)
        self._steps.append((robots, row))

    def trajectory(self, world: str, seed: int, robot: int) -> Trajectory:
        """The trajectory of one robot."""
        rows = []
        for robots, row in self._steps:
            place = np.searchsorted(robots, robot)
            if place == len(robots) or robots[place] != robot:
                break  # a robot that is done does not move again
            rows.append([column[place] for column in row])
        columns = (np.array(column) for column in zip(*rows, strict=True))
        poses, odometry, laser, speed, steering, actions = columns
        timestamps = np.arange(len(rows), dtype=float) * STEP
        return Trajectory(world, seed, poses, odometry, laser, speed, steering, actions, timestamps)


def check_recipe(world: str, scene: Scene, seed: int, odometry_noise: OdometryNoise | None) -> None:
    """Check what every recording needs.

    Raises:
        InputError: naming what is wrong.
    """
    instance("world", world, str)
    instance("scene", scene, Scene)
    whole("seed", seed, least=0)
    if odometry_noise is not None:
        with_methods("odometry_noise", odometry_noise, "measure")
