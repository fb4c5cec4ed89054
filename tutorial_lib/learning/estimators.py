"""Trained networks behind the interfaces of `tutorial_lib.interfaces`."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.calibration import Calibration
from tutorial_lib.learning.networks import LocalNetwork
from tutorial_lib.learning.tensors import tensor
from tutorial_lib.learning.threads import settle_threads
from tutorial_lib.learning.views import LaserView, check_camera
from tutorial_lib.learning.weights import load_card, load_network
from tutorial_lib.validation import batch, instance


@dataclass(frozen=True)
class EncodedTargets:
    """Targets, encoded as far as that does not depend on the current image.

    Attributes:
        encoded: (M, 2k+1, ...) from `LocalNetwork.encode_targets`.
        network: that encoded them.
    """

    encoded: Tensor
    network: LocalNetwork

    def __len__(self) -> int:
        return len(self.encoded)

    def __getitem__(self, index: Any) -> "EncodedTargets":  # noqa: ANN401 - any numpy index
        """The targets that `index` selects, as a batch."""
        index = np.array([index]) if isinstance(index, int | np.integer) else index
        rows = torch.from_numpy(np.arange(len(self))[index].copy())
        return replace(self, encoded=self.encoded.index_select(0, rows))  # quicker than an index

    @classmethod
    def joined(cls, parts: list["EncodedTargets"]) -> "EncodedTargets":
        """Targets of one network end to end."""
        if not parts:
            raise InputError("parts: empty; give one EncodedTargets at least")
        return replace(parts[0], encoded=torch.cat([part.encoded for part in parts]))


_AT_ONCE = 64  # robots; what is computed for them fits into the processor's cache


class _Estimator:
    """A network behind the interfaces."""

    takes_alone = False
    """Whether an image (M, 1, ...) may stand for all of a target's context."""

    def __init__(self, network: LocalNetwork | str, outputs: str) -> None:
        settle_threads()
        self.name = network if isinstance(network, str) else "this network"
        network = load_network(network) if isinstance(network, str) else network
        self.network = instance("network", network, LocalNetwork)
        self.architecture = self.network.architecture
        self.view, self.k = self.architecture.looks_at, self.architecture.k
        if self.architecture.outputs != outputs:
            raise InputError(
                f"network: predicts {self.architecture.outputs!r} where {outputs!r} is needed"
            )

    @torch.inference_mode()
    def prepare(self, contexts: NDArray) -> EncodedTargets:
        """Encode targets once, for many queries.

        Args:
            contexts: (M, 2k+1, H, W, C) images, as the network's view gives them.

        Raises:
            InputError: when the images have another size, or k does not fit the network.
        """
        wanted, contexts = self.architecture.images, _array_of("contexts", contexts)
        alone = self.takes_alone and contexts.ndim == 5 and contexts.shape[1] == 1
        if not alone and (contexts.ndim != 5 or contexts.shape[1] != wanted):
            raise InputError(
                f"contexts of the prepared targets: {contexts.shape}; this network has k = "
                f"{self.architecture.k}: give (M, {wanted}, H, W, C), each target with its context"
            )
        # Neighbours on a trajectory have most images in common: each is encoded once.
        images = contexts.reshape(-1, *contexts.shape[2:])
        number: dict[bytes, int] = {}
        which = [number.setdefault(image.tobytes(), len(number)) for image in images]
        fresh = images[np.unique(which, return_index=True)[1]]
        encoded = self.network.encode_targets(self.view.numbers(fresh[:, None]))[:, 0]
        return EncodedTargets(encoded[np.reshape(which, contexts.shape[:2])], self.network)

    @torch.inference_mode()
    def outputs(self, observations: Observation, targets: EncodedTargets | NDArray) -> Array:
        """The network's outputs (N, O) for N robots and as many targets."""
        _check_targets("targets", targets)
        prepared = targets if isinstance(targets, EncodedTargets) else self.prepare(targets)
        return self.compare(self.encode(observations), prepared)

    @torch.inference_mode()
    def encode(self, observations: Observation) -> Tensor:
        """Encode what N robots see, for many queries.

        Rows that repeat the one before, as in queries about many targets, are encoded once.
        """
        instance("observations", observations, Observation)
        if not isinstance(self.view, LaserView):
            check_camera(self.name, observations, self.view.camera)
        images = self.view.of(observations)
        repeats = (images[1:] == images[:-1]).all(axis=(1, 2, 3))
        fresh = np.append(True, ~repeats)[: len(images)]
        encoded = self.network.encode_current(self.view.numbers(images[fresh]))
        return encoded if fresh.all() else encoded[np.cumsum(fresh) - 1]

    @torch.inference_mode()
    def compare(self, current: Tensor, targets: EncodedTargets) -> Array:
        """The network's outputs (N, O) for N encoded observations and as many targets."""
        tensor("current", current, (...,))
        if instance("targets", targets, EncodedTargets).network is not self.network:
            raise InputError("targets: prepared by another network; prepare them with this one")
        if len(targets) != len(current):
            raise InputError(f"targets: {len(targets)} for {len(current)} robots; give as many")
        parts = zip(current.split(_AT_ONCE), targets.encoded.split(_AT_ONCE), strict=True)
        return _joined([self.network.compare(*part)[0] for part in parts])

    @torch.inference_mode()
    def outputs_uncached(self, observations: Observation, contexts: NDArray) -> Array:
        """The same without caching: every pair is encoded for itself, to compare speeds."""
        current = self.view.of(instance("observations", observations, Observation))
        wanted = (len(current), self.architecture.images)
        contexts = _array_of("contexts", contexts)
        if np.shape(contexts)[:2] != wanted:
            raise InputError(f"contexts: shape {np.shape(contexts)}; give {wanted} images")
        current, targets = self.view.numbers(current), self.view.numbers(contexts)
        parts = zip(current.split(_AT_ONCE), targets.split(_AT_ONCE), strict=True)
        return _joined([self.network(*part) for part in parts])


class WaypointNetwork(_Estimator):
    """C_WP (Meng 2020, III-B), a `WaypointPredictor`."""

    def __init__(self, network: LocalNetwork | str) -> None:
        """Put a trained network, or shipped weights by their name, behind the interface."""
        super().__init__(network, "waypoint")

    def predict(
        self, observations: Observation, targets: EncodedTargets | NDArray
    ) -> tuple[Array, Array]:
        """Waypoints (N, 2) in metres in the robots' frames, and mutual overlaps (N, 2)."""
        return _waypoints_and_overlaps(self.outputs(observations, targets))

    def predict_uncached(self, observations: Observation, contexts: NDArray) -> tuple[Array, Array]:
        """The same without caching, see `outputs_uncached`."""
        return _waypoints_and_overlaps(self.outputs_uncached(observations, contexts))


class DirectNetwork(_Estimator):
    """Images to speed and steering without a waypoint between, a `LocalController`."""

    def __init__(self, network: LocalNetwork | str) -> None:
        """Put a trained network, or shipped weights by their name, behind the interface."""
        super().__init__(network, "action")

    def act(self, observations: Observation, targets: EncodedTargets | NDArray) -> Array:
        """Actions (N, 2): speed in m/s and steering in rad."""
        return self.outputs(observations, targets)


class ReachabilityNetwork(_Estimator):
    """RE (Meng 2020, III-C), a `Reachability`."""

    outputs_wanted = "reachability"

    def __init__(self, network: LocalNetwork | str, calibration: Calibration | None = None) -> None:
        """Put a trained network, or shipped weights by their name, behind the interface.

        Args:
            network: predicts a logit.
            calibration: maps it to a probability; shipped weights have one on their card, and any
                other network's logit is used as it is.
        """
        super().__init__(network, self.outputs_wanted)
        if calibration is None and isinstance(network, str):
            calibration = Calibration(**load_card(network).calibration)
        calibration = Calibration() if calibration is None else calibration
        self.calibration = instance("calibration", calibration, Calibration)

    def probability(self, observations: Observation, prepared: EncodedTargets | NDArray) -> Array:
        """Probabilities (N,) that C reaches each target."""
        return self.calibration(self.logits(observations, prepared))

    def logits(self, observations: Observation, prepared: EncodedTargets | NDArray) -> Array:
        """Logits (N,) before calibration."""
        _check_targets("prepared", prepared)
        return self.outputs(observations, prepared)[:, 0]

    @torch.inference_mode()
    def embed(self, observations: Observation) -> NDArray[np.float32]:
        """Embeddings (N, R, D) of what N robots see."""
        return self.network.embed(self.encode(observations)).numpy()

    @torch.inference_mode()
    def embed_targets(self, prepared: EncodedTargets) -> NDArray[np.float32]:
        """Embeddings (N, P, R, D) of N targets: of their first image and of the middle one.

        The first was taken about where the target is just reachable.
        """
        count = instance("prepared", prepared, EncodedTargets).encoded.shape[1]
        some = prepared.encoded[:, sorted({0, count // 2})]
        return self.network.embed(some.flatten(0, 1)).unflatten(0, some.shape[:2]).numpy()


class RelativeNetwork(ReachabilityNetwork):
    """LTVN's model: whether a target is reachable and where it is, from one pair of images."""

    outputs_wanted = "relative"
    takes_alone = True  # as some of the targets that it learns from

    def predict(
        self, observations: Observation, targets: EncodedTargets | NDArray
    ) -> tuple[Array, Array]:
        """Probabilities (N,) that targets are reachable, and their poses (N, 3) if they are.

        Poses are x, y in metres and the heading in radians, in the robots' frames.
        """
        return self.split(self.outputs(observations, targets))

    def split(self, outputs: Array) -> tuple[Array, Array]:
        """Probabilities (N,) and poses (N, 3) of the network's outputs (N, 5)."""
        heading = np.arctan2(outputs[:, 4], outputs[:, 3])
        return self.calibration(outputs[:, 0]), np.column_stack([outputs[:, 1:3], heading])


def _array_of(name: str, values: ArrayLike) -> NDArray:
    """Values as an array of numbers; an `InputError` also for rows of different lengths."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{name}: rows of different lengths; give an array") from None
    return batch(name, array) if array.ndim else array


def _check_targets(name: str, targets: EncodedTargets | NDArray) -> None:
    if not isinstance(targets, EncodedTargets | np.ndarray):
        given = type(targets).__name__
        raise InputError(f"{name}: a {given}; give what `prepare` returned, or images")


def _joined(parts: list[Tensor]) -> Array:
    """The outputs of all robots."""
    return torch.cat(parts).numpy().astype(float)


def _waypoints_and_overlaps(outputs: Array) -> tuple[Array, Array]:
    """Waypoints (N, 2) and overlaps (N, 2) among a network's outputs (N, 6)."""
    return outputs[:, :2], 1.0 / (1.0 + np.exp(-outputs[:, 4:6]))
