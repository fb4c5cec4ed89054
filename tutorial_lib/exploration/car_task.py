"""The same task for a car, in pymunk: it cannot turn in place.

It drives to waypoints with a panorama, or is steered with a camera ahead.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.control.turning import TurningController
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.motion import FORWARD_METRES
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, to_local, to_world, wrap
from tutorial_lib.validation import floats
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.noise import DriftingOdometry, NoNoise
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Sensors
from tutorial_lib.world.simulation import STEP, Simulation, checked_actions

CAR = BicycleCar(max_speed=DifferentialDrive.max_speed)
"""As fast as the round robot, 0.5 m/s."""
STEPS_EACH = round(FORWARD_METRES / CAR.max_speed / STEP)
"""Control steps from one waypoint to the next, 0.5 s: in that time the round robot does one action
forward at its speed. As many waypoints as actions are the same time and, straight ahead, the same
metres."""
_HEADINGS = 36  # that are tried at a start


class CarTask(ExplorationTask):
    """N cars, each with an episode of its own: `ExplorationTask` with waypoints for actions.

    Each has the round robot's panorama, and the wheel odometry of a car. Low-level control is the
    robot's own: RMP by the laser, with three-point turns. A car that does not fit into its start is
    turned there, as little as need be.

    Attributes:
        turned: (N,) whether a car was turned at its start.
    """

    def _put_down(self, rng: np.random.Generator, noise: bool) -> None:
        """Make the cars ready to move from where they fit."""
        self.turned, self._fleets = np.zeros(len(self), bool), list[_Fleet]()
        for scene, rows in self._rows:
            poses = turned_to_fit(scene, self.poses[rows])
            self.turned[rows] = (poses != self.poses[rows]).any(axis=1)
            self.poses[rows] = poses
            odometry = DriftingOdometry(int(rng.integers(2**32))) if noise else NoNoise()
            self._fleets.append(_Fleet(scene, poses, odometry, rows))

    def observe(self) -> Observation:
        """What the cars' sensors measure now; those that are done see what they saw last."""
        seen = super().observe()
        for fleet in self._fleets:
            here = fleet.simulation.observe()
            for name in ("laser", "speed", "steering"):
                getattr(seen, name)[fleet.rows] = getattr(here, name)
        return replace(seen, body=CAR)

    def _carry_out(self, actions: ArrayLike, running: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Drive to waypoints for half a second; cars that are done stand still.

        Args:
            actions: (N, 2) waypoints in the cars' frames, metres; a row that is not a number stops.
            running: (N,) which cars drive.

        Returns:
            Which cars (N,) stop.

        Raises:
            InputError: when a waypoint is missing or infinite.
        """
        waypoints = floats("waypoints", actions, (len(self), 2), nan=True)
        stops = np.any(np.isnan(waypoints), axis=1)
        going = running & ~stops
        self._drive(running, lambda fleet: fleet.drive(waypoints[fleet.rows], going[fleet.rows]))
        return stops

    def _drive(
        self,
        running: NDArray[np.bool_],
        drive: Callable[[_Fleet], tuple[Array, NDArray[np.bool_]]],
    ) -> None:
        """Let each world's cars drive, and note where the `running` ones (N,) came."""
        self.poses, self.odometry = self.poses.copy(), self.odometry.copy()
        self.travelled = self.travelled.copy()
        for fleet in self._fleets:
            rows = fleet.rows
            metres, touched = drive(fleet)
            self.travelled[rows] += metres * running[rows]
            self.collisions[rows] += touched & running[rows]
            self.poses[rows] = fleet.simulation.poses
            self.odometry[rows] = fleet.simulation.odometry


class SteeredCarTask(CarTask):
    """N cars that are steered ten times a second, each with a camera that looks ahead."""

    camera = Camera()

    def _carry_out(self, actions: ArrayLike, running: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Drive for a tenth of a second; cars that are done brake.

        Args:
            actions: (N, 2) speed in m/s and steering in rad; a car does what it can of it.
            running: (N,) which cars drive.

        Returns:
            Which cars (N,) stop: none.

        Raises:
            InputError: when one is missing or not finite.
        """
        controls = checked_actions(actions, len(self)) * running[:, None]
        self._drive(running, lambda fleet: fleet.step(controls[fleet.rows]))
        return np.zeros(len(self), bool)


class _Fleet:
    """The cars in one world.

    Attributes:
        simulation: of the cars.
        rows: (M,) their numbers in the task.
    """

    def __init__(
        self, scene: Scene, poses: Array, odometry: DriftingOdometry | NoNoise, rows: NDArray
    ) -> None:
        sensors = Sensors(camera=None)
        self.simulation = Simulation(
            scene, poses, body=CAR, odometry_noise=odometry, sensors=sensors
        )
        self.rows, self._control = rows, TurningController(len(rows))

    def drive(self, waypoints: Array, going: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
        """Drive the cars that are `going` (M,) to waypoints (M, 2), and brake the others.

        Returns:
            Metres (M,) of each, and whether it touched anything.
        """
        simulation, cars = self.simulation, np.flatnonzero(going)
        places = to_world(simulation.odometry[cars], waypoints[cars])
        metres, touched = np.zeros(len(going)), np.zeros(len(going), bool)
        for _ in range(STEPS_EACH):
            actions, seen = np.zeros((len(going), 2)), simulation.observe(cars)
            actions[cars] = self._control.act(seen, cars, to_local(seen.odometry, places))
            moved, touching = self.step(actions)
            metres, touched = metres + moved, touched | touching
        return metres, touched

    def step(self, actions: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Do actions (M, 2) for a control step; metres (M,), and whether each touches anything."""
        before = self.simulation.poses
        self.simulation.step(actions)
        moved = np.linalg.norm(self.simulation.poses[:, :2] - before[:, :2], axis=1)
        return moved, self.simulation.touching


def turned_to_fit(scene: Scene, poses: Array) -> Array:
    """Poses (N, 3) at the same places, each at the nearest heading at which the car fits.

    Raises:
        InputError: when it fits with no heading.
    """
    turns = np.sort(wrap(np.arange(_HEADINGS) * 2 * np.pi / _HEADINGS))
    turns = turns[np.argsort(np.abs(turns), kind="stable")]
    tries = np.repeat(poses[:, None], _HEADINGS, axis=1)
    tries[..., 2] += turns
    free = is_free(scene, CAR, tries.reshape(-1, 3)).reshape(len(poses), -1)
    if not free.any(axis=1).all():
        x, y = poses[~free.any(axis=1)][0, :2]
        raise InputError(f"episodes: the car does not fit at ({x:.2f}, {y:.2f}); move the start")
    return tries[np.arange(len(poses)), free.argmax(axis=1)]
