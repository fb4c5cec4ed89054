"""What the recipes of the trained baselines of exploration have in common."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tutorial_lib.learning.batches import Blocks
from tutorial_lib.learning.imitation_data import EPISODES
from tutorial_lib.learning.settings import Progress, Settings
from tutorial_lib.learning.weights import Card


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


def baseline_card(
    recipe: BaselineRecipe, source: Blocks, progress: Progress, prepared: float, start: str
) -> Card:
    """The card of a trained network.

    Args:
        recipe: that it was trained by.
        source: of its batches.
        progress: of its training.
        prepared: seconds that its data took.
        start: checksum of the weights that it starts from or reads.
    """
    return Card(
        recipe.name,
        recipe.command,
        recipe.architecture,
        recipe={
            **asdict(recipe.settings),
            "start": start,
            "worlds": recipe.worlds,
            **source.recipe,
        },
        validation=progress.history[progress.best],
        minutes=round((prepared + progress.seconds) / 60, 1),
    )
