"""How the learned global goal is trained that frontier exploration can take (`ans_like`)."""

from __future__ import annotations

import time
from pathlib import Path

from tutorial_lib.learning.baseline_recipes import BaselineRecipe, baseline_card
from tutorial_lib.learning.exploration_data import training_plan, unseen_plan
from tutorial_lib.learning.exploration_recipes import FIRST_STOPPING
from tutorial_lib.learning.goal_map_batches import GoalMapSource
from tutorial_lib.learning.goal_map_data import goal_maps
from tutorial_lib.learning.goal_map_network import (
    GoalMapArchitecture,
    GoalMapNetwork,
    GoalMapObjective,
)
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.training import train
from tutorial_lib.learning.weights import Card, load_card, load_network

STEPS = 8_000


def _recipe(sensor: str) -> BaselineRecipe:
    settings = Settings(
        max_steps=STEPS,
        targets=32,
        learning_rate=1e-3,
        warmup_steps=200,
        eval_interval=500,
        patience=STEPS,
    )
    command, architecture = f"train ans_like --sensor {sensor}", GoalMapArchitecture(sensor)
    return BaselineRecipe(
        f"ans_like_{sensor}", command, architecture, settings, f"nts_{sensor}", worlds=120
    )


GOAL_MAPS = {sensor: _recipe(sensor) for sensor in ("rgb", "rgbd")}
"""What `train ans_like` can train, by sensor."""


def train_goal_map(
    recipe: BaselineRecipe, work: Path, jobs: int = 2
) -> tuple[GoalMapNetwork, Card]:
    """Train a learned global goal, including its data.

    Recordings and checkpoints are kept in `work`, from which an interrupted run resumes.

    Args:
        recipe: what to train.
        work: folder for recordings and checkpoint.
        jobs: processes that record.

    Returns:
        The network and its card.
    """
    begun = time.monotonic()
    seeing = load_network(recipe.start, wanted=PanoramaNetwork)
    plans = [training_plan(seed) for seed in range(recipe.worlds)]
    source = GoalMapSource(goal_maps(plans, seeing, work, recipe.episodes, jobs))
    plans = [unseen_plan(FIRST_STOPPING + i) for i in range(recipe.validation_worlds)]
    unseen = GoalMapSource(goal_maps(plans, seeing, work, recipe.episodes, jobs))
    validation = [unseen.block([FIRST_STOPPING, i]) for i in range(3)]
    prepared = time.monotonic() - begun
    network, progress = train(
        recipe.architecture,
        source,
        validation,
        recipe.settings,
        recipe.checkpoints(work)[0],
        objective=GoalMapObjective(),
    )
    start = load_card(recipe.start).sha256
    return network, baseline_card(recipe, source, progress, prepared, start)
