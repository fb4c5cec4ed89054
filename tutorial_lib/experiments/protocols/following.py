"""Recorded trajectories that are followed again by their anchors (Meng 2020, IV-A, IV-B)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.metrics import SLOWEST, covered
from tutorial_lib.driving.rollouts import NavigationEnds, ReachGoals, rollout
from tutorial_lib.experiments.protocols.navigation import (
    GRACE,
    TIMES,
    arrived_at,
)
from tutorial_lib.experiments.protocols.odometry import NAVIGATING, USUAL, Odometry
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.log import FollowerLog
from tutorial_lib.topology.mapping.sparsify import sparsify
from tutorial_lib.world.people import Person
from tutorial_lib.world.simulation import STEP, Simulation
from tutorial_lib.world.worlds import local_world, scene_of

WEIGHTS = {
    "k0": ("waypoint_k0", "reach_k0"),
    "k2": ("waypoint_k2", "reach_k2"),
    "k5": ("waypoint_k5", "reach_k5"),
    "laser": ("laser_k2", "reach_laser"),
}
"""C_WP and RE by context."""
Disturb = Callable[[Simulation, Robots], None]
"""Disturbs the robots under way."""
CARS = 48
"""That set out in a world, for trajectories to choose from."""
LENGTH = 15.0
"""Metres of the trajectories, on average (Meng 2020, IV-B)."""
UNDER_WAY = 2.0
"""Metres driven before a trajectory begins. Cars first manoeuvre until they face their path;
anchors that close together with opposite headings cannot be distinguished by overlap or waypoint,
however many are kept."""
_SHORTEST = 10.0
_BUDGET = 2.0  # times the time of the slowest rollout


def trajectories(
    seed: int, count: int, rng: np.random.Generator, family: str = ""
) -> RecordedWorld:
    """A world with `count` recorded trajectories of about `LENGTH` metres on average.

    They begin once the cars are under way. There are fewer where fewer are 10 m long.
    """
    name = local_world(seed, family=family)
    scene = scene_of(name)
    whole = demonstrate(name, scene, CARS, int(rng.integers(2**31)))
    moved = [one.since(UNDER_WAY) for one in whole if one.arc_length[-1] > 2 * UNDER_WAY]
    found = [one for one in moved if one.arc_length[-1] >= _SHORTEST] or moved
    found = sorted(rng.permutation(np.array(found, dtype=object)), key=_off_average)[:count]
    return RecordedWorld(scene, found)


def _off_average(trajectory: Any) -> float:  # noqa: ANN401 - a Trajectory
    return abs(trajectory.arc_length[-1] - LENGTH)


@dataclass(frozen=True)
class Guide:
    """C and RE with one context, in one world.

    Attributes:
        recorded: the trajectories.
        context: one of `WEIGHTS`.
        odometry: of the robots that follow, with the same drift each time.
    """

    recorded: RecordedWorld
    context: str
    odometry: Odometry = USUAL

    @cached_property
    def predictor(self) -> WaypointNetwork:
        """C_WP."""
        return WaypointNetwork(WEIGHTS[self.context][0])

    @cached_property
    def reachability(self) -> ReachabilityNetwork:
        """RE."""
        return ReachabilityNetwork(WEIGHTS[self.context][1])

    @property
    def k(self) -> int:
        """Images of context on either side of an anchor."""
        return self.predictor.architecture.k

    def images(self, frames: NDArray[np.intp]) -> NDArray:
        """Frames (N,) in their context, (N, 2k+1, H, W, C)."""
        poses = self.recorded.poses[self.recorded.context(frames, self.k)]
        return self.predictor.view.render(self.recorded.scene, poses)

    def anchors(self, trajectory: int, threshold: float) -> NDArray[np.intp]:
        """Frames (A,) of the world that the sparsifier keeps of a trajectory."""
        frames = self.recorded.frames_of(trajectory)
        seen = self.recorded.observe(frames, self.predictor.view.camera)
        prepared = self.reachability.prepare(self.images(frames))
        return frames[sparsify(self.reachability, seen, prepared, threshold)]

    def follow(
        self,
        anchors: list[NDArray[np.intp]],
        noise: float = 0.0,
        rng: np.random.Generator | None = None,
        people: Sequence[Person] = (),
        disturb: Disturb | None = None,
    ) -> tuple[Array, Array, FollowerLog]:
        """Follow paths of anchors, each from its first frame on.

        Args:
            anchors: frames (A,) of each robot's anchors, all of one trajectory.
            noise: sigma of the actuation noise.
            rng: of the noise.
            people: in the world.
            disturb: is called before each step with the simulation and the robots under way.

        Returns:
            Metres (N,) covered, poses (T, N, 3), and the follower's log.
        """
        recorded, ends = self.recorded, ends_of(anchors)
        simulation = self._simulation(ends, people, noise, rng)
        follower = self._follower(anchors)
        length = recorded.arc[ends[:, 1]] - recorded.arc[ends[:, 0]]
        limit = _BUDGET * length / SLOWEST + 10.0
        reach = ReachGoals(recorded.poses[ends[:, 1], :2], limit)
        rollouts = rollout(simulation, Following(follower, simulation, disturb), reach)
        metres = []
        for robot, (first, last) in enumerate(ends):
            steps = round(rollouts.seconds[robot] / STEP)
            touched = steps if rollouts.collided[robot] else None
            track = rollouts.poses[: steps + 1, robot]
            metres.append(covered(recorded.poses[first : last + 1], track, touched))
        return np.array(metres), rollouts.poses, follower.log()

    def deliver(
        self,
        anchors: list[NDArray[np.intp]],
        people: Sequence[Person] = (),
        disturb: Disturb | None = None,
    ) -> tuple[NDArray[np.bool_], FollowerLog]:
        """Follow paths of anchors until the robots declare that they have arrived, or give up.

        Success is that of navigation: declared within `NEAR` metres of the last anchor and facing
        as it does, in at most `TIMES` the time that the recorded robot took and `GRACE` seconds.

        Args:
            anchors: frames (A,) of each robot's anchors, all of one trajectory.
            people: in the world.
            disturb: as for `follow`.

        Returns:
            Success (N,), and the follower's log.
        """
        ends = ends_of(anchors)
        simulation, follower = self._simulation(ends, people), self._follower(anchors)
        following = Following(follower, simulation, disturb)
        limit = TIMES * STEP * (ends[:, 1] - ends[:, 0]) + GRACE
        found = rollout(simulation, following, NavigationEnds(following, limit))
        success = arrived_at(self.recorded.poses[ends[:, 1]], found)
        return success, follower.log()

    def _simulation(
        self,
        ends: NDArray[np.intp],
        people: Sequence[Person] = (),
        noise: float = 0.0,
        rng: np.random.Generator | None = None,
    ) -> Simulation:
        """Robots at the first of the frames `ends` (N, 2)."""
        return Simulation(
            self.recorded.scene,
            self.recorded.poses[ends[:, 0]],
            people=people,
            control_noise=noise,
            odometry_noise=self.odometry.noise(NAVIGATING),
            rng=rng,
        )

    def _follower(self, anchors: list[NDArray[np.intp]]) -> Follower:
        """A follower of these paths."""
        images = self.images(np.concatenate(anchors))
        targets, prepared = self.predictor.prepare(images), self.reachability.prepare(images)
        paths = AnchorPaths.end_to_end(targets, prepared, [len(one) for one in anchors])
        parts = self.predictor, RMPController(), self.reachability
        return Follower(paths, *parts)


def ends_of(anchors: list[NDArray[np.intp]]) -> NDArray[np.intp]:
    """The first and last frame (N, 2) of N paths of anchors."""
    return np.array([(one[0], one[-1]) for one in anchors])


@dataclass(frozen=True)
class Following:
    """A follower as a `Navigation`, whose robots may be disturbed before they observe.

    Attributes:
        follower: drives.
        simulation: the robots.
        disturb: is given the simulation and the robots under way before each step, if given.
    """

    follower: Follower
    simulation: Simulation
    disturb: Disturb | None = None

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """(N,) done."""
        return self.follower.memory.done

    @property
    def given_up(self) -> NDArray[np.bool_]:
        """(N,) lost."""
        return self.follower.memory.lost

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2); a robot that is lost or done stands still."""
        if self.disturb is not None:
            self.disturb(self.simulation, robots)
            observations = self.simulation.observe(robots)
        return self.follower.act(observations, robots)
