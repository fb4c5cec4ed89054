"""Episodes of exploration in one world, and what agents make of them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.experiments.common.explorers import make_explorer, own_explorer
from tutorial_lib.experiments.common.report import CAR, ROUND, Fault, Options
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.exploration.car_task import CarTask
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    Episodes,
    draw_episodes,
    exploration_world,
)
from tutorial_lib.exploration.task import ExplorationTask, explore
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

Key = tuple[str, str, str]
"""What sets the rows of an agent apart: its name, the signs, and the sensor or the condition."""
WORLDS = tuple(range(20_000, 20_020))
"""Seeds of the test worlds."""
VALIDATION = tuple(range(10_100, 10_108))
"""Seeds of worlds in which options are compared."""
AT_STEPS = (125, 250)
"""Steps at which success is reported besides."""


@dataclass(frozen=True)
class World:
    """One world with its episodes.

    Attributes:
        seed: of the world, and of what is random in it.
        scenes: the world by its name.
        episodes: as many of each difficulty.
    """

    seed: tuple[int, ...]
    scenes: dict[str, Scene]
    episodes: Episodes


def make_world(seed: int, signs: str, each: int, drawn: int, palette: str = "standard") -> World:
    """A world and its episodes; with and without signs they start and end at the same places.

    Args:
        seed: of the world.
        signs: "plain" or "wayfinding".
        each: episodes of each difficulty.
        drawn: seed of the episodes.
        palette: of the world. The network that explores is trained with every hue, so that those
            of a shifted palette are not new to it.
    """
    name = exploration_world(seed, signs, palette)
    scene = scene_of(name)
    rng = np.random.default_rng([drawn, seed])
    episodes = draw_episodes(name, scene, dict.fromkeys(DIFFICULTIES, each), rng)
    return World((drawn, seed), {name: scene}, episodes)


def run_agent(
    world: World,
    name: str,
    sensor: str,
    *,
    own: str = "",
    geometry: bool = False,
    noise: bool = True,
    stops_itself: bool = False,
    body: str = ROUND,
) -> dict[str, Array]:
    """Run an agent on all episodes of a world, in lock-step.

    The noise of motion and odometry comes from the same seeds for every agent.

    Args:
        world: its episodes.
        name: of the agent, see `common.explorers`.
        sensor: "rgbd" or "rgb".
        own: FILE.py:CLASS of an explorer of the user's, which runs instead.
        geometry: the true geometry stands in for the network.
        noise: of motion and odometry.
        stops_itself: see `ExplorationTask`.
        body: of the robots, one of `BODIES`.

    Returns:
        Columns (N,) of the episodes: "success", "spl", "steps", "travelled", "collisions", and
        "difficulty" as index in `DIFFICULTIES`; of cars also "turned".
    """
    task = (CarTask if body == CAR else ExplorationTask)(
        world.scenes,
        world.episodes,
        np.random.default_rng([*world.seed, 1]),
        sensor=sensor,
        noise=noise,
        stops_itself=stops_itself,
    )
    rng = np.random.default_rng([*world.seed, 2])
    explorer = (
        own_explorer(own) if own else make_explorer(name, task, sensor, rng, geometry=geometry)
    )
    explore(task, explorer)
    columns = _columns(task)
    return columns | {"turned": task.turned.astype(float)} if isinstance(task, CarTask) else columns


def _columns(task: ExplorationTask) -> dict[str, Array]:
    """How the episodes of a task went, see `run_agent`."""
    names = list(DIFFICULTIES)
    return {
        "difficulty": np.array([names.index(one) for one in task.episodes.difficulty], float),
        "success": task.success.astype(float),
        "spl": task.spl,
        "steps": task.steps.astype(float),
        "travelled": task.travelled,
        "collisions": task.collisions.astype(float),
    }


def measures(found: dict[str, Array], worlds: Array) -> dict[str, Any]:
    """Columns of a table: success and SPL with intervals over worlds, and success in time.

    Args:
        found: columns (N,) of episodes, see `run_agent`.
        worlds: (N,) the world of each.
    """
    row: dict[str, Any] = {"episodes": len(worlds)}
    for name in ("success", "spl"):
        values = _interval(found[name], worlds)
        row |= dict(zip((name, f"{name}_low", f"{name}_high"), values, strict=True))
    for steps in AT_STEPS:
        row[f"success_{steps}"] = float((found["success"] * (found["steps"] <= steps)).mean())
    row["steps"] = float(found["steps"].mean())
    row["collisions"] = float(found["collisions"].mean())
    return row


def _interval(values: Array, worlds: Array) -> tuple[float | None, ...]:
    """Mean and interval over worlds; within one world there is one only for shares."""
    if len(np.unique(worlds)) > 1 or np.isin(values, (0.0, 1.0)).all():
        return over_worlds(values, worlds)
    return float(values.mean()), None, None


def in_all_worlds(
    run_world: Callable[..., dict[Key, Any]],
    options: Options,
    settings: object,
    label: str,
) -> dict[Key, Any]:
    """Run agents in every world, with and without signs, and join what they did.

    Args:
        run_world: is given a world's seed and signs, `options` and `settings`; returns columns (N,)
            of episodes by a key in which the signs stand.
        options: with the worlds.
        settings: of the experiment.
        label: of the progress bar.

    Returns:
        The columns of all worlds by the same keys, and the "world" of each episode; or how the
        user's own agent failed in one.
    """
    items = [(world, signs) for signs in SIGNS for world in options.worlds]
    found = for_each(run_world, items, options, settings, label=label)
    results: dict[Key, Any] = {}
    for key in dict.fromkeys(key for part in found for key in part):
        mine = [part[key] for part in found if key in part]
        faults = [one for one in mine if isinstance(one, Fault)]
        if faults:
            results[key] = faults[0]
            continue
        sizes = [len(part["success"]) for part in mine]
        columns = {name: np.concatenate([part[name] for part in mine]) for name in mine[0]}
        results[key] = columns | {"world": np.repeat(options.worlds, sizes)}
    return results
