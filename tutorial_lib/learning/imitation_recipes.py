"""How the recurrent policy is trained that imitates shortest paths."""

import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import torch

from tutorial_lib.learning.exploration_data import training_plan, unseen_plan
from tutorial_lib.learning.exploration_recipes import FIRST_STOPPING
from tutorial_lib.learning.imitation_data import EPISODES, ImitationSource, expert_episodes
from tutorial_lib.learning.imitation_network import (
    ImitationArchitecture,
    ImitationNetwork,
    ImitationObjective,
)
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.recipes import BaseRecipe
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.weights import Card, load_card, load_network

STEPS = 4_000


@dataclass(frozen=True)
class BaselineRecipe(BaseRecipe):
    """All that a network comes from that learns from the expert's episodes.

    Attributes:
        episodes: of each plan, by difficulty.
    """

    worlds: int = 160
    validation_worlds: int = 8
    episodes: dict[str, int] = field(default_factory=lambda: dict(EPISODES))


def _recipe(sensor: str) -> BaselineRecipe:
    # Its encoder starts from the multi-task network's: a stronger baseline than the paper's, whose
    # encoder knows only ImageNet.
    settings = Settings(
        max_steps=STEPS,
        targets=8,
        learning_rate=1e-3,
        warmup_steps=200,
        eval_interval=250,
        patience=STEPS,
    )
    command, architecture = f"train il --sensor {sensor}", ImitationArchitecture(sensor)
    return BaselineRecipe(f"il_{sensor}", command, architecture, settings, f"nts_{sensor}")


IMITATION = {sensor: _recipe(sensor) for sensor in ("rgb", "rgbd")}
"""What `train il` can train, by sensor."""


def train_imitation(
    recipe: BaselineRecipe, work: Path, jobs: int = 2
) -> tuple[ImitationNetwork, Card]:
    """Train a policy by behaviour cloning, including its data.

    Recordings and checkpoints are kept in `work`, from which an interrupted run resumes.

    Args:
        recipe: what to train.
        work: folder for recordings and checkpoint.
        jobs: processes that record.

    Returns:
        The network and its card.
    """
    begun = time.monotonic()
    started = _started(recipe)
    plans = [training_plan(seed) for seed in range(recipe.worlds)]
    source = ImitationSource(expert_episodes(plans, work, recipe.episodes, jobs))
    plans = [unseen_plan(FIRST_STOPPING + i) for i in range(recipe.validation_worlds)]
    unseen = expert_episodes(plans, work, recipe.episodes, jobs)
    others = replace(source, recorded=unseen, targets=2, vary=False)
    validation = [others.block([FIRST_STOPPING, i]) for i in range(2)]
    start = load_card(recipe.start).sha256
    said = {"start": start, "worlds": recipe.worlds, **source.recipe}
    return recipe.train(source, validation, work, begun, said, ImitationObjective(), started)


def _started(recipe: BaselineRecipe) -> ImitationNetwork:
    """A policy whose comparison with the goal has the weights of a multi-task network."""
    torch.manual_seed(recipe.settings.seed)
    network = ImitationNetwork(recipe.architecture)
    trained = load_network(recipe.start, wanted=PanoramaNetwork)
    network.pairs.load_state_dict(trained.state_dict())
    return network
