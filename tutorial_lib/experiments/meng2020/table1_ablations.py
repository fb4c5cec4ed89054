"""Ablations of local control at k = 2: how pictures are compared, worlds, rows of pixels."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import difference, in_points, over_worlds
from tutorial_lib.experiments.protocols.local_control import attempt, clean_condition, worlds_of
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.learning.recipes import WORK, Recipe, record_for, train_local
from tutorial_lib.learning.training import Settings
from tutorial_lib.parallel import for_each
from tutorial_lib.world.simulation import Sensors

STEPS = 4_000
"""Of every variant: about four minutes."""
_QUICK_STEPS = 400
_COMMAND = "experiment meng_table1 --ablation"


def _variants(ablation: str, **architectures: tuple[Architecture, int]) -> dict[str, Recipe]:
    settings = Settings(max_steps=STEPS)
    return {
        name: Recipe(f"ablation_{name}", f"{_COMMAND} {ablation}", architecture, settings, worlds)
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


def run(options: Options) -> Report:
    """Train every variant of `options.ablation` and drive the clean episodes of Table I with it."""
    begun = time.perf_counter()
    worlds, count = worlds_of(options)
    recipes = ABLATIONS[options.ablation]
    variants = list(recipes.values())
    if options.quick:
        variants = [_quickly(recipe) for recipe in variants]
    record_for(max(variants, key=lambda recipe: recipe.worlds), WORK)
    trained = for_each(_train, variants, label="training", jobs=2)
    predictors = [network for network, _ in trained]
    parts = for_each(_race, worlds, predictors, count, options.seed, label="ablation")
    where = np.repeat(np.arange(len(worlds)), count)
    outcomes = [np.concatenate(found) for found in zip(*parts, strict=True)]
    rows: list[dict[str, Any]] = []
    for variant, (predictor, card), reached in zip(recipes, trained, outcomes, strict=True):
        success, low, high = over_worlds(reached, where)
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
    notes = [
        f"{first[0]} - {other}: " + in_points(difference(first[1], reached, where))
        for other, reached in others
    ]
    took = time.perf_counter() - begun
    name = f"ablation_{options.ablation}"
    return Report(name, options.seed, worlds, options.quick, took, rows, tuple(notes))


def _quickly(recipe: Recipe) -> Recipe:
    """The same with few steps, to see that it works."""
    settings = replace(recipe.settings, max_steps=_QUICK_STEPS, eval_interval=_QUICK_STEPS)
    return replace(recipe, name=f"{recipe.name}_quick", settings=settings)


def _train(recipe: Recipe) -> tuple[WaypointNetwork, Any]:
    network, card = train_local(recipe, WORK)
    return WaypointNetwork(network), card


def _race(world: int, predictors: list[WaypointNetwork], count: int, seed: int) -> list[Array]:
    """Whether each variant reached each target of one world."""
    course = clean_condition(world, count, seed)
    return [
        attempt(course, by_waypoints(p), Sensors(camera=p.view.camera))["reached"]
        for p in predictors
    ]
