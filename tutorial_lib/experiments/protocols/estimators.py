"""The estimators of reachability in the calibration table."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability, Targets
from tutorial_lib.learning.estimators import ReachabilityNetwork
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.topology.query import query
from tutorial_lib.topology.similarity import ImageSimilarity

CONTROLLERS = {"k0": "waypoint_k0", "k2": "waypoint_k2", "k5": "waypoint_k5", "laser": "laser_k2"}
"""Weights of C_WP by the name of a row."""
_AT_ONCE = 1_024


@dataclass(frozen=True)
class Estimator:
    """One estimator of reachability.

    Attributes:
        reachability: RE, or what stands in for it.
        controller: whose outcomes it predicts, one of `CONTROLLERS`.
        k: images of context on either side of a target.
    """

    reachability: Reachability
    controller: str
    k: int

    def targets(self, recorded: RecordedWorld, frames: NDArray[np.intp]) -> Targets:
        """Recorded frames (M,) as prepared targets."""
        view = getattr(self.reachability, "view", VIEWS["camera16"])
        poses = recorded.poses[recorded.context(frames, self.k)]
        return self.reachability.prepare(view.render(recorded.scene, poses))

    def predict(
        self, recorded: RecordedWorld, seen: Observation, targets: NDArray[np.intp]
    ) -> Array:
        """Probabilities (N,) that C reaches frames (N,) from where N observations were made."""
        frames, which = np.unique(targets, return_inverse=True)
        prepared = self.targets(recorded, frames)
        return self.query_all(seen, prepared, np.arange(len(seen)), which)

    def query_all(
        self, seen: Observation, prepared: Targets, rows: NDArray[np.intp], shown: NDArray[np.intp]
    ) -> Array:
        """Probabilities (N,) of pairs: indices of observations (N,) and of targets (N,)."""
        parts = np.array_split(np.arange(len(rows)), 1 + len(rows) // _AT_ONCE)
        found = [query(self.reachability, seen[rows[p]], prepared[shown[p]]) for p in parts]
        return np.concatenate(found)


def estimators(names: tuple[str, ...]) -> dict[str, Estimator]:
    """The estimators of those names; SPTM's and image similarity are compared with k = 2."""
    every = {name: (f"reach_{name}", name) for name in CONTROLLERS} | {"sptm": ("sptm", "k2")}
    found = {}
    for name in names:
        if name == "image":
            found[name] = Estimator(ImageSimilarity(), "k2", 0)
        else:
            weights, controller = every[name]
            network = ReachabilityNetwork(weights)
            found[name] = Estimator(network, controller, network.architecture.k)
    return found
