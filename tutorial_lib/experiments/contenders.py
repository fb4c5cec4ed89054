"""The local controllers that are raced against each other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tutorial_lib.driving.courier import OracleCourier
from tutorial_lib.driving.episodes import Episodes
from tutorial_lib.driving.gridpath import GridPaths
from tutorial_lib.driving.local import ComposedController, RandomWaypoints
from tutorial_lib.driving.rmp import RMPController
from tutorial_lib.driving.rollouts import Driver
from tutorial_lib.learning.estimators import DirectNetwork, EncodedTargets, WaypointNetwork

Contender = Callable[[Episodes], Driver]
"""Gets ready for episodes, and drives them."""


def contenders(seed: tuple[int, int]) -> dict[str, Contender]:
    """The rows of Table I by name, bracketed by a random one and an oracle.

    `seed` is that of the random one.
    """
    rmp = RMPController()

    def at_random(episodes: Episodes) -> Driver:
        del episodes
        controller = ComposedController(RandomWaypoints(np.random.default_rng(seed)), rmp)
        return lambda simulation, robots: controller.act(simulation.observe(robots), None)

    def oracle(episodes: Episodes) -> Driver:
        paths = GridPaths(episodes.recorded.scene.clearance)
        return OracleCourier(paths, episodes.goals[:, :2], rmp).act

    return {
        "random": at_random,
        "direct": directly(DirectNetwork("direct_k2")),
        "k0": by_waypoints(WaypointNetwork("waypoint_k0")),
        "k2": by_waypoints(WaypointNetwork("waypoint_k2")),
        "k5": by_waypoints(WaypointNetwork("waypoint_k5")),
        "laser": by_waypoints(WaypointNetwork("laser_k2")),
        "oracle": oracle,
    }


def by_waypoints(predictor: WaypointNetwork) -> Contender:
    """C = C_RMP after C_WP."""

    def prepare(episodes: Episodes) -> Driver:
        targets = shown(predictor, episodes)
        controller = ComposedController(predictor, RMPController())
        return lambda simulation, robots: controller.act(
            simulation.observe(robots), targets[robots]
        )

    return prepare


def directly(network: DirectNetwork) -> Contender:
    """From pictures to speed and steering."""

    def prepare(episodes: Episodes) -> Driver:
        targets = shown(network, episodes)
        return lambda simulation, robots: network.act(simulation.observe(robots), targets[robots])

    return prepare


def shown(network: WaypointNetwork | DirectNetwork, episodes: Episodes) -> EncodedTargets:
    """The targets of episodes, pictured with their context and encoded once."""
    recorded = episodes.recorded
    frames = recorded.context(episodes.targets, network.architecture.k)
    return network.prepare(network.view.render(recorded.scene, recorded.poses[frames]))
