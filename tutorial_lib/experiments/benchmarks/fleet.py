"""One space for a fleet against one space for each car."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
import pymunk

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.generators import generate
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP, SUBSTEPS, Simulation

CARS = 256
WORLD = 20_000
_BLOCK, _ROUNDS = 10, 12  # control steps between two looks at the clock, and how often


def run(options: Options) -> Report:
    """Measure car-steps per second of both, and compare the trajectories.

    The apartment of the first of `options.worlds` is driven in, or that of `WORLD`.
    """
    begun, rng = time.perf_counter(), np.random.default_rng(options.seed)
    worlds = options.worlds[:1] or (WORLD,)
    scene = Scene(generate("apartment", worlds[0]))
    paths = GridPaths(scene.clearance)
    starts = random_free_poses(scene, BicycleCar(), paths.points[paths.largest], CARS, rng)
    actions = np.column_stack([rng.uniform(-0.3, 0.8, CARS), rng.uniform(-0.45, 0.45, CARS)])
    fleet = Simulation(scene, starts)
    separate = [SeparateCar(scene.plan.segments, pose) for pose in starts.tolist()]

    def step_separate() -> None:
        for car, action in zip(separate, actions.tolist(), strict=True):
            car.step(*action)

    rounds = 3 if options.quick else _ROUNDS
    speeds = {
        "fleet": _car_steps(lambda: fleet.step(actions), rounds),
        "separate": _car_steps(step_separate, rounds),
    }
    apart = np.abs(fleet.poses[:, :2] - [car.body.position for car in separate]).max()
    rows = [
        {"method": m, "cars": CARS, "steps_per_s": s, "ratio": s / speeds["separate"]}
        for m, s in speeds.items()
    ]
    steps = rounds * _BLOCK
    note = f"after {steps} steps the trajectories are at most {apart:.1e} m apart"
    took = time.perf_counter() - begun
    return Report("fleet", options.seed, worlds, options.quick, took, rows, (note,))


class SeparateCar:
    """One car in a space of its own, in plain Python: what the fleet is measured against."""

    def __init__(self, segments: Array, pose: list[float]) -> None:
        """Put a car at `pose` among wall `segments` (S, 4)."""
        self.car, self.speed, self.steering = BicycleCar(), 0.0, 0.0
        self.space = pymunk.Space()
        self.space.damping, self.space.collision_slop = 0.0, 0.001
        self.body = pymunk.Body(1.0, 1.0)
        self.body.position, self.body.angle = (pose[0], pose[1]), pose[2]
        corners = [tuple(corner) for corner in self.car.footprint.tolist()]
        self.space.add(self.body, pymunk.Poly(self.body, corners))
        for x0, y0, x1, y1 in segments.tolist():
            wall = pymunk.Segment(self.space.static_body, (x0, y0), (x1, y1), 0.0)
            self.space.add(wall)

    def step(self, speed: float, steering: float) -> None:
        """Drive for one control step, as `Simulation.step` does."""
        car, dt = self.car, STEP / SUBSTEPS
        for _ in range(SUBSTEPS):
            self.speed += _clip(speed - self.speed, car.acceleration * dt)
            self.steering += _clip(steering - self.steering, car.steering_rate * dt)
            turn = self.speed * math.tan(self.steering) / car.wheelbase
            heading, scale = self.body.angle + 1.5 * dt * turn, 1.0 / dt
            self.body.force = (
                math.cos(heading) * self.speed * scale,
                math.sin(heading) * self.speed * scale,
            )
            self.body.torque = turn * scale
            self.space.step(dt)


def _clip(value: float, most: float) -> float:
    return min(max(value, -most), most)


def _car_steps(step: Callable[[], None], rounds: int) -> float:
    """Car-steps per second: the median over rounds."""
    speeds = []
    for _ in range(rounds):
        begun = time.perf_counter()
        for _ in range(_BLOCK):
            step()
        speeds.append(CARS * _BLOCK / (time.perf_counter() - begun))
    return float(np.median(speeds))
