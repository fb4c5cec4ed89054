"""What a network is punished for (Meng 2020, III-B, and the weights of its authors' code)."""

from torch import Tensor
from torch.nn import functional

from tutorial_lib.learning.batches import Batch

ROUNDED = 0.1
"""Metres below which an error counts as its square, and not as itself."""
TOLERANCE = 0.15
"""Metres of error that cost 1 where the target is; 1 m away from it, twice as many do."""
OVERLAP_WEIGHT = 0.3
"""Of the two overlaps, which reachability learns besides."""
CONTEXT_WEIGHT = {"waypoint": 2.0, "action": 2.0, "reachability": 2.0}
"""By a network's outputs, of where the context's pictures were taken: many labels for each pair,
which teach matching. Reachability is asked about places that C was never trained with."""


def position_loss(predicted: Tensor, wanted: Tensor) -> Tensor:
    """What an error costs, (...), for positions (..., 2): less where it is far to go.

    The authors divide the squared error by the distance. That draws doubtful waypoints to zero,
    where the car stops; the distance itself, rounded off near zero, settles for the median.
    """
    error = ((predicted - wanted) ** 2).sum(-1)
    return ((error + ROUNDED**2).sqrt() - ROUNDED) / (TOLERANCE * (1.0 + wanted.norm(dim=-1)))


def waypoint_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) waypoint, heading difference and overlaps, 1 : 1 : 1."""
    waypoint, turn, overlap = outputs.split([2, 2, 2], dim=1)
    position = position_loss(waypoint, batch.tensor("waypoint"))
    heading = ((turn - batch.tensor("turn")) ** 2).sum(1)
    shares = functional.binary_cross_entropy_with_logits(
        overlap, batch.tensor("overlap"), reduction="none"
    ).sum(1)
    return position + heading + shares


def action_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) squared error of speed and steering, each as a share of its range."""
    scale = outputs.new_tensor([0.5, 0.3])
    return (((outputs - batch.tensor("action")) / scale) ** 2).sum(1)


def outcome_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) binary cross-entropy of reachability (Meng 2020, III-C)."""
    return functional.binary_cross_entropy_with_logits(
        outputs[:, 0], batch.tensor("reached"), reduction="none"
    )


def reach_loss(outputs: Tensor, batch: Batch) -> Tensor:
    """(N,) of reachability and, less so, of the overlaps.

    The paper's RE tells one probability. What is seen of a target decides on it more than anything
    else, and every pair teaches that, not only those about which an outcome tells something.
    """
    shares = functional.binary_cross_entropy_with_logits(
        outputs[:, 1:], batch.tensor("overlap"), reduction="none"
    )
    return outcome_loss(outputs, batch) + OVERLAP_WEIGHT * shares.sum(1)


def context_loss(poses: Tensor, batch: Batch) -> Tensor:
    """(N,) where the pictures of the context were taken, on average."""
    wanted = batch.tensor("context_poses")
    position = position_loss(poses[..., :2], wanted[..., :2])
    heading = ((poses[..., 2:] - wanted[..., 2:]) ** 2).sum(-1)
    return (position + heading).mean(1)


LOSSES = {"waypoint": waypoint_loss, "action": action_loss, "reachability": reach_loss}
"""By a network's outputs, what it learns from."""
JUDGED_BY = {**LOSSES, "reachability": outcome_loss}
"""By a network's outputs, what tells the best look at the validation worlds."""
