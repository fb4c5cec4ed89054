"""Losses of the multi-task network (Chaplot et al. 2020, 4.2).

Cross-entropy for labels, squared errors times ten for scores, as in the paper. Beyond it: a loss on
the order of the directions, since the global policy takes the best; auxiliary labels; depth.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS
from tutorial_lib.exploration.labels import MAX_DISTANCE
from tutorial_lib.learning.panorama_batches import PanoramaBatch
from tutorial_lib.learning.panorama_network import Compared, Seen
from tutorial_lib.learning.tensors import tensor

SCORE_WEIGHT = 10.0
"""Of squared errors of scores, as in the paper."""
SPREAD = 0.5
"""Metres by which directions differ in the listwise loss: softmax(-d / 0.5 m)."""
KIND_WEIGHT, ROOM_WEIGHT, OFFSET_WEIGHT, LIST_WEIGHT, DEPTH_WEIGHT = 0.1, 0.2, 0.3, 0.5, 0.5
"""Of the kind of room at a direction's end, of whether it is the goal's, of the bearing within a
direction, of the order of the directions, and of depth."""
POSITION_WEIGHT = 0.3
"""Of the metres by which matched columns are wrong about the goal's place: it teaches matching."""


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
