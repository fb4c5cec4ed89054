"""How many cars C drives per second in closed loop, and which stage takes how long."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import scene_of, world_name

_T = TypeVar("_T")
STAGES = ("sense", "network", "rmp", "move")
_STEPS = 5  # of control between two readings of the clock


@dataclass(frozen=True)
class Settings:
    """Settings of the benchmark.

    Attributes:
        network: of C.
        fleets: numbers of cars.
        threads: of the network.
        rounds: of five control steps; the median counts.
    """

    network: str = "waypoint_k2"
    fleets: tuple[int, ...] = (1, 64, 256)
    threads: int = 2
    rounds: int = 12


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Measure every stage of C with k = 2, for one car and for fleets, in an apartment."""
    scene = scene_of(world_name("apartment", options.worlds[0]))
    use_threads(settings.threads)
    predictor = WaypointNetwork(settings.network)
    rows: Rows = []
    for cars in settings.fleets:
        loop = Loop(scene, predictor, cars, np.random.default_rng(options.seed))
        seconds = loop.measure(settings.rounds)
        total = sum(seconds[stage] for stage in STAGES)
        for stage, took in {**seconds, "all": total}.items():
            rows.append(
                {
                    "cars": cars,
                    "stage": stage,
                    "ms": 1e3 * took,
                    "share": None if stage == "plain" else took / total,
                    "car_steps_per_s": cars / took,
                    "plain_over_cached": seconds["plain"] / took if stage == "network" else None,
                }
            )
    note = (
        f"network: targets encoded once and kept; plain: every pair encoded for itself; "
        f"{settings.threads} threads"
    )
    return rows, [note]


class Loop:
    """A fleet driven by C in closed loop, timed stage by stage."""

    def __init__(
        self, scene: Scene, predictor: WaypointNetwork, cars: int, rng: np.random.Generator
    ) -> None:
        """Place `cars` cars in a scene, each with its own target."""
        paths = GridPaths(scene.clearance)
        places = paths.points[paths.largest]
        self.simulation = Simulation(
            scene, random_free_poses(scene, BicycleCar(), places, cars, rng)
        )
        around = random_free_poses(scene, BicycleCar(), places, cars, rng)
        images = predictor.architecture.images
        poses = np.repeat(around[:, None], images, axis=1)
        self.contexts = predictor.view.render(scene, poses)
        self.predictor, self.controller = predictor, RMPController()
        self.targets = predictor.prepare(self.contexts)

    def measure(self, rounds: int) -> dict[str, float]:
        """Seconds of each stage of a control step, in the median round; `plain` is uncached."""
        taken = []
        for _ in range(rounds + 1):
            spent = dict.fromkeys((*STAGES, "plain"), 0.0)
            for _ in range(_STEPS):
                self._step(spent)
            taken.append({stage: took / _STEPS for stage, took in spent.items()})
        # The first round compiles.
        in_order = sorted(taken[1:], key=lambda spent: sum(spent[stage] for stage in STAGES))
        return in_order[len(in_order) // 2]

    def _step(self, spent: dict[str, float]) -> None:
        """One control step; the time of each stage is added to `spent`."""
        seen: Observation = _timed(spent, "sense", self.simulation.observe)
        waypoints, _ = _timed(spent, "network", lambda: self.predictor.predict(seen, self.targets))
        _timed(spent, "plain", lambda: self.predictor.predict_uncached(seen, self.contexts))
        actions = _timed(spent, "rmp", lambda: self.controller.act(seen, waypoints))
        _timed(spent, "move", lambda: self.simulation.step(actions))


def _timed(spent: dict[str, float], stage: str, work: Callable[[], _T]) -> _T:
    begun = time.perf_counter()
    result = work()
    spent[stage] += time.perf_counter() - begun
    return result


EXPERIMENT = Experiment(
    "control", run, (20_000,), settings=Settings(), quick_settings=Settings(rounds=4)
)
