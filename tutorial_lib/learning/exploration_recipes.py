"""How the networks of exploration are trained: their worlds, sizes and settings."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import torch

from tutorial_lib.learning.calibration import (
    Calibration,
    auc,
    fit_temperature,
    reliability,
    sigmoid,
)
from tutorial_lib.learning.exploration_data import (
    PANORAMAS,
    panorama_worlds,
    training_plan,
    unseen_plan,
)
from tutorial_lib.learning.exploration_losses import PanoramaObjective, predictions
from tutorial_lib.learning.panorama_batches import PanoramaBatch, PanoramaSource
from tutorial_lib.learning.panorama_network import PanoramaArchitecture, PanoramaNetwork
from tutorial_lib.learning.recipes import BaseRecipe
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.weights import Card

FIRST_STOPPING, FIRST_CALIBRATING = 10_000, 10_016
"""First seeds of the validation worlds for early stopping, and for calibration."""


@dataclass(frozen=True)
class NtsRecipe(BaseRecipe):
    """All that a multi-task network comes from; as many plans as for stopping are for calibration.

    Attributes:
        panoramas: of each plan.
        masked: whether scores are learnt from unconnected pairs only, as in the paper.
    """

    worlds: int = 160
    panoramas: int = PANORAMAS
    masked: bool = False


STEPS = 6_500


def _recipe(sensor: str, kind: str) -> NtsRecipe:
    name = "_".join(filter(None, ("nts", kind, sensor)))
    settings = Settings(
        max_steps=STEPS,
        targets=16,
        learning_rate=2e-3,
        warmup_steps=300,
        eval_interval=500,
        patience=STEPS,
        threads=1,
    )
    command = f"train nts --sensor {sensor}" + (f" --{kind}" if kind else "")
    architecture = PanoramaArchitecture(sensor, goal_blind=kind == "blind")
    return NtsRecipe(name, command, architecture, settings, masked=kind == "masked")


KINDS = {
    "blind": "scores without the goal",
    "masked": "scores learn from unconnected pairs only, as in the paper",
}
"""Of multi-task networks, beside the one whose scores see the goal and learn from all pairs."""
NTS = {(sensor, kind): _recipe(sensor, kind) for sensor in ("rgb", "rgbd") for kind in ("", *KINDS)}
"""What `train nts` can train, by sensor and kind."""


def train_nts(recipe: NtsRecipe, work: Path, jobs: int = 2) -> tuple[PanoramaNetwork, Card]:
    """Train a multi-task network, including its data.

    Recordings and checkpoints are kept in `work`, from which an interrupted run resumes.

    Args:
        recipe: what to train.
        work: folder for recordings and checkpoint.
        jobs: processes that record and render.

    Returns:
        The network and its card, which holds the calibration of its connections.
    """
    begun = time.monotonic()
    plans = [training_plan(seed) for seed in range(recipe.worlds)]
    recorded = panorama_worlds(plans, work, recipe.panoramas, jobs)
    source = PanoramaSource(recorded, masked=recipe.masked)
    stopping = _unseen(recipe, FIRST_STOPPING, work, jobs)
    said, objective = {"worlds": recipe.worlds, **source.recipe}, PanoramaObjective()
    network, card = recipe.train(source, stopping, work, begun, said, objective)
    begun = time.monotonic()
    calibrating = _unseen(recipe, FIRST_CALIBRATING, work, jobs)
    calibration, measured = calibrate_connection(network, calibrating)
    return network, replace(
        card,
        validation={**card.validation, **measured},
        calibration=asdict(calibration),
        minutes=round(card.minutes + (time.monotonic() - begun) / 60, 1),
    )


def _unseen(recipe: NtsRecipe, first: int, work: Path, jobs: int) -> list[PanoramaBatch]:
    """Batches of validation worlds, both kinds of signs, nothing augmented."""
    plans = [unseen_plan(first + i) for i in range(recipe.validation_worlds)]
    worlds = panorama_worlds(plans, work, recipe.panoramas, jobs)
    count = 2 * len(worlds)
    source = PanoramaSource(worlds, worlds=count, targets=8, vary=False, masked=recipe.masked)
    return [source.block([first, number]) for number in range(2)]


@torch.inference_mode()
def calibrate_connection(
    network: PanoramaNetwork, batches: Sequence[PanoramaBatch]
) -> tuple[Calibration, dict[str, float]]:
    """Fit temperature and offset of F_L's logits on validation worlds (Guo et al. 2017).

    Returns:
        The calibration, and what was measured on the same pairs.
    """
    logits, label = [], []
    for batch in batches:
        found = predictions(network, batch)
        logits.append(found.compared.connection.numpy().astype(float))
        label.append(batch.connected.ravel()[found.pairs.numpy()])
    logits, label = np.concatenate(logits), np.concatenate(label)
    temperature, offset = fit_temperature(logits, label)
    raw = (-10.0, 10.0)
    calibration = Calibration(raw, tuple(round(z / temperature + offset, 6) for z in raw))
    measured = {
        "calibration_auc": auc(logits, label),
        "temperature": temperature,
        "offset": offset,
        "ece_raw": reliability(sigmoid(logits), label).ece,
        "ece_temperature": reliability(calibration(logits), label).ece,
    }
    return calibration, {name: round(value, 4) for name, value in measured.items()}
