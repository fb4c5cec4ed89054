"""The task for a car, in pymunk: it drives to waypoints, with three-point turns where it must."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.three_point import ThreePointTurn
from tutorial_lib.exploration.episodes import Episodes
from tutorial_lib.exploration.task import STEPS, ExplorationTask
from tutorial_lib.interfaces import Observation
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.validation import floats
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.noise import DriftingOdometry, NoNoise
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Sensors
from tutorial_lib.world.simulation import STEP, Simulation

CAR_STEPS = 5
_HEADINGS = 36
import os
_BEHIND = float(os.environ.get("BEHIND", np.pi/2))
_AHEAD = float(os.environ.get("AHEAD", 0.5))
_LONGEST = float(os.environ.get("LONGEST", 16.0))
_FAR = float(os.environ.get("FAR", 0.3))
BODY = BicycleCar(max_speed=float(os.environ.get("SPEED", 0.8)))


class CarDriver:
    def __init__(self, cars: int) -> None:
        self._rmp, self._turns = RMPController(), ThreePointTurn(cars)
        self.turning = np.zeros(cars, bool)

    def act(self, seen: Observation, cars: NDArray[np.intp], waypoints: Array) -> Array:
        bearings = np.arctan2(waypoints[:, 1], waypoints[:, 0])
        far = np.linalg.norm(waypoints, axis=1)
        begin = ~self.turning[cars] & (np.abs(bearings) > _BEHIND) & (far > _FAR)
        self._turns.begin(cars[begin], seen.odometry[begin], bearings[begin])
        self.turning[cars] |= begin
        over = (np.abs(bearings) < _AHEAD) | (self._turns.seconds[cars] > _LONGEST)
        self.turning[cars] &= ~over
        actions = self._rmp.act(seen, waypoints)
        rows = np.flatnonzero(self.turning[cars])
        if len(rows):
            actions[rows] = self._turns.act(seen[rows], cars[rows])
        return actions


class CarTask(ExplorationTask):
    def __init__(self, scenes, episodes, rng, *, sensor="rgbd", noise=True, limit=STEPS, stops_itself=False):
        super().__init__(scenes, episodes, rng, sensor=sensor, noise=noise, limit=limit, stops_itself=stops_itself)
        car = BODY
        self._fleets = []
        self.turned = 0
        for number, (scene, rows) in enumerate(self._rows):
            free, turned = fitting(scene, car, self.poses[rows])
            self.turned += turned
            self.poses[rows] = free
            odometry = DriftingOdometry(int(rng.integers(2**32))) if noise else NoNoise()
            simulation = Simulation(scene, free, body=car, odometry_noise=odometry, sensors=Sensors(camera=None))
            self._fleets.append((simulation, rows, CarDriver(len(rows))))
        self.path = [self.poses.copy()]

    def step(self, waypoints):
        running = ~self.done
        waypoints = np.asarray(waypoints, float)
        stops = ~np.isfinite(waypoints).all(axis=1)
        self.poses, self.odometry = self.poses.copy(), self.odometry.copy()
        self.travelled = self.travelled.copy()
        for simulation, rows, driver in self._fleets:
            cars = np.flatnonzero((running & ~stops)[rows])
            places = to_world(simulation.odometry[cars], waypoints[rows[cars]])
            touched = np.zeros(len(rows), bool)
            for _ in range(CAR_STEPS):
                actions = np.zeros((len(rows), 2))
                if len(cars):
                    seen = simulation.observe(cars)
                    actions[cars] = driver.act(seen, cars, to_local(seen.odometry, places))
                before = simulation.poses
                simulation.step(actions)
                gone = np.linalg.norm(simulation.poses[:, :2] - before[:, :2], axis=1)
                self.travelled[rows[cars]] += gone[cars]
                touched |= simulation.touching
            self.collisions[rows[cars]] += touched[cars]
            going = rows[running[rows]]
            self.poses[going], self.odometry[going] = simulation.poses[running[rows]], simulation.odometry[running[rows]]
        self.steps[running] += 1
        self._stale |= running
        self.path.append(self.poses)
        self._end(running, np.where(stops, 0, 1))

    def _observation(self, image, ranges, odometry):
        found = super()._observation(image, ranges, odometry)
        from dataclasses import replace
        return replace(found, body=BODY)


def fitting(scene, car, poses):
    turn = np.arange(_HEADINGS) * 2 * np.pi / _HEADINGS
    turn = turn[np.argsort(np.abs((turn + np.pi) % (2 * np.pi) - np.pi), kind="stable")]
    tries = np.repeat(poses[:, None], _HEADINGS, axis=1)
    tries[..., 2] += turn
    free = is_free(scene, car, tries.reshape(-1, 3)).reshape(len(poses), -1)
    assert free.any(axis=1).all()
    first = free.argmax(axis=1)
    return tries[np.arange(len(poses)), first], int((first > 0).sum())
