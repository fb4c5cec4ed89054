"""A learned global goal on a metric map, after Active Neural SLAM (Chaplot et al. 2020, ICLR).

How it differs from the original. There, a policy trained by reinforcement learning (PPO, ten
million frames) looks at the map alone and puts its goal anywhere on it, and its reward is the area
explored; in the image-goal task of NTS it was adapted by the authors. Here the choice is among the
map's frontiers, the network is trained with supervision on geodesic distances that only simulation
knows, and it also sees what the multi-task network has of the present panorama and the goal. The
first makes it less general; the others make it a stronger baseline than a reward for area would.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.exploration.frontier import CROP
from tutorial_lib.exploration.labels import MAX_DISTANCE
from tutorial_lib.exploration.local_map import RESOLUTION
from tutorial_lib.learning.batches import Rows
from tutorial_lib.learning.exploration_losses import SPREAD, listwise_loss, score_loss
from tutorial_lib.learning.panorama_encoder import SENSORS
from tutorial_lib.learning.panorama_network import HIDDEN

FRONTIERS = 16
"""Of a map, the nearest ones; farther ones are not learnt from."""
_CHANNELS = (16, 24, 32)
_LIST_WEIGHT = 0.5
_WITHIN = 0.5  # metres by which a choice that counts as right may be longer


@dataclass(frozen=True, eq=False)
class GoalMaps(Rows):
    """N half-explored maps.

    Attributes:
        crops: (N, CROP, CROP) uint8, see `interfaces.FrontierScorer`.
        frontiers: (N, FRONTIERS, 3) x and y in the robot's frame, and metres to go.
        remaining: (N, FRONTIERS) metres from a frontier to the goal; infinite for none.
        pairs: (N, 12, HIDDEN) what the multi-task network has of each direction and the goal.
    """

    crops: NDArray[np.uint8]
    frontiers: NDArray[np.float32]
    remaining: NDArray[np.float32]
    pairs: NDArray[np.float16]


@dataclass(frozen=True)
class GoalMapSource:
    """Blocks of maps for `training.train`: any of all worlds.

    Attributes:
        recorded: the maps.
        worlds: 1, since maps of all worlds are drawn together.
        targets: of a block.
    """

    recorded: GoalMaps
    worlds: int = 1
    targets: int = 512

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        return {"maps": len(self.recorded), "block": [self.worlds, self.targets]}

    def block(self, seed: Sequence[int]) -> GoalMaps:
        """The block of that seed."""
        rng = np.random.default_rng(seed)
        return self.recorded.targets(rng.integers(len(self.recorded), size=self.targets))


@dataclass(frozen=True)
class GoalMapArchitecture:
    """All that is needed to build a network; it is stored on the card beside its weights.

    Attributes:
        sensor: of the multi-task network that it goes with.
        kind: of the network, "goal_map".
    """

    sensor: str
    kind: str = "goal_map"

    def __post_init__(self) -> None:
        if self.sensor not in SENSORS or self.kind != "goal_map":
            raise InputError(
                f"network: sensor {self.sensor!r} of a {self.kind!r} network; give a goal_map "
                f"network one of {', '.join(SENSORS)}"
            )


class GoalMapNetwork(nn.Module):
    """From a map, its frontiers and what is seen to the score of each frontier."""

    def __init__(self, architecture: GoalMapArchitecture) -> None:
        super().__init__()
        self.architecture = architecture
        sizes = (3, *_CHANNELS)
        self.layers = nn.ModuleList(
            nn.Conv2d(before, after, 3, stride=2, padding=1) for before, after in pairwise(sizes)
        )
        inputs = sum(_CHANNELS) + _CHANNELS[-1] + 2 * HIDDEN + 4
        self.judge = nn.Sequential(
            nn.Linear(inputs, 96), nn.ReLU(), nn.Linear(96, 64), nn.ReLU(), nn.Linear(64, 1)
        )

    def forward(self, crops: Tensor, frontiers: Tensor, pairs: Tensor) -> Tensor:
        """Scores (N, F) ``max(1 - d / 20 m, 0)`` of frontiers for the d that remain from there.

        Args:
            crops: (N, CROP, CROP) uint8.
            frontiers: (N, F, 3) x and y in the robot's frame, and metres to go.
            pairs: (N, 12, HIDDEN) of the multi-task network.
        """
        x = functional.one_hot(crops.long(), 3).movedim(-1, 1).float()
        at = (frontiers[..., :2] / (0.5 * CROP * RESOLUTION))[:, None]  # x runs along columns
        local = []
        for layer in self.layers:
            x = layer(x).relu()
            sampled = functional.grid_sample(x, at, padding_mode="border", align_corners=False)
            local.append(sampled[:, :, 0].transpose(1, 2))
        count = frontiers.shape[1]
        overall = x.mean((2, 3))[:, None].expand(-1, count, -1)
        bearing = torch.atan2(frontiers[..., 1], frontiers[..., 0])
        number = (bearing * DIRECTIONS / (2 * torch.pi)).round().long() % DIRECTIONS
        ahead = pairs.gather(1, number[..., None].expand(-1, -1, pairs.shape[-1]))
        around = pairs.mean(1, keepdim=True).expand_as(ahead)
        distance = frontiers[..., :2].norm(dim=-1, keepdim=True)
        place = [frontiers[..., 2:] / 5.0, distance / 5.0, bearing.cos()[..., None]]
        place.append((distance < 3.0).float())  # within the node, where panoramas say most
        known = torch.cat([*local, overall, ahead, around, *place], dim=-1)
        return self.judge(known)[..., 0].sigmoid()


class GoalMapObjective:
    """Squared error of scores and order of total paths; an objective for `training.train`."""

    def loss(self, network: GoalMapNetwork, batch: GoalMaps) -> Tensor:
        """Training loss of a batch."""
        scores, remaining, total = _predicted(network, batch)
        order = listwise_loss(_totals(scores, batch) / -SPREAD, total)
        return score_loss(scores, remaining) + _LIST_WEIGHT * order

    @torch.inference_mode()
    def measure(self, network: GoalMapNetwork, validation: Sequence[GoalMaps]) -> dict[str, float]:
        """Mean loss, and how often the choice is within 0.5 m of the best total path.

        Beside it stands `nearest`, the same of the frontier that is reached soonest.
        """
        losses, right, nearest = [], [], []
        for batch in validation:
            scores, _, total = _predicted(network, batch)
            losses.append(self.loss(network, batch).item())
            wrong = ~total.isfinite()
            choice = _totals(scores, batch).masked_fill(wrong, torch.inf).argmin(1, keepdim=True)
            near = batch.tensor("frontiers")[..., 2].masked_fill(wrong, torch.inf)
            most = total.amin(1, keepdim=True) + _WITHIN
            right.append(total.gather(1, choice) <= most)
            nearest.append(total.gather(1, near.argmin(1, keepdim=True)) <= most)
        return {
            "validation": sum(losses) / len(losses),
            "top1": round(torch.cat(right).float().mean().item(), 4),
            "nearest": round(torch.cat(nearest).float().mean().item(), 4),
        }


def _predicted(network: GoalMapNetwork, batch: GoalMaps) -> tuple[Tensor, Tensor, Tensor]:
    """Scores, and metres that remain and in total, each (N, F); infinite where no frontier is."""
    frontiers, remaining = batch.tensor("frontiers"), batch.tensor("remaining")
    scores = network(batch.tensor("crops"), frontiers, batch.tensor("pairs"))
    return scores, remaining, frontiers[..., 2] + remaining


def _totals(scores: Tensor, batch: GoalMaps) -> Tensor:
    """Metres (N, F) of the path by each frontier to the goal, as the scores have it."""
    return batch.tensor("frontiers")[..., 2] + MAX_DISTANCE * (1.0 - scores)
