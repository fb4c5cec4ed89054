"""Ablations of local control at k = 2: how images are compared, worlds, rows of pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.local_control import WORLDS, attempt, clean_condition
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.learning.recipes import WORK, Recipe, record_for, train_local
from tutorial_lib.learning.training import Settings as TrainingSettings
from tutorial_lib.parallel import for_each
from tutorial_lib.world.simulation import Sensors

_COMMAND = "experiment meng_table1 --ablation"


@dataclass(frozen=True)
class Settings:
    """Settings of the ablations.

    Attributes:
        episodes: in each world.
        max_steps: of training each variant: about four minutes.
    """

    episodes: int = 100
    max_steps: int = 4_000


QUICK = Settings(episodes=40, max_steps=400)


def _variants(ablation: str, **architectures: tuple[Architecture, int]) -> dict[str, Recipe]:
    settings = TrainingSettings(max_steps=Settings.max_steps)
    return {
        name: Recipe(
            f"ablation_{name}",
            f"{_COMMAND} {ablation}",
            architecture,
            settings,
            worlds=worlds,
        )
        for name, (architecture, worlds) in architectures.items()
    }


ABLATIONS = {
    "encoder": _variants(
        "encoder",
        matching=(Architecture(2), 96),
        pair=(Architecture(2, "pair"), 96),
        separate=(Architecture(2, "separate"), 96),
        stacked=(Architecture(2, "stacked"), 96),
    ),
    "worlds": _variants(
        "worlds",
        worlds4=(Architecture(2), 4),
        worlds12=(Architecture(2), 12),
        worlds48=(Architecture(2), 48),
    ),
    "rows": _variants(
        "rows",
        matching=(Architecture(2), 96),
        rows64=(Architecture(2, view="camera64"), 96),
    ),
}


def run(
    recipes: dict[str, Recipe], options: Options, settings: Settings
) -> tuple[Rows, list[Finding]]:
    """Train every variant and run the clean episodes of Table I with it."""
    worlds, count = options.worlds, settings.episodes
    variants = list(recipes.values())
    if options.quick:
        variants = [_shortened(recipe, settings.max_steps) for recipe in variants]
    record_for(max(variants, key=lambda recipe: recipe.worlds), WORK)
    trained = for_each(_train, variants, label="training", jobs=2)
    predictors = [network for network, _ in trained]
    parts = for_each(run_world, worlds, predictors, count, options, label="ablation")
    world = np.repeat(np.arange(len(worlds)), count)
    outcomes = [np.concatenate(found) for found in zip(*parts, strict=True)]
    rows: Rows = []
    for variant, (predictor, card), reached in zip(recipes, trained, outcomes, strict=True):
        success, low, high = over_worlds(reached, world)
        weights = predictor.network.parameters()
        rows.append(
            {
                "variant": variant,
                "parameters": sum(weight.numel() for weight in weights),
                "worlds": recipes[variant].worlds,
                "minutes": card.minutes,
                "median_m": card.validation["median"],
                "mean_m": card.validation["mean"],
                "episodes": len(reached),
                "success": success,
                "low": low,
                "high": high,
            }
        )
    first, *others = zip(recipes, outcomes, strict=True)
    return rows, [
        Finding(f"{first[0]} - {other}", *difference(first[1], reached, world))
        for other, reached in others
    ]


def _shortened(recipe: Recipe, steps: int) -> Recipe:
    """The same recipe with few steps, to see that it runs."""
    settings = replace(recipe.settings, max_steps=steps, eval_interval=steps)
    return replace(recipe, name=f"{recipe.name}_quick", settings=settings)


def _train(recipe: Recipe) -> tuple[WaypointNetwork, Any]:
    network, card = train_local(recipe, WORK)
    return WaypointNetwork(network), card


def run_world(
    world: int, predictors: list[WaypointNetwork], count: int, options: Options
) -> list[Array]:
    """Whether each variant reached each target of one world."""
    condition = clean_condition(world, count, options)
    return [
        attempt(condition, by_waypoints(p), Sensors(camera=p.view.camera))["reached"]
        for p in predictors
    ]


EXPERIMENTS = {
    name: Experiment(
        f"ablation_{name}", partial(run, recipes), WORLDS, WORLDS[:10], Settings(), QUICK
    )
    for name, recipes in ABLATIONS.items()
}
