"""From when on a goal counts as on the map, with one image of it or with a clip.

A goal is one image (Meng 2020, III-F). The images of the last 1.5 s of a drive to it, a clip, are
what RE is trained on, but nobody who says where to go has them. A threshold that suits clips
refuses single images; a low one accepts goals that are not on the map, here those of another
building. The best one for single images is `DijkstraPlanner.p_goal`.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.drives import driven_trials, part_of
from tutorial_lib.experiments.protocols.navigation import (
    GOAL_IMAGES,
    K,
    experiences,
    goals_of,
    navigate,
    refusals,
)
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, draw_trials, make_building
from tutorial_lib.geometry import Array
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.world.simulation import Simulation

WORLDS = tuple(range(10_000, 10_006))
"""For validation: the threshold is chosen here."""
_ELSEWHERE = 500  # from a world to that of its strange goals

Key = tuple[str, float]
"""Goal images, and threshold."""
InWorld = tuple[dict[Key, dict[str, Array]], NDArray[np.bool_]]
"""Of one world columns (N,) of the trials for every threshold, and (N,) which a learned drive
covers."""


@dataclass(frozen=True)
class Settings:
    """Settings of the ablation.

    Attributes:
        places: of a building.
        trials: in each building.
        p_goal: thresholds, in ascending order.
    """

    places: int = PLACES
    trials: int = 40
    p_goal: tuple[float, ...] = (0.5, 0.8, 0.9, 0.95, 0.97, 0.985)


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Table II's trials with every threshold, and first plans to goals of another building."""
    parts = for_each(run_world, options.worlds, options, settings, label="goal images")
    return [_row(key, parts) for key in parts[0][0]], []


def run_world(world: int, options: Options, settings: Settings) -> InWorld:
    """All thresholds in one world, on the same map and the same trials."""
    whole = make_building(world, options.seed, settings.places, drifts=options.drifts)
    trials = draw_trials(whole, settings.trials, np.random.default_rng([options.seed, world, 1]))
    elsewhere = make_building(world + _ELSEWHERE, options.seed, settings.places)
    rng = np.random.default_rng([options.seed, world, 3])
    strange = draw_trials(elsewhere, settings.trials, rng)
    building = part_of(whole, options.drives, options.seed)
    agent = agents.meng()
    agent.learn(list(experiences(building)))
    seen, found = Simulation(building.scene, trials.starts).observe(), {}
    for images in GOAL_IMAGES:
        goals = goals_of(trials, VIEWS["camera16"], K, images)
        for least in settings.p_goal:
            chosen = replace(agent, planner=DijkstraPlanner(p_goal=least))
            chosen.topomap = agent.topomap
            outcome = navigate(building, trials, lambda _, a=chosen, g=goals: a.start(g))
            found[images, least] = {
                "success": outcome.success,
                "wrong_place": outcome.wrong,
                "refused": refusals(chosen, seen, trials, images)["refused"],
                "refused_strange": refusals(chosen, seen, strange, images)["refused"],
            }
    return found, driven_trials(whole, trials, options.drives, options.seed)


def _row(key: Key, parts: list[InWorld]) -> dict[str, Any]:
    images, least = key
    world = np.repeat(np.arange(len(parts)), [len(driven) for _, driven in parts])
    columns = {
        name: np.concatenate([found[key][name] for found, _ in parts]).astype(float)
        for name in parts[0][0][key]
    }
    success = columns.pop("success")
    share, low, high = over_worlds(success, world)
    row: dict[str, Any] = {"goal_images": images, "p_goal": least, "trials": len(world)}
    row |= {"success": share, "low": low, "high": high}
    row |= {name: float(values.mean()) for name, values in columns.items()}
    composed = success[~np.concatenate([driven for _, driven in parts])]
    found = float(composed.mean()) if len(composed) else None
    return row | {"trials_composed": len(composed), "success_composed": found}


EXPERIMENT = Experiment(
    "meng_table2_goal_images",
    run,
    WORLDS,
    WORLDS[:2],
    settings=Settings(),
    quick_settings=Settings(trials=10, p_goal=(0.5, 0.9, 0.985)),
    canary=Settings(places=5, trials=4, p_goal=(0.5, 0.95)),
    accepts=frozenset({"odometry", "drives"}),
)
