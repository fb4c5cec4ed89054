"""A recurrent policy that imitates shortest paths ("ResNet + GRU + IL", Chaplot et al. 2020, 5.1).

It sees what the multi-task network sees: the same encoder and the same comparison with the goal,
direction by direction. A GRU remembers, and four logits choose the action.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.learning.imitation_data import ImitationBatch
from tutorial_lib.learning.panorama_encoder import SENSORS, Encoded
from tutorial_lib.learning.panorama_network import HIDDEN, PanoramaArchitecture, PanoramaNetwork

MEMORY = 96
"""Numbers that the GRU remembers."""
_NARROW = 64


@dataclass(frozen=True)
class ImitationArchitecture:
    """All that is needed to build a policy; it is stored on the card beside its weights.

    Attributes:
        sensor: "rgb" or "rgbd".
        kind: of the network, "imitation".
    """

    sensor: str
    kind: str = "imitation"

    def __post_init__(self) -> None:
        if self.sensor not in SENSORS or self.kind != "imitation":
            raise InputError(
                f"network: sensor {self.sensor!r} of a {self.kind!r} network; give an imitation "
                f"network one of {', '.join(SENSORS)}"
            )


class ImitationNetwork(nn.Module):
    """From panoramas, a goal and the actions before to the logits of the next action."""

    def __init__(self, architecture: ImitationArchitecture) -> None:
        super().__init__()
        self.architecture = architecture
        self.pairs = PanoramaNetwork(PanoramaArchitecture(architecture.sensor))
        self.narrow = nn.Linear(DIRECTIONS * HIDDEN, _NARROW)
        self.memory = nn.GRU(_NARROW + len(ACTIONS), MEMORY, batch_first=True)
        self.choose = nn.Linear(MEMORY + _NARROW, len(ACTIONS))

    def forward(
        self, seen: Encoded, goals: Encoded, previous: Tensor, memory: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        """Logits (N, T, 4) of the actions of N robots in T steps, and their memory (1, N, M).

        Args:
            seen: of N * T panoramas, the steps of one robot in a row.
            goals: as many, each robot's own T times.
            previous: (N, T) actions carried out before.
            memory: (1, N, M) of the steps before; nothing unless given.
        """
        hidden, _, _ = self.pairs.directions(seen, goals)
        narrow = self.narrow(hidden.flatten(1)).relu().unflatten(0, previous.shape)
        given = torch.cat([narrow, functional.one_hot(previous, len(ACTIONS)).float()], dim=-1)
        remembered, memory = self.memory(given, memory)
        return self.choose(torch.cat([remembered, narrow], dim=-1)), memory


class ImitationObjective:
    """Cross-entropy of the expert's actions; an objective for `training.train`."""

    def loss(self, network: ImitationNetwork, batch: ImitationBatch) -> Tensor:
        """Mean cross-entropy over the steps of a batch."""
        used = batch.tensor("used")
        return functional.cross_entropy(
            _logits(network, batch)[used], batch.tensor("actions")[used]
        )

    @torch.inference_mode()
    def measure(
        self, network: ImitationNetwork, validation: Sequence[ImitationBatch]
    ) -> dict[str, float]:
        """Mean cross-entropy and share of right actions, of all and of stops."""
        losses, right, stops = [], [], []
        for batch in validation:
            used = batch.tensor("used")
            logits, actions = _logits(network, batch)[used], batch.tensor("actions")[used]
            losses.append(functional.cross_entropy(logits, actions, reduction="none"))
            right.append(logits.argmax(1) == actions)
            stops.append(actions == 0)
        correct, is_stop = torch.cat(right).float(), torch.cat(stops)
        stopped = correct[is_stop].mean().item() if is_stop.any() else 0.0
        return {
            "validation": torch.cat(losses).mean().item(),
            "accuracy": round(correct.mean().item(), 4),
            "stops": round(stopped, 4),
        }


def _logits(network: ImitationNetwork, batch: ImitationBatch) -> Tensor:
    """Logits (G, T, 4) of a batch; each goal is encoded once."""
    images, depth = batch.tensor("images").flatten(0, 1), batch.tensor("depth").flatten(0, 1)
    seen = network.pairs.encode(images, depth)
    goals = network.pairs.encode(batch.tensor("goal_images"), batch.tensor("goal_depth"))
    count, steps = batch.actions.shape
    index = torch.arange(count).repeat_interleave(steps)
    return network(seen, goals.rows(index), batch.tensor("previous"))[0]
