"""How networks for reachability are trained: outcomes, hard negatives, calibration."""

from __future__ import annotations

import os
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from tutorial_lib.driving.data.rollout_outcomes import load_outcomes
from tutorial_lib.learning.calibration import (
    Calibration,
    auc,
    fit_isotonic,
    fit_temperature,
    reliability,
    sigmoid,
)
from tutorial_lib.learning.estimators import ReachabilityNetwork
from tutorial_lib.learning.mining import all_logits, mined_outcomes
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.outcome_data import recipe_of, record_outcomes
from tutorial_lib.learning.reach_batches import (
    LabelledWorld,
    OutcomeSource,
    ProximitySource,
    TimeSource,
)
from tutorial_lib.learning.recipes import Recipe, recorded_worlds_of, seen_with
from tutorial_lib.learning.training import Settings, train
from tutorial_lib.learning.views import named_for
from tutorial_lib.learning.weights import Card, load_card, load_network
from tutorial_lib.world.worlds import training_world, validation_world

FIRST_WORLD, WORLDS = 120, 80
"""Training worlds in which C was not trained: in its own it may do better than elsewhere."""
STOPPING = range(10_000, 10_012)
"""Validation worlds for early stopping."""
CALIBRATING = range(10_012, 10_036)
"""Validation worlds on which RE is calibrated."""
VALIDATION_TARGETS = 80
CARS = 16


@dataclass(frozen=True)
class ReachRecipe:
    """All that a network for reachability comes from.

    Attributes:
        name: of the weights.
        command: that trains them.
        controller: weights of the C_WP whose rollouts it learns from, and whose encoder
            initializes it.
        targets: of the pairs in each world, with five starts each.
        architecture: of the network.
        first: settings of the training on pairs drawn at random.
        second: settings of the training that also has mined pairs.
    """

    name: str
    command: str
    controller: str
    targets: int
    architecture: Architecture
    first: Settings
    second: Settings

    def checkpoints(self, work: Path) -> tuple[Path, Path]:
        """Files of the states of both its trainings."""
        return work / f"{self.name}_first.pt", work / f"{self.name}_second.pt"

    def with_degrees(self, degrees: int) -> ReachRecipe:
        """The recipe of the same network for a camera of so many degrees, see `seen_with`."""
        controller = named_for(self.controller, degrees)
        return replace(self, controller=controller, **seen_with(self, degrees))


def _recipe(
    which: str, controller: str, targets: int, steps: tuple[int, int], architecture: Architecture
) -> ReachRecipe:
    name = f"reach_{which if which == 'laser' else 'k' + which}"
    first = Settings(max_steps=steps[0], patience=steps[0])
    second = Settings(max_steps=steps[1], learning_rate=7e-4, seed=1, patience=steps[1])
    architecture = replace(architecture, outputs="reachability")
    command = f"train reachability --k {which}"
    return ReachRecipe(name, command, controller, targets, architecture, first, second)


REACHABILITY = {
    "0": _recipe("0", "waypoint_k0", 300, (22_000, 8_000), Architecture(0)),
    "2": _recipe("2", "waypoint_k2", 300, (22_000, 8_000), Architecture(2)),
    "5": _recipe("5", "waypoint_k5", 300, (14_000, 6_000), Architecture(5)),
    "laser": _recipe("laser", "laser_k2", 300, (22_000, 8_000), Architecture(2, view="laser")),
}
"""What `train reachability --k` can train, besides SPTM's."""
SPTM = Recipe(
    "sptm",
    "train reachability --k sptm",
    Architecture(0, outputs="reachability"),
    Settings(max_steps=12_000),
    worlds=WORLDS,
)
"""SPTM's network: temporal proximity of two images, trained from scratch on the same data."""
VING = Recipe(
    "ving",
    "train reachability --k ving",
    Architecture(0, view="rgbd16", outputs="relative"),
    Settings(max_steps=12_000),
    worlds=WORLDS,
)
"""ViNG's: how soon a drive comes from one image to another, and where that is."""
OF_TIME = {"sptm": SPTM, "ving": VING}
"""The networks that learn from the times of images alone."""


def train_reachability(recipe: ReachRecipe, work: Path, jobs: int = 2) -> tuple[LocalNetwork, Card]:
    """Train RE for one controller, including its rollouts and hard negatives.

    Recordings and checkpoints are kept in `work`, from which an interrupted run resumes.

    Args:
        recipe: what to train.
        work: folder for demonstrations, outcomes and checkpoints.
        jobs: processes that record.

    Returns:
        The network and its card, which holds its calibration.
    """
    begun = time.monotonic()
    training = labelled_worlds(
        recipe, [training_world(FIRST_WORLD + i) for i in range(WORLDS)], work, jobs
    )
    stopping = labelled_worlds(recipe, [validation_world(seed) for seed in STOPPING], work, jobs)
    source = OutcomeSource(training, recipe.architecture)
    others = replace(source, labelled=stopping, vary=False, targets=48)
    validation = [others.block([0, i]) for i in range(2)]
    spent = time.monotonic() - begun
    stages = []
    network = load_network(recipe.controller)
    for stage, settings in enumerate((recipe.first, recipe.second)):
        checkpoint = recipe.checkpoints(work)[stage]
        network, progress = train(
            recipe.architecture, source, validation, settings, checkpoint, init_from=network
        )
        stages.append(progress)
        if stage == 0:
            begun = time.monotonic()
            source = replace(source, labelled=with_mined(training, network, recipe, work, jobs))
            spent += time.monotonic() - begun
    begun = time.monotonic()
    calibrating = labelled_worlds(
        recipe, [validation_world(seed) for seed in CALIBRATING], work, jobs
    )
    calibration, measured = calibrate(ReachabilityNetwork(network), calibrating)
    spent += time.monotonic() - begun
    minutes = round((spent + sum(progress.seconds for progress in stages)) / 60, 1)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    card = Card(
        recipe.name,
        recipe.command,
        recipe.architecture,
        recipe={
            "first": asdict(recipe.first),
            "second": asdict(recipe.second),
            "controller": load_card(recipe.controller).sha256,
            **source.recipe,
        },
        validation={**stages[-1].history[stages[-1].best], **measured},
        calibration=asdict(calibration),
        minutes=minutes,
        cores=cores or 1,
    )
    return network, card


def labelled_worlds(
    recipe: ReachRecipe, worlds: list[str], work: Path, jobs: int
) -> list[LabelledWorld]:
    """Pairs in `worlds` and their outcomes, recorded where they are missing."""
    targets = recipe.targets if worlds[0] == training_world(FIRST_WORLD) else VALIDATION_TARGETS
    files = record_outcomes(worlds, recipe.controller, targets, CARS, work, jobs)
    known = recipe_of(recipe.controller, targets, CARS)
    recorded_worlds = recorded_worlds_of(worlds, CARS, work)
    return [
        LabelledWorld(recorded, load_outcomes(file, known))
        for recorded, file in zip(recorded_worlds, files, strict=True)
    ]


def with_mined(
    worlds: list[LabelledWorld], network: LocalNetwork, recipe: ReachRecipe, work: Path, jobs: int
) -> list[LabelledWorld]:
    """The worlds with hard negatives of the network."""
    recorded = [world.recorded for world in worlds]
    mined = mined_outcomes(
        ReachabilityNetwork(network), recipe.controller, recorded, work, jobs=jobs
    )
    return [replace(world, mined=m) for world, m in zip(worlds, mined, strict=True)]


def calibrate(
    network: ReachabilityNetwork, worlds: list[LabelledWorld]
) -> tuple[Calibration, dict[str, float]]:
    """Fit a calibration on validation worlds, and measure the calibration error there.

    The error that remains is measured on the same pairs; `experiment calibration` has others. Only
    pairs whose views overlap are used: at the same score, others fail more often, and a map never
    queries them unless they look like these.
    """
    logits, label = [], []
    for world in worlds:
        pairs = world.outcomes.pairs
        seen = np.flatnonzero(pairs.seen)
        starts, targets = pairs.starts[seen], pairs.targets[seen]
        logits.append(all_logits(network, world.recorded, starts, targets))
        label.append(world.outcomes.reached[seen])
    logits, label = np.concatenate(logits), np.concatenate(label)
    temperature, offset = fit_temperature(logits, label)
    isotonic = fit_isotonic(logits, label)
    methods = {
        "raw": sigmoid(logits),
        "temperature": sigmoid(logits / temperature + offset),
        "isotonic": isotonic(logits),
    }
    measured = {"auc": auc(logits, label), "temperature": temperature, "offset": offset}
    for method, probability in methods.items():
        measured[f"ece_{method}"] = reliability(probability, label).ece
    return isotonic, {name: round(value, 4) for name, value in measured.items()}


def train_proximity(recipe: Recipe, work: Path) -> tuple[LocalNetwork, Card]:
    """Train SPTM's network, or ViNG's, from scratch on the same trajectories."""
    recorded_worlds = recorded_worlds_of(
        [training_world(FIRST_WORLD + i) for i in range(recipe.worlds)], recipe.cars, work
    )
    made = TimeSource if recipe.architecture.outputs == "relative" else ProximitySource
    source = made(recorded_worlds, recipe.architecture)
    stopping = recorded_worlds_of([validation_world(seed) for seed in STOPPING], recipe.cars, work)
    others = replace(source, recorded_worlds=stopping, targets=48)
    validation = [others.block([0, i]) for i in range(2)]
    network, card = recipe.train(source, validation, work, time.monotonic(), source.recipe)
    return network, replace(card, calibration=asdict(Calibration()))
