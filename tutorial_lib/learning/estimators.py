"""Trained networks behind the seams of `tutorial_lib.interfaces`."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.networks import LocalNetwork
from tutorial_lib.learning.weights import load_network


@dataclass(frozen=True)
class EncodedTargets:
    """Targets of which all that does not depend on the current picture is computed.

    Attributes:
        encoded: (M, 2k+1, ...) from `LocalNetwork.encode_targets`.
    """

    encoded: Tensor

    def __len__(self) -> int:
        return len(self.encoded)

    def __getitem__(self, index: Any) -> "EncodedTargets":  # noqa: ANN401 - any numpy index
        """The targets that `index` selects, as a batch."""
        index = [index] if isinstance(index, int | np.integer) else index
        return EncodedTargets(self.encoded[index])


class _Estimator:
    """A network that is asked about robots and their targets."""

    def __init__(self, network: LocalNetwork | str, outputs: str) -> None:
        self.network = load_network(network) if isinstance(network, str) else network
        self.architecture = self.network.architecture
        self.view = self.architecture.looks_at
        if self.architecture.outputs != outputs:
            raise InputError(
                f"network: tells {self.architecture.outputs!r} where {outputs!r} is needed"
            )

    @torch.inference_mode()
    def prepare(self, contexts: NDArray) -> EncodedTargets:
        """Encode targets once, to be asked about them again and again.

        Args:
            contexts: (M, 2k+1, H, W, C) pictures, as the network's view gives them.

        Raises:
            InputError: when the pictures have another size, or k does not fit the network.
        """
        wanted = self.architecture.pictures
        if contexts.ndim != 5 or contexts.shape[1] != wanted:
            raise InputError(
                f"targets: shape {contexts.shape}; this network has k = {self.architecture.k}: "
                f"give (M, {wanted}, H, W, C), each target with its context"
            )
        return EncodedTargets(self.network.encode_targets(self.view.numbers(contexts)))

    @torch.inference_mode()
    def ask(self, observations: Observation, targets: EncodedTargets | NDArray) -> Array:
        """The network's outputs (N, O) for N robots and as many targets."""
        prepared = targets if isinstance(targets, EncodedTargets) else self.prepare(targets)
        if len(prepared) != len(observations):
            raise InputError(
                f"targets: {len(prepared)} for {len(observations)} robots; give as many"
            )
        current = self.network.encode_current(self.view.numbers(self.view.of(observations)))
        return self.network.compare(current, prepared.encoded)[0].numpy().astype(float)


class WaypointNetwork(_Estimator):
    """C_WP (Meng 2020, III-B), a `WaypointPredictor`."""

    def __init__(self, network: LocalNetwork | str) -> None:
        """Put a trained network, or shipped weights by their name, behind the seam."""
        super().__init__(network, "waypoint")

    def predict(
        self, observations: Observation, targets: EncodedTargets | NDArray
    ) -> tuple[Array, Array]:
        """Waypoints (N, 2) in metres in the robots' frames, and mutual overlaps (N, 2)."""
        outputs = self.ask(observations, targets)
        return outputs[:, :2], 1.0 / (1.0 + np.exp(-outputs[:, 4:6]))


class DirectNetwork(_Estimator):
    """Pictures to speed and steering without a waypoint between, a `LocalController`."""

    def __init__(self, network: LocalNetwork | str) -> None:
        """Put a trained network, or shipped weights by their name, behind the seam."""
        super().__init__(network, "action")

    def act(self, observations: Observation, targets: EncodedTargets | NDArray) -> Array:
        """Actions (N, 2): speed in m/s and steering in rad."""
        return self.ask(observations, targets)
