"""How the learned global goal is trained that frontier exploration can take (`ans_like`)."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, field
from pathlib import Path

from tutorial_lib.learning.exploration_data import training_plan, unseen_plan
from tutorial_lib.learning.exploration_recipes import FIRST_STOPPING
from tutorial_lib.learning.goal_map_batches import GoalMapSource
from tutorial_lib.learning.goal_map_data import goal_maps
from tutorial_lib.learning.goal_map_network import (
    GoalMapArchitecture,
    GoalMapNetwork,
    GoalMapObjective,
)
from tutorial_lib.learning.imitation_data import EPISODES
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.training import train
from tutorial_lib.learning.weights import Card, load_card, load_network


@dataclass(frozen=True)
class GoalMapRecipe:
    """All that a learned global goal comes from.

    Attributes:
        name: of the weights.
        command: that trains them.
        architecture: of the network.
        settings: of its training; its "targets" are maps.
        start: weights of the multi-task network whose features it reads.
        worlds: how many training plans, seeds 0 and up.
        validation_worlds: how many plans for early stopping.
        episodes: of each plan, by difficulty, on whose paths maps are made.
    """

    name: str
    command: str
    architecture: GoalMapArchitecture
    settings: Settings
    start: str
    worlds: int = 120
    validation_worlds: int = 8
    episodes: dict[str, int] = field(default_factory=lambda: dict(EPISODES))

    def checkpoints(self, work: Path) -> tuple[Path]:
        """File of the state of its training."""
        return (work / f"{self.name}.pt",)


STEPS = 8_000


def _recipe(sensor: str) -> GoalMapRecipe:
    settings = Settings(
        max_steps=STEPS,
        targets=32,
        learning_rate=1e-3,
        warmup_steps=200,
        eval_interval=500,
        patience=STEPS,
    )
    command, architecture = f"train ans_like --sensor {sensor}", GoalMapArchitecture(sensor)
    return GoalMapRecipe(f"ans_like_{sensor}", command, architecture, settings, f"nts_{sensor}")


GOAL_MAPS = {sensor: _recipe(sensor) for sensor in ("rgb", "rgbd")}
"""What `train ans_like` can train, by sensor."""


def train_goal_map(recipe: GoalMapRecipe, work: Path, jobs: int = 2) -> tuple[GoalMapNetwork, Card]:
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
    card = Card(
        recipe.name,
        recipe.command,
        recipe.architecture,
        recipe={
            **asdict(recipe.settings),
            "start": load_card(recipe.start).sha256,
            "worlds": recipe.worlds,
            **source.recipe,
        },
        validation=progress.history[progress.best],
        minutes=round((prepared + progress.seconds) / 60, 1),
    )
    return network, card
