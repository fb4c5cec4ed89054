"""One pymunk space for a fleet against one space for each car."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.generators import generate
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP, SUBSTEPS, Simulation

_STEPS = 10  # of control between two readings of the clock


@dataclass(frozen=True)
class Settings:
    """Settings of the benchmark.

    Attributes:
        cars: of the fleet.
        rounds: of ten control steps; the median counts.
    """

    cars: int = 256
    rounds: int = 12


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Measure car-steps per second of both in an apartment, and compare the trajectories."""
    rng, cars = np.random.default_rng(options.seed), settings.cars
    scene = Scene(generate("apartment", options.worlds[0]))
    paths = GridPaths(scene.clearance)
    starts = random_free_poses(scene, BicycleCar(), paths.points[paths.largest], cars, rng)
    actions = np.column_stack([rng.uniform(-0.3, 0.8, cars), rng.uniform(-0.45, 0.45, cars)])
    fleet = Simulation(scene, starts)
    separate = [SeparateCar(scene.plan.segments, pose) for pose in starts.tolist()]

    def step_separate() -> None:
        for car, action in zip(separate, actions.tolist(), strict=True):
            car.step(*action)

    speeds = {
        "fleet": cars * _steps_per_second(lambda: fleet.step(actions), settings.rounds),
        "separate": cars * _steps_per_second(step_separate, settings.rounds),
    }
    apart = np.abs(fleet.poses[:, :2] - [car.body.position for car in separate]).max()
    rows = [
        {"method": m, "cars": cars, "steps_per_s": s, "ratio": s / speeds["separate"]}
        for m, s in speeds.items()
    ]
    steps = settings.rounds * _STEPS
    note = f"after {steps} steps the trajectories are at most {apart:.1e} m apart"
    return rows, [note]


class SeparateCar:
    """One car in its own space, in plain Python: the baseline of the fleet."""

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


def _steps_per_second(step: Callable[[], None], rounds: int) -> float:
    """Control steps per second: the median over rounds."""
    speeds = []
    for _ in range(rounds):
        begun = time.perf_counter()
        for _ in range(_STEPS):
            step()
        speeds.append(_STEPS / (time.perf_counter() - begun))
    return float(np.median(speeds))


EXPERIMENT = Experiment(
    "fleet", run, (20_000,), settings=Settings(), quick_settings=Settings(rounds=3)
)
