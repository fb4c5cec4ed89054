"""How many steps per second agents explore, with many episodes in lock-step."""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import check_shipped, make_explorer
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.exploration import World, make_world
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.exploration.task import SENSORS, ExplorationTask
from tutorial_lib.learning.threads import use_threads


@dataclass(frozen=True)
class Settings:
    """Settings of the benchmark.

    Attributes:
        episodes: in lock-step.
        steps: of each, that are timed.
        warmup_steps: steps before that, in which kernels are compiled.
        threads: of the network.
    """

    episodes: int = 64
    steps: int = 150
    warmup_steps: int = 10
    threads: int = 2


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Time agents with the true geometry, and with the networks that are shipped."""
    use_threads(settings.threads)
    each = -(-settings.episodes // len(DIFFICULTIES))
    world = make_world(options.worlds[0], "wayfinding", each, options.seed)
    world = replace(world, episodes=world.episodes[slice(-settings.episodes, None)])
    agents = [(agent, "geometry") for agent in ("nts", "fbe", "random", "oracle")]
    agents += [("nts", sensor) for sensor in SENSORS if _is_shipped(sensor)]
    rows = [_row(world, agent, model, options, settings) for agent, model in agents]
    return rows, ["model: the true geometry, or the network of that sensor where it is shipped"]


def _row(
    world: World, agent: str, model: str, options: Options, settings: Settings
) -> dict[str, Any]:
    """Steps of all robots under way, over the seconds that they took."""
    rng = np.random.default_rng(options.seed)
    sensor = "rgb" if model == "rgb" else "rgbd"
    task = ExplorationTask(world.scenes, world.episodes, rng, sensor=sensor)
    explorer = make_explorer(agent, task, sensor, rng, geometry=model == "geometry")
    explorer.start(task.goals())

    def drive(steps: int) -> None:
        for _ in range(steps):
            task.step(explorer.act(task.observe(), ~task.done))

    drive(settings.warmup_steps)
    begun, before = time.perf_counter(), task.steps.sum()
    drive(settings.steps)
    took, done = time.perf_counter() - begun, task.steps.sum() - before
    row = {"agent": agent, "model": model, "episodes": len(task), "steps": int(done)}
    return row | {"steps_per_s": done / took, "running": done / settings.steps}


def _is_shipped(sensor: str) -> bool:
    try:
        check_shipped(("nts",), sensor)
    except InputError:
        return False
    return True


EXPERIMENT = Experiment(
    "explore", run, (20_001,), settings=Settings(), quick_settings=Settings(steps=50)
)
