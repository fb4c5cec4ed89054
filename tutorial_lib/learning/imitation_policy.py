"""The trained recurrent policy behind `interfaces.RecurrentPolicy`."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from tutorial_lib.learning.imitation_network import MEMORY, ImitationNetwork
from tutorial_lib.learning.panorama_encoder import FEATURES, Encoded
from tutorial_lib.learning.weights import load_network
from tutorial_lib.observation import Observation
from tutorial_lib.world.noise import STOP

State = NDArray[np.float32]
"""(N, FEATURES + MEMORY + 1) features of the goal, memory, and the action before."""


class LearnedImitation:
    """Imitates shortest paths, a `RecurrentPolicy`.

    Attributes:
        network: that chooses actions.
    """

    def __init__(self, network: ImitationNetwork | str) -> None:
        """Put a trained policy, or shipped weights by their name, behind the interface."""
        if isinstance(network, str):
            network = load_network(network, wanted=ImitationNetwork)
        self.network = network.eval()

    @property
    def sensor(self) -> str:
        """What a robot must carry: "rgb", or "rgbd" for a depth camera as well."""
        return self.network.architecture.sensor

    @torch.inference_mode()
    def start(self, goals: Observation) -> State:
        """The state of N robots before their first step, a row each.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        features = self._encoded(goals).flat().numpy()
        memory = np.zeros((len(goals), MEMORY), np.float32)
        return np.column_stack([features, memory, np.full(len(goals), STOP, np.float32)])

    @torch.inference_mode()
    def act(self, observations: Observation, state: State) -> tuple[NDArray[np.intp], State]:
        """The most probable actions (N,), and the state after them.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        goals, memory, before = torch.from_numpy(state).split([FEATURES, MEMORY, 1], dim=1)
        logits, memory = self.network(
            self._encoded(observations), Encoded.of(goals), before.long(), memory[None].contiguous()
        )
        actions = logits[:, 0].argmax(dim=1).numpy()
        after = [state[:, :FEATURES], memory[0].numpy(), actions.astype(np.float32)]
        return actions, np.column_stack(after)

    def _encoded(self, observations: Observation) -> Encoded:
        images, depth = torch.from_numpy(np.ascontiguousarray(observations.image)), None
        if observations.depth is not None:
            depth = torch.from_numpy(np.asarray(observations.depth, dtype=np.float32))
        return self.network.pairs.encode(images, depth)
