"""A network that compares an observation with a target in its context (Meng 2020, III-B)."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from tutorial_lib.errors import InputError
from tutorial_lib.learning.encoders import FEATURES, MatchingEncoder, PairEncoder
from tutorial_lib.learning.tensors import tensor
from tutorial_lib.learning.views import View, view_named
from tutorial_lib.validation import instance

ENCODERS = {"matching": MatchingEncoder, "pair": PairEncoder}
OUTPUTS = {"waypoint": 6, "action": 2, "reachability": 3, "relative": 5}
"""Waypoint x, y, cosine and sine of the heading difference, two overlaps; speed and steering; the
logit of reachability, and two overlaps; or LTVN's model: the logit, x, y, cosine and sine of the
target's pose."""


@dataclass(frozen=True)
class Architecture:
    """All that is needed to build a network; it is stored on the card beside its weights.

    Attributes:
        k: images of context on either side of the target.
        encoder: one of `ENCODERS`.
        view: a name that `view_named` knows.
        outputs: one of `OUTPUTS`.
    """

    k: int
    encoder: str = "matching"
    view: str = "camera16"
    outputs: str = "waypoint"

    def __post_init__(self) -> None:
        known = {"encoder": tuple(ENCODERS), "outputs": tuple(OUTPUTS)}
        for name, choices in known.items():
            value = getattr(self, name)
            if not isinstance(value, str) or value not in choices:
                raise InputError(f"network: {name} {value!r}; give one of {', '.join(choices)}")
        try:
            view_named(self.view)
        except InputError as error:
            raise InputError(f"network: {error}") from None
        if type(self.k) is not int or not 0 <= self.k <= 20:
            raise InputError(f"network: k = {self.k!r}; give a whole number, 0 to 20")

    @property
    def images(self) -> int:
        """Of a target with its context, 2k + 1."""
        return 2 * self.k + 1

    @property
    def looks_at(self) -> View:
        """The view of that name."""
        return view_named(self.view)


class LocalNetwork(nn.Module):
    """Predicts waypoint, action, reachability or relative pose of a target in its context."""

    def __init__(self, architecture: Architecture) -> None:
        super().__init__()
        self.architecture = instance("architecture", architecture, Architecture)
        self._size = architecture.looks_at.size
        channels, rows, _ = self._size
        self.encoder = ENCODERS[architecture.encoder](channels, rows)
        self.context = nn.Conv1d(FEATURES, 128, architecture.images)
        self.hidden = nn.Linear(128, 64)
        self.heads = nn.Linear(64, OUTPUTS[architecture.outputs])
        self.pose = nn.Linear(FEATURES, 4)
        # torch's annotations leave out the keyword that its documentation has.
        self.to(memory_format=torch.channels_last)  # pyrefly: ignore[no-matching-overload]

    def encode_current(self, images: Tensor) -> Tensor:
        """Encode current images (N, C, H, W)."""
        return self.encoder.current(tensor("images", images, ("N", *self._size)))

    def encode_targets(self, contexts: Tensor) -> Tensor:
        """Encode targets (M, 2k+1, C, H, W), such as anchors: (M, 2k+1, ...)."""
        tensor("contexts", contexts, ("M", "P", *self._size))
        encoded = self.encoder.target(contexts.flatten(0, 1))
        return encoded.unflatten(0, contexts.shape[:2])

    def embed(self, encoded: Tensor) -> Tensor:
        """Embeddings (N, R, D) of unit length, for retrieval.

        A matching encoder has one for every two columns of an image, others one for all of it.

        Args:
            encoded: (N, ...) from `encode_current`, or of single images from `encode_targets`.
        """
        tensor("encoded", encoded, ("N", *self.encoder.shape))
        if not isinstance(self.encoder, MatchingEncoder):
            return functional.normalize(encoded.flatten(1)[:, None], dim=-1)
        columns = functional.normalize(encoded[..., : self.encoder.sizes[0]], dim=-1)
        return functional.normalize(columns.unflatten(1, (-1, 2)).mean(dim=2), dim=-1)

    def compare(self, current: Tensor, targets: Tensor) -> tuple[Tensor, Tensor]:
        """The network's outputs for pairs of encoded images.

        Args:
            current: (N, ...) from `encode_current`.
            targets: (N, 2k+1, ...) from `encode_targets`; of images alone (N, 1, ...).

        Returns:
            (N, O) outputs, and (N, 2k+1, 4) the pose of each context image: x, y, cosine and sine
            of the heading, in the frame of the current pose. Only training needs those.
        """
        tensor("current", current, ("N", *self.encoder.shape))
        tensor("targets", targets, (len(current), "P", *self.encoder.shape))
        features = self.encoder.compare(current, targets)
        return self._outputs(features), self.pose(features)

    def forward(self, current: Tensor, contexts: Tensor) -> Tensor:
        """Outputs (N, O) for images (N, C, H, W) and targets (N, 2k+1, C, H, W), nothing cached.

        This is the paper's plain evaluation: each pair is encoded for itself.
        """
        tensor("current", current, ("N", *self._size))
        tensor("contexts", contexts, (len(current), self.architecture.images, *self._size))
        pairs = contexts.shape[:2]
        repeated = current[:, None].expand(*pairs, -1, -1, -1).flatten(0, 1)
        features = self.encoder.compare(
            self.encoder.current(repeated), self.encoder.target(contexts.flatten(0, 1))[:, None]
        )
        return self._outputs(features.view(*pairs, FEATURES))

    def _outputs(self, features: Tensor) -> Tensor:
        """Outputs (N, O) from features of pairs (N, P, FEATURES)."""
        (wanted,) = self.context.kernel_size
        if features.shape[1] not in (1, wanted):
            raise InputError(
                f"network: targets of {features.shape[1]} images; give {wanted} to this one, or 1"
            )
        features = features.expand(-1, wanted, -1)  # an image alone stands for all of its context
        # The convolution sees all images at once, so it is one product, which is faster as such.
        weight = self.context.weight.transpose(1, 2).flatten(1)
        x = functional.linear(features.flatten(1), weight, self.context.bias).relu()  # (N, 128)
        return self.heads(self.hidden(x).relu())
