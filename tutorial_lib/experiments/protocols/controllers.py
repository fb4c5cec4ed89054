"""The local controllers of Table I."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.composed import ComposedController, RandomWaypoints, TargetPolicy
from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import PolicyFactory
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.own import load_own
from tutorial_lib.interfaces import Policy
from tutorial_lib.learning.estimators import DirectNetwork, WaypointNetwork
from tutorial_lib.learning.policies import by_smoothed_waypoints, directly
from tutorial_lib.world.simulation import Simulation

SEAMS = ("predictor", "local controller", "controller")
"""What a class of one's own may be in Table I."""


def custom(where: str) -> PolicyFactory:
    """C with a component of the user's own, from "FILE.py:CLASS", beside what `k5` has.

    A waypoint predictor is followed as the other predictors are, a controller drives to the
    waypoints of k = 5, and a local controller drives by itself.

    Raises:
        InputError: as `load_own` does.
    """
    seam, part = load_own(where, SEAMS)
    if seam == "local controller":
        return directly(part)
    if seam == "predictor":
        return by_smoothed_waypoints(part)
    return by_smoothed_waypoints(WaypointNetwork("waypoint_k5"), controller=part)


def controllers(seed: tuple[int, int]) -> dict[str, PolicyFactory]:
    """The rows of Table I by name, bracketed by a random one and an oracle.

    C smooths its waypoints (not in the paper); `--ablation smoothing` compares it with C that does
    not. `seed` is that of the random one.
    """
    rmp = RMPController()

    def at_random(
        simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]
    ) -> Policy:
        del simulation, recorded
        predictor = RandomWaypoints(np.random.default_rng(seed))
        return TargetPolicy(ComposedController(predictor, rmp), frames)

    def oracle(simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]) -> Policy:
        paths = GridPaths(recorded.scene.clearance)
        return OraclePolicy(simulation, paths, recorded.poses[frames, :2], rmp)

    return {
        "random": at_random,
        "direct": directly(DirectNetwork("direct_k2")),
        "k0": by_smoothed_waypoints(WaypointNetwork("waypoint_k0")),
        "k2": by_smoothed_waypoints(WaypointNetwork("waypoint_k2")),
        "k5": by_smoothed_waypoints(WaypointNetwork("waypoint_k5")),
        "laser": by_smoothed_waypoints(WaypointNetwork("laser_k2")),
        "oracle": oracle,
    }
