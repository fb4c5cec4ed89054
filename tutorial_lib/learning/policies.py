"""Trained networks that drive fleets to recorded frames; each function makes a `PolicyFactory`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.composed import ComposedController, TargetPolicy
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.smoothed import SHARE, SmoothedPolicy
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import PolicyFactory
from tutorial_lib.interfaces import LocalController, Policy
from tutorial_lib.learning.estimators import (
    DirectNetwork,
    EncodedTargets,
    ReachabilityNetwork,
    WaypointNetwork,
)
from tutorial_lib.validation import instance, integers, with_methods
from tutorial_lib.world.simulation import Simulation


def by_waypoints(predictor: WaypointNetwork) -> PolicyFactory:
    """C = C_RMP after C_WP, without memory: what RE learns from."""
    instance("predictor", predictor, WaypointNetwork)
    return _factory(predictor, ComposedController(predictor, RMPController()))


def by_smoothed_waypoints(predictor: WaypointNetwork, share: float = SHARE) -> PolicyFactory:
    """C that drives to a moving average of its waypoints, see `SmoothedPolicy`."""

    def make(simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]) -> Policy:
        del simulation
        targets = encoded(predictor, recorded, frames)
        return SmoothedPolicy(predictor, RMPController(), targets, share)

    return make


def directly(network: DirectNetwork) -> PolicyFactory:
    """From images to speed and steering."""
    return _factory(network, network)


def encoded(
    network: WaypointNetwork | DirectNetwork | ReachabilityNetwork,
    recorded: RecordedWorld,
    frames: NDArray[np.intp],
) -> EncodedTargets:
    """Recorded frames (N,) in their context as targets; each is rendered and encoded once."""
    with_methods("network", network, "prepare")
    most = len(instance("recorded", recorded, RecordedWorld).poses) - 1
    frames = integers("frames", frames, ("N",), least=0, most=most)
    own, which = np.unique(frames, return_inverse=True)
    poses = recorded.poses[recorded.context(own, network.k)]
    return network.prepare(network.view.render(recorded.scene, poses))[which]


def _factory(
    network: WaypointNetwork | DirectNetwork, controller: LocalController
) -> PolicyFactory:
    def make(simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]) -> Policy:
        del simulation
        return TargetPolicy(controller, encoded(network, recorded, frames))

    return make
