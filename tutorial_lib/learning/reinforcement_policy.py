"""Trained policies that learnt by reinforcement, as agents that explore."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.learning.panorama_network import PANORAMA, PanoramaNetwork
from tutorial_lib.learning.reinforcement_network import ReinforcementNetwork
from tutorial_lib.learning.reinforcement_views import PolicyViews
from tutorial_lib.learning.views import check_camera
from tutorial_lib.observation import Observation
from tutorial_lib.validation import flags, instance
from tutorial_lib.world.noise import STOP


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
