"""Trained networks that drive fleets to recorded frames; each function makes a `PolicyFactory`."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.composed import ComposedController, TargetPolicy
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.smoothed import SHARE, SmoothedPolicy
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import PolicyFactory
from tutorial_lib.interfaces import Controller, Policy, Targets
from tutorial_lib.learning.estimators import DirectNetwork, WaypointNetwork
from tutorial_lib.learning.views import View
from tutorial_lib.validation import instance, integers, with_methods
from tutorial_lib.world.simulation import Simulation


class Encoder(Protocol):
    """What makes targets of images; trained networks do."""

    @property
    def view(self) -> View:
        """What it looks at."""

    @property
    def k(self) -> int:
        """Images of context on either side of a target."""

    def prepare(self, contexts: NDArray) -> Targets:
        """Targets from images (M, 2k+1, H, W, C), indexable by an array."""


def by_waypoints(predictor: WaypointNetwork) -> PolicyFactory:
    """C = C_RMP after C_WP, without memory: what RE learns from."""
    with_methods("predictor", predictor, "prepare", "predict")
    controller = ComposedController(predictor, RMPController())
    return _factory(predictor, lambda targets: TargetPolicy(controller, targets))


def by_smoothed_waypoints(
    predictor: WaypointNetwork, share: float = SHARE, controller: Controller | None = None
) -> PolicyFactory:
    """C that drives to a moving average of its waypoints, see `SmoothedPolicy`.

    Args:
        predictor: C_WP.
        share: of the newest waypoint.
        controller: C_RMP, the library's unless given.
    """
    rmp = RMPController() if controller is None else controller
    return _factory(predictor, lambda targets: SmoothedPolicy(predictor, rmp, targets, share))


def directly(network: DirectNetwork) -> PolicyFactory:
    """From images to speed and steering."""
    return _factory(network, lambda targets: TargetPolicy(network, targets))


def encoded(
    network: Encoder,
    recorded: RecordedWorld,
    frames: NDArray[np.intp],
) -> Targets:
    """Recorded frames (N,) in their context as targets; each is rendered and encoded once."""
    with_methods("network", network, "prepare")
    most = len(instance("recorded", recorded, RecordedWorld).poses) - 1
    frames = integers("frames", frames, ("N",), least=0, most=most)
    own, which = np.unique(frames, return_inverse=True)
    poses = recorded.poses[recorded.context(own, network.k)]
    return network.prepare(network.view.render(recorded.scene, poses))[which]


def _factory(network: Encoder, policy: Callable[[Targets], Policy]) -> PolicyFactory:
    def make(simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]) -> Policy:
        del simulation
        return policy(encoded(network, recorded, frames))

    return make
