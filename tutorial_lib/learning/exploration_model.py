"""The trained multi-task network behind `interfaces.ExplorationModel`."""

from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, bearing_of
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.calibration import Calibration, sigmoid
from tutorial_lib.learning.panorama_encoder import FEATURES, Encoded
from tutorial_lib.learning.panorama_network import PANORAMA, Compared, PanoramaNetwork
from tutorial_lib.learning.views import check_camera
from tutorial_lib.learning.weights import load_card, load_network
from tutorial_lib.se2 import Array, wrap
from tutorial_lib.validation import floats, instance

_LARGEST = 1e6  # number of a feature
_AT_ONCE = 64  # panoramas or pairs; what is computed for them fits into the processor's cache


class LearnedExploration:
    """The four functions of Neural Topological SLAM, learned; an `ExplorationModel`.

    Attributes:
        network: that predicts all of them.
        calibration: of the connection's logit.
    """

    def __init__(
        self, network: PanoramaNetwork | str, calibration: Calibration | None = None
    ) -> None:
        """Put a trained network, or shipped weights by their name, behind the interface.

        Args:
            network: a network, or a name such as "nts_rgbd".
            calibration: maps the connection's logit to a probability; shipped weights have one on
                their card, and any other network's logit is used as it is.
        """
        if isinstance(network, str):
            if calibration is None:
                calibration = Calibration(**load_card(network).calibration)
            network = load_network(network, wanted=PanoramaNetwork)
        self.network = instance("network", network, PanoramaNetwork).eval()
        calibration = Calibration() if calibration is None else calibration
        self.calibration = instance("calibration", calibration, Calibration)

    @property
    def sensor(self) -> str:
        """What a robot must carry: "rgb", or "rgbd" for a depth camera as well."""
        return self.network.architecture.sensor

    @torch.inference_mode()
    def embed(self, observations: Observation) -> NDArray[np.float32]:
        """Features (N, FEATURES) of N panoramas, computed once for all that is asked of them.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        return _joined(lambda *both: self.network.encode(*both).flat(), self._inputs(observations))

    @torch.inference_mode()
    def ranges(self, observations: Observation) -> Array:
        """Metres (N, W) to the wall in each column: measured, or predicted from the image.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        instance("observations", observations, Observation)
        if self.sensor == "rgbd":
            if observations.depth is None:
                raise InputError("observations: without depth; take the network for rgb")
            return np.asarray(observations.depth, dtype=float)

        def metres(images: Tensor, depth: Tensor | None) -> Tensor:
            return self.network.encoder.log_ranges(self.network.columns(images, depth)).exp()

        return _joined(metres, self._inputs(observations)).astype(float)

    @torch.inference_mode()
    def explorable(self, features: NDArray[np.float32]) -> Array:
        """F_G: probabilities (N, 12) that a direction leads to explorable area."""
        encoded = Encoded.of(_tensor("features", features))
        return sigmoid(self.network.seen(encoded).explorable.numpy())

    def same_node(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_L: calibrated probabilities (P,) that a goal is visible from its source within 3 m."""
        return self.calibration(self._compared(sources, goals, lambda c: c.connection))

    def scores(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_S: scores (P, 12), an estimate of max(1 - d / 20 m, 0) from each direction's end."""
        return self._compared(sources, goals, lambda c: c.scores)

    def relative(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_R: goals (P, 2) of the same node: bearing in the source's frame (rad), and metres.

        The bearing is that of the most probable direction and the offset predicted for it.
        """
        found = self._compared(
            sources, goals, lambda c: torch.cat([c.direction, c.offset, c.nearness[:, None]], dim=1)
        )
        direction, offset, nearness = np.split(found, [DIRECTIONS, 2 * DIRECTIONS], axis=1)
        best = direction.argmax(axis=1)
        half_bin = np.pi / DIRECTIONS
        bearing = bearing_of(best) + half_bin * offset[np.arange(len(best)), best]
        return np.stack([wrap(bearing), RADIUS * (1.0 - nearness[:, 0])], axis=1)

    def _inputs(self, observations: Observation) -> tuple[Tensor, Tensor | None]:
        """Images, and depth for a network that looks at it."""
        instance("observations", observations, Observation)
        check_camera("the network that explores", observations, PANORAMA)
        images = torch.from_numpy(np.ascontiguousarray(observations.image))
        if self.sensor == "rgb" or observations.depth is None:
            return images, None
        return images, torch.from_numpy(np.asarray(observations.depth, dtype=np.float32))

    @torch.inference_mode()
    def _compared(
        self,
        sources: NDArray[np.float32],
        goals: NDArray[np.float32],
        part: Callable[[Compared], Tensor],
    ) -> Array:
        """A part of what is predicted of pairs, from rows (P, FEATURES) of either."""
        first, second = _tensor("sources", sources), _tensor("goals", goals)
        if len(sources) != len(goals):
            raise InputError(f"features: {len(sources)} sources, {len(goals)} goals; give as many")
        halves = [rows.split(_AT_ONCE) for rows in (first, second)]
        found = [
            part(self.network.compare(Encoded.of(source), Encoded.of(goal)))
            for source, goal in zip(*halves, strict=True)
        ]
        return torch.cat(found).numpy().astype(float)


def _tensor(name: str, features: NDArray[np.float32]) -> Tensor:
    """Features (N, FEATURES) as the network computes with them."""
    rows = floats(name, features, ("N", FEATURES), least=-_LARGEST, most=_LARGEST)
    return torch.from_numpy(np.ascontiguousarray(rows, dtype=np.float32))


def _joined(
    compute: Callable[..., Tensor], inputs: tuple[Tensor, Tensor | None]
) -> NDArray[np.float32]:
    """What `compute` makes of images and depth, a few panoramas at a time, as rows (N, ...)."""
    images, depth = inputs
    depths = [None] * max(len(images), 1) if depth is None else depth.split(_AT_ONCE)
    parts = zip(images.split(_AT_ONCE), depths, strict=False)
    return torch.cat([compute(*part) for part in parts]).numpy()
