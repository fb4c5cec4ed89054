"""Training losses (Meng 2020, III-B, with the weights of its authors' code; LTVN's)."""

from torch import Tensor
from torch.nn import functional

from tutorial_lib.learning.batches import Batch
from tutorial_lib.learning.tensors import tensor
from tutorial_lib.validation import instance

ROUNDED = 0.1
"""Metres below which the loss is quadratic in the error, and above which it is linear."""
TOLERANCE = 0.15
"""Metres of error that cost 1 at the target; 1 m away from it, twice as many do."""
OVERLAP_WEIGHT = 0.3
"""Of the two overlaps, an auxiliary output of reachability."""
POSE_WEIGHT = 0.5
"""Of the target's pose in LTVN's model."""
CONTEXT_WEIGHT = {"waypoint": 2.0, "action": 2.0, "reachability": 2.0, "relative": 2.0}
"""By a network's outputs, of the poses of the context's images: many labels for each pair, which
teach matching. RE is queried about pairs that C was never trained with."""


def position_loss(predicted: Tensor, wanted: Tensor) -> Tensor:
    """Loss (...) of positions (..., 2): an error costs less where the target is far.

    The authors divide the squared error by the distance. That draws uncertain waypoints to zero,
    where the car stops; a pseudo-Huber loss settles for the median.
    """
    tensor("predicted", predicted, (..., 2))
    tensor("wanted", wanted, tuple(predicted.shape))
    error = ((predicted - wanted) ** 2).sum(-1)
    return ((error + ROUNDED**2).sqrt() - ROUNDED) / (TOLERANCE * (1.0 + wanted.norm(dim=-1)))


def waypoint_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) waypoint, heading difference and overlaps, 1 : 1 : 1."""
    _check(outputs, batch, 6)
    waypoint, turn, overlap = outputs.split([2, 2, 2], dim=1)
    position = position_loss(waypoint, batch.tensor("waypoint"))
    heading = ((turn - batch.tensor("turn")) ** 2).sum(1)
    shares = functional.binary_cross_entropy_with_logits(
        overlap, batch.tensor("overlap"), reduction="none"
    ).sum(1)
    return position + heading + shares


def action_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) squared error of speed and steering, each as a share of its range."""
    _check(outputs, batch, 2)
    scale = outputs.new_tensor([0.5, 0.3])
    return (((outputs - batch.tensor("action")) / scale) ** 2).sum(1)


def outcome_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) binary cross-entropy of reachability (Meng 2020, III-C)."""
    _check(outputs, batch, 3)
    return functional.binary_cross_entropy_with_logits(
        outputs[:, 0], batch.tensor("reached"), reduction="none"
    )


def reach_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) of reachability and, with a smaller weight, of the overlaps.

    The paper's RE predicts one probability. It depends on the overlaps more than on anything else,
    and every pair teaches these, also where its outcome carries little information.
    """
    _check(outputs, batch, 3)
    shares = functional.binary_cross_entropy_with_logits(
        outputs[:, 1:], batch.tensor("overlap"), reduction="none"
    )
    return outcome_loss(outputs, batch) + OVERLAP_WEIGHT * shares.sum(1)


def relative_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) of LTVN's model: reachability, and the target's pose where it is reachable."""
    _check(outputs, batch, 5)
    label = batch.tensor("reached")
    reachable = functional.binary_cross_entropy_with_logits(outputs[:, 0], label, reduction="none")
    place = position_loss(outputs[:, 1:3], batch.tensor("waypoint"))
    heading = ((outputs[:, 3:] - batch.tensor("turn")) ** 2).sum(1)
    return reachable + label * POSE_WEIGHT * (place + heading)


def context_loss(poses: Tensor, batch: Batch) -> Tensor:
    """(N,) mean loss of the relative poses of the context's images."""
    wanted = instance("batch", batch, Batch).tensor("context_poses")
    tensor("poses", poses, tuple(wanted.shape))
    position = position_loss(poses[..., :2], wanted[..., :2])
    heading = ((poses[..., 2:] - wanted[..., 2:]) ** 2).sum(-1)
    return (position + heading).mean(1)


def _check(outputs: Tensor, batch: Batch, count: int) -> None:
    tensor("outputs", outputs, (len(instance("batch", batch, Batch).reached), count))


LOSSES = {
    "waypoint": waypoint_loss,
    "action": action_loss,
    "reachability": reach_loss,
    "relative": relative_loss,
}
"""By a network's outputs, the loss that it is trained with."""
EVALUATION_LOSSES = {**LOSSES, "reachability": outcome_loss}
"""By a network's outputs, the loss that selects the best evaluation."""
