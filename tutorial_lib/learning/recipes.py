"""How each shipped network is trained: its worlds, its sizes, its settings."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from torch import nn

from tutorial_lib.driving.control.oracle import PARKING
from tutorial_lib.driving.data.demonstrations import record_demonstrations
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import load_trajectories
from tutorial_lib.errors import InputError
from tutorial_lib.learning.batches import Blocks, Source
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.training import LOCAL, Objective, Settings, train
from tutorial_lib.learning.views import DEGREES, CameraView, named_for
from tutorial_lib.learning.weights import Card, load_card, load_network
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import scene_of, training_world, validation_world

WORK = Path(".training")
"""Folder of demonstrations and checkpoints."""
SEED = 0
"""Of the demonstrations."""
FIRST_VALIDATION_WORLD = 10_000


@dataclass(frozen=True)
class BaseRecipe:
    """What the recipes have in common of networks that are trained once.

    Attributes:
        name: of the weights.
        command: that trains them.
        architecture: of the network.
        settings: of its training; its "targets" are what a batch of its data counts.
        start: name of the weights that it starts from, or reads; none if empty.
        worlds: how many training worlds; seeds 0 and up, unless its training says otherwise.
        validation_worlds: how many for early stopping, seeds 10,000 and up.
    """

    name: str
    command: str
    architecture: Any
    settings: Settings = field(default_factory=Settings)
    start: str = ""
    worlds: int = 120
    validation_worlds: int = 12

    def checkpoints(self, work: Path) -> tuple[Path]:
        """File of the state of its training."""
        return (work / f"{self.name}.pt",)

    def train(
        self,
        source: Blocks,
        validation: Sequence[Any],
        work: Path,
        begun: float,
        said: dict[str, Any],
        objective: Objective = LOCAL,
        init_from: nn.Module | None = None,
    ) -> tuple[Any, Card]:
        """Train on data that are ready.

        Args:
            source: of its batches.
            validation: batches of worlds that it is not trained on.
            work: folder for the checkpoint.
            begun: when the data were begun, by `time.monotonic`.
            said: what the card says of its data, after the settings.
            objective: see `train`.
            init_from: see `train`.

        Returns:
            The network and its card.
        """
        prepared = time.monotonic() - begun
        network, progress = train(
            self.architecture,
            source,
            validation,
            self.settings,
            self.checkpoints(work)[0],
            init_from=init_from,
            objective=objective,
        )
        card = Card(
            self.name,
            self.command,
            self.architecture,
            recipe={**asdict(self.settings), **said},
            validation=progress.history[progress.best],
            minutes=round((prepared + progress.seconds) / 60, 1),
        )
        return network, card


@dataclass(frozen=True)
class Recipe(BaseRecipe):
    """All that a network of local control comes from.

    Attributes:
        cars: that drive in each world for demonstrations.
    """

    cars: int = 16

    def with_degrees(self, degrees: int) -> "Recipe":
        """The recipe of the same network for a camera of so many degrees, see `seen_with`."""
        return replace(self, start=named_for(self.start, degrees), **seen_with(self, degrees))


def seen_with(recipe: Any, degrees: int) -> dict[str, Any]:  # noqa: ANN401 - any recipe
    """What a recipe says otherwise for a camera of so many degrees: name, command, architecture.

    Raises:
        InputError: where the network looks at no camera, or a camera cannot have so many degrees.
    """
    view = recipe.architecture.looks_at
    if not isinstance(view, CameraView):
        raise InputError(
            f"degrees: {recipe.name} looks at the {view.name}, not at a camera; leave it out"
        )
    view = replace(view, degrees=degrees)
    return {
        "name": named_for(recipe.name, degrees),
        "command": recipe.command + (f" --degrees {degrees}" if degrees != DEGREES else ""),
        "architecture": replace(recipe.architecture, view=view.name),
    }


def _recipe(
    which: str, name: str, architecture: Architecture, steps: int, start: str = ""
) -> Recipe:
    rate = 1e-3 if start else 2e-3
    # Most is learnt while the learning rate decays: nothing ends before.
    settings = Settings(max_steps=steps, learning_rate=rate, patience=steps)
    return Recipe(name, f"train waypoint --k {which}", architecture, settings, start)


BASE = "waypoint_k2"
"""Trained from scratch; the camera's other networks start from its encoder."""
WAYPOINT = {
    "0": _recipe("0", "waypoint_k0", Architecture(0), 16_000, BASE),
    "2": _recipe("2", BASE, Architecture(2), 36_000),
    "5": _recipe("5", "waypoint_k5", Architecture(5), 24_000, BASE),
    "direct": _recipe("direct", "direct_k2", Architecture(2, outputs="action"), 16_000, BASE),
    "laser": _recipe("laser", "laser_k2", Architecture(2, view="laser"), 30_000),
}
"""What `train waypoint --k` can train."""


def train_local(recipe: Recipe, work: Path) -> tuple[LocalNetwork, Card]:
    """Train a network of local control, including its demonstrations.

    Recordings and checkpoints are kept in `work`, from which an interrupted run resumes.

    Args:
        recipe: what to train.
        work: folder for demonstrations and checkpoint.

    Returns:
        The network and its card.
    """
    begun = time.monotonic()
    training, unseen = worlds_of(recipe)
    imitated = PARKING if recipe.architecture.outputs == "action" else None
    source = Source(recorded_worlds_of(training, recipe.cars, work), recipe.architecture, imitated)
    others = replace(
        source,
        recorded_worlds=recorded_worlds_of(unseen, recipe.cars, work),
        perturbation=PAPER_PERTURBATION,
        close=0.0,
        clutter=0.0,
        vary=False,
    )
    validation = [replace(others, targets=32, starts=2).block([SEED, i]) for i in range(2)]
    said = {
        "start": load_card(recipe.start).sha256 if recipe.start else "",
        "worlds": recipe.worlds,
        "cars": recipe.cars,
    }
    start = load_network(recipe.start) if recipe.start else None
    return recipe.train(source, validation, work, begun, said, init_from=start)


def worlds_of(recipe: Recipe) -> tuple[list[str], list[str]]:
    """Names of the training worlds, and of the validation worlds for early stopping."""
    first = FIRST_VALIDATION_WORLD
    training = [training_world(seed) for seed in range(recipe.worlds)]
    return training, [validation_world(first + i) for i in range(recipe.validation_worlds)]


def recorded_worlds_of(worlds: Sequence[str], cars: int, work: Path) -> list[RecordedWorld]:
    """Demonstrations in `worlds`, recorded where they are missing."""
    paths = record_demonstrations(worlds, cars, SEED, work / "demonstrations")
    scenes = for_each(scene_of, worlds, label="scenes", jobs=2)
    recorded = [load_trajectories(path) for path in paths]
    return [
        RecordedWorld(scene, found) for scene, found in zip(scenes, recorded, strict=True) if found
    ]
