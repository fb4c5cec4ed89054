"""A policy that learns by reinforcement ("target-driven RL", Chaplot et al. 2020, 5.1).

It reads what the multi-task network makes of the goal and of what is seen, direction by direction;
with a map, a direction has the cells of the map as well ("metric map + RL").
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.learning.panorama_encoder import CircularConvolution
from tutorial_lib.learning.panorama_network import HIDDEN, PANORAMA, PanoramaNetwork
from tutorial_lib.learning.reinforcement_views import MAPPED, PolicyViews
from tutorial_lib.learning.views import check_camera
from tutorial_lib.observation import Observation
from tutorial_lib.validation import flags, instance
from tutorial_lib.world.noise import STOP

THOUGHT = 128
"""Numbers from which an action is chosen, and the value is estimated in training."""
_NARROW, _OF_MAP = 32, 24


@dataclass(frozen=True)
class ReinforcementArchitecture:
    """All that is needed to build a policy; it is stored on the card beside its weights.

    Attributes:
        maps: whether it sees a map as well.
        sensor: "rgbd".
        kind: of the network, "reinforcement".
    """

    maps: bool
    sensor: str = "rgbd"
    kind: str = "reinforcement"

    def __post_init__(self) -> None:
        good = isinstance(self.maps, bool) and self.kind == "reinforcement"
        if not good or self.sensor != "rgbd":
            raise InputError(
                f"network: maps {self.maps!r}, sensor {self.sensor!r} of a {self.kind!r} network; "
                "give a reinforcement network true or false, and rgbd"
            )


class Trunk(nn.Module):
    """From the parts of `PolicyViews` (N, K) to numbers (N, THOUGHT)."""

    def __init__(self, architecture: ReinforcementArchitecture) -> None:
        super().__init__()
        self.of_map = nn.Linear(MAPPED, _OF_MAP) if architecture.maps else None
        inputs = HIDDEN + (_OF_MAP if architecture.maps else 0)
        self.narrow = CircularConvolution(inputs, _NARROW, 3)
        self.think = nn.Linear(DIRECTIONS * _NARROW + HIDDEN + len(ACTIONS), THOUGHT)

    def forward(self, parts: dict[str, Tensor]) -> Tensor:
        """What is thought (N, THOUGHT) of the parts."""
        directions = parts["directions"].unflatten(1, (DIRECTIONS, HIDDEN))
        if self.of_map is not None:
            mapped = self.of_map(parts["map"].unflatten(1, (DIRECTIONS, MAPPED))).relu()
            directions = torch.cat([directions, mapped], dim=-1)
        narrow = self.narrow(directions).relu().flatten(1)
        return self.think(torch.cat([narrow, parts["whole"], parts["before"]], dim=1)).relu()


class ReinforcementNetwork(nn.Module):
    """From the parts of `PolicyViews` to the logits of the next action."""

    def __init__(self, architecture: ReinforcementArchitecture) -> None:
        super().__init__()
        self.architecture = architecture
        self.trunk = Trunk(architecture)
        self.choose = nn.Linear(THOUGHT, len(ACTIONS))

    def forward(self, parts: dict[str, Tensor]) -> Tensor:
        """Logits (N, 4) of actions."""
        return self.choose(self.trunk(parts))


class LearnedReinforcement:
    """Draws actions with the probabilities that it learnt, an `ExplorerAgent`."""

    def __init__(
        self, network: ReinforcementNetwork, pairs: PanoramaNetwork, rng: np.random.Generator
    ) -> None:
        """Act by a trained policy.

        Args:
            network: the policy.
            pairs: the multi-task network that it was trained with.
            rng: draws the actions.
        """
        self._network, self._pairs, self._rng = network.eval(), pairs.eval(), rng

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        depth, maps = _depth(goals), self._network.architecture.maps
        self._views = PolicyViews(len(goals), self._pairs, maps=maps)
        self._views.begin(np.arange(len(goals)), goals.image, depth)

    @torch.inference_mode()
    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,) of all robots; those not `running` (N,) stop.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        depth = _depth(observations)
        going = np.flatnonzero(flags("running", running, (len(observations),)))
        drawn, actions = self._rng.random(len(observations)), np.full(len(observations), STOP)
        if len(going):
            image, odometry = observations.image[going], observations.odometry[going]
            seen = self._views.see(going, image, depth[going], odometry)
            logits = self._network({name: torch.from_numpy(part) for name, part in seen.items()})
            chances = logits.softmax(dim=1).numpy().cumsum(axis=1)
            actions[going] = (drawn[going, None] * chances[:, -1:] >= chances).sum(axis=1)
        self._views.acted(actions)
        return actions


def _depth(seen: Observation) -> NDArray[np.floating]:
    """The depth of panoramas that fit."""
    instance("observations", seen, Observation)
    check_camera("the policy that learnt by reinforcement", seen, PANORAMA)
    if seen.depth is None:
        raise InputError("the policy that learnt by reinforcement: give the robot a depth camera")
    return seen.depth
