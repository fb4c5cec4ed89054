"""Courses for local controllers, and the controllers that are raced on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.courier import OracleCourier
from tutorial_lib.driving.episodes import Episodes
from tutorial_lib.driving.gridpath import GridPaths
from tutorial_lib.driving.local import ComposedController, RandomWaypoints
from tutorial_lib.driving.rmp import RMPController
from tutorial_lib.driving.rollouts import Driver, Drives, drive
from tutorial_lib.learning.estimators import DirectNetwork, EncodedTargets, WaypointNetwork
from tutorial_lib.world.people import Person
from tutorial_lib.world.simulation import STEP, Simulation
from tutorial_lib.world.visibility import mutual_overlap

OVERLAPPING = 0.7
"""Both overlaps beyond which the authors' code takes a target for reached too."""


@dataclass(frozen=True)
class Course:
    """What all controllers drive under one condition in one world.

    Attributes:
        episodes: starts and targets.
        people: obstacles on the way.
        noise: sigma of the factor on both controls.
    """

    episodes: Episodes
    people: list[Person]
    noise: float = 0.0

    def run(self, driver: Driver, seed: int) -> Drives:
        """Drive all episodes at once."""
        episodes = self.episodes
        rng = np.random.default_rng(seed)
        scene = episodes.recorded.scene
        simulation = Simulation(
            scene, episodes.starts, people=self.people, control_noise=self.noise, rng=rng
        )
        return drive(simulation, driver, episodes.goals[:, :2], episodes.limit)

    def matched(self, drives: Drives) -> NDArray[np.bool_]:
        """(N,) whether a drive ever saw what its target sees, and touched nothing before."""
        caster, goals = self.episodes.recorded.scene.caster, self.episodes.goals
        matched = drives.reached.copy()
        for robot in np.flatnonzero(~drives.reached & ~drives.collided):
            track = drives.poses[: round(drives.seconds[robot] / STEP) + 1 : 3, robot]
            both = mutual_overlap(caster, track, np.broadcast_to(goals[robot], track.shape))
            matched[robot] = (both > OVERLAPPING).all(axis=1).any()
        return matched


Contender = Callable[[Course], Driver]
"""Gets ready for a course, and drives it."""


def contenders(seed: int) -> dict[str, Contender]:
    """The rows of Table I by name, bracketed by a random one and an oracle."""
    rmp = RMPController()

    def at_random(course: Course) -> Driver:
        del course
        controller = ComposedController(RandomWaypoints(np.random.default_rng(seed)), rmp)
        return lambda simulation, robots: controller.act(simulation.observe(robots), None)

    def oracle(course: Course) -> Driver:
        paths = GridPaths(course.episodes.recorded.scene.clearance)
        return OracleCourier(paths, course.episodes.goals[:, :2], rmp).act

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

    def prepare(course: Course) -> Driver:
        targets = shown(predictor, course.episodes)
        controller = ComposedController(predictor, RMPController())
        return lambda simulation, robots: controller.act(
            simulation.observe(robots), targets[robots]
        )

    return prepare


def directly(network: DirectNetwork) -> Contender:
    """From pictures to speed and steering."""

    def prepare(course: Course) -> Driver:
        targets = shown(network, course.episodes)
        return lambda simulation, robots: network.act(simulation.observe(robots), targets[robots])

    return prepare


def shown(network: WaypointNetwork | DirectNetwork, episodes: Episodes) -> EncodedTargets:
    """The targets of episodes, pictured with their context and encoded once."""
    recorded = episodes.recorded
    frames = recorded.context(episodes.targets, network.architecture.k)
    return network.prepare(network.view.render(recorded.scene, recorded.poses[frames]))
