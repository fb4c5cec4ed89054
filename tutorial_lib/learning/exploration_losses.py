"""Losses of the multi-task network (Chaplot et al. 2020, 4.2), and what is measured of it.

Cross-entropy for labels, squared errors times ten for scores, as in the paper. Beyond it: a loss on
the order of the directions, since the global policy takes the best; auxiliary labels; depth.
"""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.exploration.labels import MAX_DISTANCE
from tutorial_lib.learning.calibration import auc
from tutorial_lib.learning.panorama_batches import PanoramaBatch
from tutorial_lib.learning.panorama_network import Compared, PanoramaNetwork, Seen
from tutorial_lib.learning.tensors import tensor
from tutorial_lib.world.generators import SIGNS

SCORE_WEIGHT = 10.0
"""Of squared errors of scores, as in the paper."""
SPREAD = 0.5
"""Metres by which directions differ in the listwise loss: softmax(-d / 0.5 m)."""
KIND_WEIGHT, ROOM_WEIGHT, OFFSET_WEIGHT, LIST_WEIGHT, DEPTH_WEIGHT = 0.1, 0.2, 0.3, 0.5, 0.5
"""Of the kind of room at a direction's end, of whether it is the goal's, of the bearing within a
direction, of the order of the directions, and of depth."""
POSITION_WEIGHT = 0.3
"""Of the metres by which matched columns are wrong about the goal's place: it teaches matching."""
WITHIN = 0.5
"""Metres by which a direction that counts as right may be longer than the best."""


def seen_losses(seen: Seen, batch: PanoramaBatch) -> dict[str, Tensor]:
    """Mean losses of what is predicted of panoramas alone, by name."""
    explorable = functional.binary_cross_entropy_with_logits(
        seen.explorable, batch.tensor("explorable").flatten(0, 1)
    )
    kinds = functional.cross_entropy(seen.kinds.flatten(0, 1), batch.tensor("kinds").flatten())
    return {"explorable": explorable, "kinds": KIND_WEIGHT * kinds}


def pair_losses(compared: Compared, batch: PanoramaBatch, pairs: Tensor) -> dict[str, Tensor]:
    """Mean losses of what is predicted of pairs, by name.

    Args:
        compared: predictions for N pairs.
        batch: with the labels of all pairs of panoramas within each group.
        pairs: (N,) index of each pair among those, see `PanoramaBatch.pairs`.
    """
    label = {
        name: batch.tensor(name).flatten(0, 2)[pairs]
        for name in ("connected", "direction", "offset", "nearness", "metres", "same_room")
    }
    connection = functional.binary_cross_entropy_with_logits(
        compared.connection, label["connected"]
    )
    inside = label["connected"] > 0
    direction = label["direction"][inside]
    bearing = functional.cross_entropy(compared.direction[inside], direction, reduction="sum")
    offset = compared.offset[inside].gather(1, direction[:, None])[:, 0] - label["offset"][inside]
    near = (compared.nearness - label["nearness"])[inside]
    count = inside.sum().clamp(min=1)
    possible = label["metres"].isfinite()
    same = functional.binary_cross_entropy_with_logits(
        compared.same_room, label["same_room"], reduction="none"
    )
    return {
        "connection": connection,
        "direction": bearing / count,
        "offset": OFFSET_WEIGHT * offset.square().sum() / count,
        "position": POSITION_WEIGHT * _position(compared.position[inside], label, inside) / count,
        "nearness": SCORE_WEIGHT * near.square().sum() / count,
        "scores": score_loss(compared.scores, label["metres"]),
        "order": LIST_WEIGHT * listwise_loss(compared.sharp, label["metres"]),
        "same_room": ROOM_WEIGHT * _mean(same, possible),
    }


def score_loss(scores: Tensor, metres: Tensor) -> Tensor:
    """Ten times the mean squared error of semantic scores ``max(1 - d / 20 m, 0)``.

    Args:
        scores: (N, 12) predicted.
        metres: (N, 12) from each direction's end to the goal; infinite for a direction with none.
    """
    _check_rows(scores=scores, metres=metres)
    possible = metres.isfinite()
    wanted = (1.0 - torch.where(possible, metres, 0.0) / MAX_DISTANCE).clamp(min=0.0)
    return SCORE_WEIGHT * _mean((scores - wanted).square(), possible)


def listwise_loss(logits: Tensor, metres: Tensor) -> Tensor:
    """Kullback-Leibler divergence over directions from softmax(-d / 0.5 m), mean over pairs.

    Args:
        logits: (N, 12) predicted.
        metres: (N, 12), see `score_loss`; pairs with fewer than two directions do not count.
    """
    _check_rows(logits=logits, metres=metres)
    possible = metres.isfinite()
    choice = possible.sum(1) > 1
    possible, metres, logits = possible[choice], metres[choice], logits[choice]
    never = torch.finfo(logits.dtype).min
    wanted = (-metres / SPREAD).softmax(-1)  # infinitely far ones get nothing
    predicted = logits.masked_fill(~possible, never).log_softmax(-1)
    gap = torch.where(wanted > 0, wanted * (wanted.clamp(min=1e-12).log() - predicted), 0.0)
    return gap.sum() / choice.sum().clamp(min=1)


def depth_loss(log_ranges: Tensor, depth: Tensor) -> Tensor:
    """Mean absolute error of logarithms of depth; both (N, 192), in log metres and metres."""
    _check_rows(log_ranges=log_ranges, depth=depth)
    return DEPTH_WEIGHT * (log_ranges - depth.clamp(min=0.05).log()).abs().mean()


def _check_rows(**pair: Tensor) -> None:
    """Check that both are rows, as many and as long."""
    (first, rows), (second, others) = pair.items()
    tensor(first, rows, ("N", "K"))
    tensor(second, others, tuple(rows.shape))


def _position(position: Tensor, label: dict[str, Tensor], inside: Tensor) -> Tensor:
    """Summed metres between predicted places (M, 2) and those of the labels `inside` a node."""
    direction, offset, nearness = (
        label[name][inside] for name in ("direction", "offset", "nearness")
    )
    bearing = (direction + 0.5 * offset) * (2 * torch.pi / DIRECTIONS)
    wanted = torch.stack([bearing.cos(), bearing.sin()], dim=-1)
    wanted = RADIUS * (1.0 - nearness)[:, None] * wanted
    return ((position - wanted).square().sum(-1) + 0.01).sqrt().sum()


def _mean(values: Tensor, counted: Tensor) -> Tensor:
    """Mean of the values (N, 12) that are `counted`."""
    return torch.where(counted, values, 0.0).sum() / counted.sum().clamp(min=1)


class PanoramaObjective:
    """All heads at once; an objective for `training.train`."""

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
