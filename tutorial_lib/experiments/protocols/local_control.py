"""Table I's task: episodes of local control under several conditions (Meng 2020, III-B)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.episodes import Episodes, draw_episodes, with_obstacles
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import PolicyFactory
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import ReachGoals, Rollouts, rollout
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.protocols.odometry import NAVIGATING, Odometry
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP, Simulation
from tutorial_lib.world.visibility import mutual_overlap
from tutorial_lib.world.worlds import local_world, scene_of

WORLDS = tuple(range(20_000, 20_020))
NOISE = 1 / 3
OBSTACLES = 2
CARS = 24
"""That record the trajectories of a world."""
OVERLAPPING = 0.7
"""Both overlaps above which the authors' code counts a target as reached, too."""
_SPARE, _LONG = 5, 2.0  # times as many episodes, so long, among which are those with room


@dataclass(frozen=True)
class Condition:
    """One condition in one world, the same for all controllers.

    Attributes:
        episodes: starts and targets.
        people: obstacles on the path.
        noise: sigma of the factor on both controls.
        seed: of the noise; different in every world.
    """

    episodes: Episodes
    people: list[Person]
    noise: float = 0.0
    seed: tuple[int, int] = (0, 0)

    def run(self, make_policy: PolicyFactory) -> Rollouts:
        """Roll out all episodes at once."""
        episodes = self.episodes
        simulation = Simulation(
            episodes.recorded.scene,
            episodes.starts,
            people=self.people,
            control_noise=self.noise,
            odometry_noise=Odometry(seed=self.seed).noise(NAVIGATING),
            rng=np.random.default_rng(self.seed),
        )
        policy = make_policy(simulation, episodes.recorded, episodes.targets)
        return rollout(simulation, policy, ReachGoals(episodes.goals[:, :2], episodes.limit))

    def matched(self, rollouts: Rollouts) -> NDArray[np.bool_]:
        """(N,) whether a rollout reached its target, or ever had both overlaps with it."""
        caster, goals = self.episodes.recorded.scene.caster, self.episodes.goals
        matched = rollouts.reached.copy()
        for robot in np.flatnonzero(~rollouts.reached):
            # A collision ends a rollout.
            steps = round(rollouts.seconds[robot] / STEP) + (not rollouts.collided[robot])
            track = rollouts.poses[:steps, robot]
            both = mutual_overlap(caster, track, np.broadcast_to(goals[robot], track.shape))
            matched[robot] = (both > OVERLAPPING).all(axis=1).any()
        return matched


def conditions(place: int | Path, count: int, options: Options) -> dict[str, Condition]:
    """The conditions of one world, or of a region of a map; only a generated one is shifted.

    Episodes with obstacles are drawn from those that are long enough and leave room to pass.
    """
    recorded, paths, rng = _explored(place, options)
    episodes, seeds = draw_episodes(recorded, paths, count, rng), seeds_of(place, options.seed)
    found = {
        "clean": Condition(episodes, [], seed=seeds),
        "noise": Condition(episodes, [], NOISE, seeds),
    }
    spare = draw_episodes(recorded, paths, _SPARE * count, rng, _LONG, fewer=True)
    blocked, obstacles = with_obstacles(spare, OBSTACLES, count, rng)
    if len(blocked):
        found["obstacles"] = Condition(blocked, obstacles, seed=seeds)
    if isinstance(place, int):
        scene = scene_of(local_world(place, "shifted", options.family))
        shifted = RecordedWorld(scene, recorded.trajectories)
        found["shifted"] = Condition(episodes.within(shifted), [], seed=seeds)
    return found


def clean_condition(place: int | Path, count: int, options: Options) -> Condition:
    """The first of `conditions` alone."""
    recorded, paths, rng = _explored(place, options)
    episodes = draw_episodes(recorded, paths, count, rng)
    return Condition(episodes, [], seed=seeds_of(place, options.seed))


def seeds_of(place: int | Path, seed: int) -> tuple[int, int]:
    """Seeds of everything random in one world."""
    return seed, place if isinstance(place, int) else 0


def _explored(
    place: int | Path, options: Options
) -> tuple[RecordedWorld, GridPaths, np.random.Generator]:
    """A world with recorded trajectories, its geodesics, and the generator for all else."""
    if isinstance(place, int):
        name = local_world(place, family=options.family)
        scene = scene_of(name)
    else:
        name = str(place)
        scene = Scene(import_map(place, seed=options.seed, region=options.region))
    rng = np.random.default_rng(seeds_of(place, options.seed))
    trajectories = demonstrate(name, scene, CARS, int(rng.integers(2**31)))
    return RecordedWorld(scene, trajectories), GridPaths(scene.clearance), rng


def attempt(condition: Condition, make_policy: PolicyFactory) -> dict[str, Array]:
    """Run one policy under one condition; each value is (N,).

    Outcomes: reached, collided, and matched (see `Condition.matched`). Difficulty: metres ahead
    along the trajectory, bearing of the target in rad, the smaller overlap of start and target, and
    the smaller clearance of the two in metres.
    """
    episodes = condition.episodes
    rollouts = condition.run(make_policy)
    scene, starts, goals = episodes.recorded.scene, episodes.starts, episodes.goals
    seen = to_local(starts, goals[:, :2])
    room = np.stack([scene.clearance.at(poses[:, :2]) for poses in (starts, goals)])
    return {
        "reached": rollouts.reached.astype(float),
        "collided": rollouts.collided.astype(float),
        "matched": condition.matched(rollouts).astype(float),
        "ahead": episodes.ahead,
        "bearing": np.abs(np.arctan2(seen[:, 1], seen[:, 0])),
        "overlap": mutual_overlap(scene.caster, starts, goals).min(axis=1),
        "clearance": room.min(axis=0),
    }
