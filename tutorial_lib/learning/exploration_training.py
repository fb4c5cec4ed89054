"""What the multi-task network is trained for, and what is measured of it on validation worlds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.learning.calibration import auc
from tutorial_lib.learning.exploration_losses import depth_loss, pair_losses, seen_losses
from tutorial_lib.learning.panorama_batches import PanoramaBatch
from tutorial_lib.learning.panorama_network import (
    Compared,
    PanoramaArchitecture,
    PanoramaNetwork,
    Seen,
)
from tutorial_lib.world.generators import SIGNS

WITHIN = 0.5
"""Metres by which a direction that counts as right may be longer than the best."""


class PanoramaObjective:
    """All heads at once, see `exploration_losses`; an objective for `training.train`."""

    def build(self, architecture: PanoramaArchitecture) -> PanoramaNetwork:
        """An untrained network."""
        return PanoramaNetwork(architecture)

    def loss(self, network: PanoramaNetwork, batch: PanoramaBatch) -> Tensor:
        """Training loss of a batch, the sum of all heads' losses."""
        return _total(predictions(network, batch), batch)

    @torch.inference_mode()
    def measure(
        self, network: PanoramaNetwork, validation: Sequence[PanoramaBatch]
    ) -> dict[str, float]:
        """Mean loss, and how good each head is: see `_quality`."""
        losses, rows = [], []
        for batch in validation:
            found = predictions(network, batch)
            losses.append(_total(found, batch).item())
            rows.append(_quality(found, batch))
        together = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
        return {"validation": float(np.mean(losses)), **_summary(together)}


class Predictions:
    """What a network predicts of a batch: of its panoramas, of its pairs, and their depth.

    Attributes:
        seen: of G * P panoramas.
        compared: of N pairs.
        pairs: (N,) index of each among all pairs of the batch.
        log_ranges: (G * P, 192), or None for a sensor that has depth.
    """

    def __init__(
        self, seen: Seen, compared: Compared, pairs: Tensor, log_ranges: Tensor | None
    ) -> None:
        self.seen, self.compared, self.pairs = seen, compared, pairs
        self.log_ranges = log_ranges


def predictions(network: PanoramaNetwork, batch: PanoramaBatch) -> Predictions:
    """Encode each panorama once, and compare all pairs that are to be learnt from."""
    images, depth = batch.tensor("images").flatten(0, 1), batch.tensor("depth").flatten(0, 1)
    columns = network.columns(images, depth)
    encoded = network.encoder.encode(columns, depth)
    pairs, sources, goals = batch.pairs()
    compared = network.compare(encoded.rows(sources), encoded.rows(goals))
    has_depth = network.architecture.sensor == "rgbd"
    log_ranges = None if has_depth else network.encoder.log_ranges(columns)
    return Predictions(network.seen(encoded), compared, pairs, log_ranges)


def _total(found: Predictions, batch: PanoramaBatch) -> Tensor:
    losses = [
        *seen_losses(found.seen, batch).values(),
        *pair_losses(found.compared, batch, found.pairs).values(),
    ]
    if found.log_ranges is not None:
        losses.append(depth_loss(found.log_ranges, batch.tensor("depth").flatten(0, 1)))
    return torch.stack(losses).sum()


def _quality(found: Predictions, batch: PanoramaBatch) -> dict[str, np.ndarray]:
    """Predictions and labels of a batch side by side, for `_summary`."""
    pairs = found.pairs.numpy()
    label = {
        name: getattr(batch, name).reshape(-1, *getattr(batch, name).shape[3:])[pairs]
        for name in ("connected", "direction", "nearness", "metres", "far")
    }
    compared = found.compared
    inside = label["connected"] > 0
    difference = np.abs(compared.direction.numpy()[inside].argmax(1) - label["direction"][inside])
    error = RADIUS * np.abs(compared.nearness.numpy() - label["nearness"])[inside]
    depth = np.zeros(0)
    if found.log_ranges is not None:
        depth = np.abs(found.log_ranges.numpy() - np.log(batch.depth.reshape(-1, 192))).ravel()
    return {
        "explorable": found.seen.explorable.numpy().ravel() > 0,
        "is_explorable": batch.explorable.ravel() > 0,
        "connection": compared.connection.numpy(),
        "connected": label["connected"],
        "bins": np.minimum(difference, DIRECTIONS - difference),
        "distance": error,
        "right": best_chosen(compared.scores.numpy(), label["metres"]),
        "far": label["far"],
        "signs": np.broadcast_to(batch.signs[:, None, None], batch.far.shape).ravel()[pairs],
        "depth": depth,
    }


def best_chosen(scores: np.ndarray, metres: np.ndarray) -> np.ndarray:
    """(N,) whether the highest score is within 0.5 m of the best; NaN where there is no choice.

    Args:
        scores: (N, 12) of directions.
        metres: (N, 12) from each direction's end to the goal, infinite for none.
    """
    possible = np.isfinite(metres)
    chosen = np.where(possible, scores, -np.inf).argmax(1)
    metres = metres.astype(float)
    right = metres[np.arange(len(metres)), chosen] <= metres.min(1) + WITHIN
    return np.where(possible.sum(1) > 1, right, np.nan)


def _summary(rows: dict[str, np.ndarray]) -> dict[str, float]:
    """The measures on a network's card."""
    hit, is_hit = rows["explorable"], rows["is_explorable"]
    measured = {
        "explorable_f1": 2 * (hit & is_hit).sum() / max(hit.sum() + is_hit.sum(), 1),
        "connection_auc": auc(rows["connection"], rows["connected"]),
        "bin_exact": (rows["bins"] == 0).mean(),
        "bin_within_1": (rows["bins"] <= 1).mean(),
        "distance_error": rows["distance"].mean(),
    }
    if len(rows["depth"]):
        measured["depth_error"] = rows["depth"].mean()
    for signs in SIGNS:
        for name, (least, most) in DIFFICULTIES.items():
            mine = (rows["far"] >= least) & (rows["far"] < most) & np.isfinite(rows["right"])
            mine &= rows["signs"] == (signs == "wayfinding")
            measured[f"top1_{name}_{signs}"] = rows["right"][mine].mean() if mine.any() else 0.0
    return {name: round(float(value), 4) for name, value in measured.items()}
