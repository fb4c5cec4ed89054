"""Trained policies that learnt by reinforcement, behind the interface of recurrent policies."""

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


class LearnedReinforcement:
    """Chooses actions with the probabilities that it learnt, a `RecurrentPolicy`.

    Attributes:
        network: that chooses them.
        pairs: the multi-task network that it was trained with.
    """

    def __init__(
        self, network: ReinforcementNetwork, pairs: PanoramaNetwork, rng: np.random.Generator
    ) -> None:
        """Put a trained policy behind the interface; `rng` draws its actions."""
        self.network, self.pairs, self._rng = network.eval(), pairs.eval(), rng

    @property
    def sensor(self) -> str:
        """What a robot must carry: "rgbd"."""
        return self.network.architecture.sensor

    def start(self, goals: Observation) -> PolicyViews:
        """What N robots have seen before their first step: their goals.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        views = PolicyViews(len(goals), self.pairs, maps=self.network.architecture.maps)
        views.begin(np.arange(len(goals)), goals.image, _depth(goals))
        return views

    @torch.inference_mode()
    def act(
        self, observations: Observation, state: PolicyViews
    ) -> tuple[NDArray[np.intp], PolicyViews]:
        """Actions (N,), drawn, and the state after them, which is the same object.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        sensed = observations.image, _depth(observations), observations.odometry
        seen = state.see(np.arange(len(observations)), *sensed)
        logits = self.network({name: torch.from_numpy(part) for name, part in seen.items()})
        chances = logits.softmax(dim=1).numpy().cumsum(axis=1)
        drawn = self._rng.random((len(chances), 1)) * chances[:, -1:]
        actions = (drawn >= chances).sum(axis=1)
        state.acted(actions)
        return actions, state


def _depth(seen: Observation) -> NDArray[np.floating]:
    """The depth of panoramas that fit."""
    check_camera("the policy that learnt by reinforcement", seen, PANORAMA)
    if seen.depth is None:
        raise InputError("the policy that learnt by reinforcement: give the robot a depth camera")
    return seen.depth
