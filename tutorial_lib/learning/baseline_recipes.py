"""What the recipes of the trained baselines of exploration have in common."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from torch import nn

from tutorial_lib.learning.batches import Blocks
from tutorial_lib.learning.imitation_data import EPISODES
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.training import Objective, train
from tutorial_lib.learning.weights import Card, load_card


@dataclass(frozen=True)
class BaselineRecipe:
    """All that a network comes from that learns from the expert's episodes.

    Attributes:
        name: of the weights.
        command: that trains them.
        architecture: of the network.
        settings: of its training; its "targets" are what a batch of its data counts.
        start: weights of the multi-task network that it starts from or reads; none if empty.
        worlds: how many training plans, seeds 0 and up.
        validation_worlds: how many plans for early stopping.
        episodes: of each plan, by difficulty.
    """

    name: str
    command: str
    architecture: Any
    settings: Settings
    start: str = ""
    worlds: int = 160
    validation_worlds: int = 8
    episodes: dict[str, int] = field(default_factory=lambda: dict(EPISODES))

    def checkpoints(self, work: Path) -> tuple[Path]:
        """File of the state of its training."""
        return (work / f"{self.name}.pt",)


def train_baseline(
    recipe: BaselineRecipe,
    source: Blocks,
    validation: Sequence[Any],
    work: Path,
    begun: float,
    objective: Objective,
    init_from: nn.Module | None = None,
) -> tuple[Any, Card]:
    """Train on data that are ready.

    Args:
        recipe: what to train.
        source: of its batches.
        validation: batches of worlds that it is not trained on.
        work: folder for the checkpoint.
        begun: when the data were begun, by `time.monotonic`.
        objective: see `train`.
        init_from: see `train`.

    Returns:
        The network and its card.
    """
    prepared = time.monotonic() - begun
    network, progress = train(
        recipe.architecture,
        source,
        validation,
        recipe.settings,
        recipe.checkpoints(work)[0],
        init_from=init_from,
        objective=objective,
    )
    card = Card(
        recipe.name,
        recipe.command,
        recipe.architecture,
        recipe={
            **asdict(recipe.settings),
            "start": load_card(recipe.start).sha256 if recipe.start else "",
            "worlds": recipe.worlds,
            **source.recipe,
        },
        validation=progress.history[progress.best],
        minutes=round((prepared + progress.seconds) / 60, 1),
    )
    return network, card
