"""Trained networks that drive fleets to frames of recorded drives; each is a `PolicyFactory`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.composed import ComposedController
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import PolicyFactory
from tutorial_lib.driving.rollouts import Policy
from tutorial_lib.interfaces import LocalController
from tutorial_lib.learning.estimators import (
    DirectNetwork,
    EncodedTargets,
    ReachabilityNetwork,
    WaypointNetwork,
)


def by_waypoints(predictor: WaypointNetwork) -> PolicyFactory:
    """C = C_RMP after C_WP."""
    return _pilot(predictor, ComposedController(predictor, RMPController()))


def directly(network: DirectNetwork) -> PolicyFactory:
    """From pictures to speed and steering."""
    return _pilot(network, network)


def encoded(
    network: WaypointNetwork | DirectNetwork | ReachabilityNetwork,
    recorded: RecordedWorld,
    frames: NDArray[np.intp],
) -> EncodedTargets:
    """Frames (N,) of recorded drives as targets: pictured in context, and each encoded once."""
    own, which = np.unique(frames, return_inverse=True)
    poses = recorded.poses[recorded.context(own, network.architecture.k)]
    return network.prepare(network.view.render(recorded.scene, poses))[which]


def _pilot(network: WaypointNetwork | DirectNetwork, controller: LocalController) -> PolicyFactory:
    def get_ready(recorded: RecordedWorld, frames: NDArray[np.intp]) -> Policy:
        own, which = np.unique(frames, return_inverse=True)
        targets = encoded(network, recorded, own)
        return lambda simulation, robots: controller.act(
            simulation.observe(robots), targets[which[robots]]
        )

    return get_ready
