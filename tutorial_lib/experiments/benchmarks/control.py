"""How many cars C drives in closed loop, and where the time goes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.estimators import WaypointNetwork, use_threads
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import scene_of, world_name

_T = TypeVar("_T")
FLEETS = (1, 64, 256)
WORLD = 20_000
NETWORK = "waypoint_k2"
THREADS = 2
"""Of the network."""
STAGES = ("sense", "network", "rmp", "move")
_ROUNDS, _QUICK_ROUNDS, _BLOCK = 12, 4, 5  # looks at the clock, and control steps between them


def run(options: Options) -> Report:
    """Measure every stage of C with k = 2 on fleets of one car and of many.

    The apartment of the first of `options.worlds` is driven in, or that of `WORLD`.
    """
    begun = time.perf_counter()
    worlds = options.worlds[:1] or (WORLD,)
    scene = scene_of(world_name("apartment", worlds[0]))
    use_threads(THREADS)
    predictor = WaypointNetwork(NETWORK)
    rounds = _QUICK_ROUNDS if options.quick else _ROUNDS
    rows = []
    for cars in FLEETS:
        loop = Loop(scene, predictor, cars, np.random.default_rng(options.seed))
        seconds = loop.measure(rounds)
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
    took = time.perf_counter() - begun
    note = (
        f"network: targets encoded once and kept; plain: every pair encoded for itself; "
        f"{THREADS} threads"
    )
    return Report("control", options.seed, worlds, options.quick, took, rows, (note,))


class Loop:
    """A fleet under C in closed loop, stage by stage."""

    def __init__(
        self, scene: Scene, predictor: WaypointNetwork, cars: int, rng: np.random.Generator
    ) -> None:
        """Put `cars` cars into a scene, each with a target of its own."""
        paths = GridPaths(scene.clearance)
        places = paths.points[paths.largest]
        self.simulation = Simulation(
            scene, random_free_poses(scene, BicycleCar(), places, cars, rng)
        )
        around = random_free_poses(scene, BicycleCar(), places, cars, rng)
        pictures = predictor.architecture.images
        poses = np.repeat(around[:, None], pictures, axis=1)
        self.contexts = predictor.view.render(scene, poses)
        self.predictor, self.controller = predictor, RMPController()
        self.targets = predictor.prepare(self.contexts)

    def measure(self, rounds: int) -> dict[str, float]:
        """Seconds of each stage of one control step, in the median round; `plain` is uncached."""
        taken = []
        for _ in range(rounds + 1):
            spent = dict.fromkeys((*STAGES, "plain"), 0.0)
            for _ in range(_BLOCK):
                self._step(spent)
            taken.append({stage: took / _BLOCK for stage, took in spent.items()})
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
