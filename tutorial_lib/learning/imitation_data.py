"""Episodes of an expert that knows the world: the data of behaviour cloning.

The expert follows the shortest path to the goal with discrete actions. Some of the actions that are
carried out are drawn at random instead, while the label stays the expert's: so the data shows how
to recover from mistakes (noise injection, Laskey et al. 2017).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import draw_episodes
from tutorial_lib.exploration.motion import actions_towards
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.files import make_folder, save_arrays
from tutorial_lib.geometry import Array
from tutorial_lib.learning.batches import Rows, drawn
from tutorial_lib.learning.panorama_batches import VARIED, recoloured
from tutorial_lib.parallel import for_each
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT, STOP
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of, world_name

EPISODES = {"easy": 10, "medium": 15, "hard": 25}
"""Of each world."""
STEPS = 110
"""Actions of an episode, at most."""
WINDOW = 48
"""Actions in a row that a batch shows of an episode."""
NOISE = 0.12
"""Share of actions that are drawn at random."""
ARRIVED = 0.6
"""Metres from the goal within which the expert stops."""
AFTER = 4
"""Actions that are recorded after its first stop, so that stopping is not too rare."""
SEED = 13
"""Of the episodes."""
_REACH = 0.7  # metres of the path ahead that the expert aims at
_STRAIGHT = np.deg2rad(7.0)  # bearing within which it drives on
_VERSION = 2
_NAMES = ("poses", "actions", "previous", "length", "goals")


@dataclass(frozen=True, eq=False)
class ExpertEpisodes:
    """E episodes in one plan.

    Attributes:
        poses: (E, T, 3) before each action.
        actions: (E, T) the expert's.
        previous: (E, T) carried out before; STOP before the first.
        length: (E,) actions of each episode.
        goals: (E, 3) poses.
        scenes: of the plan, by signs.
    """

    poses: Array
    actions: NDArray[np.int8]
    previous: NDArray[np.int8]
    length: NDArray[np.int16]
    goals: Array
    scenes: dict[str, Scene]


def expert_episodes(
    plans: Sequence[tuple[str, int]], work: Path, counts: dict[str, int] = EPISODES, jobs: int = 2
) -> list[ExpertEpisodes]:
    """Episodes in plans, recorded where they are missing, as `panorama_worlds` does."""
    folder = work / "imitation"
    make_folder(folder)
    return for_each(_load, plans, folder, counts, label="episodes", jobs=jobs)


def _load(plan: tuple[str, int], folder: Path, counts: dict[str, int]) -> ExpertEpisodes:
    path = folder / f"{plan[0]}-{plan[1]}-{counts_in_name(counts)}.npz"
    scenes = {signs: scene_of(world_name(*plan, signs=signs)) for signs in SIGNS}
    try:
        arrays = load_arrays(path, _NAMES, version=_VERSION)
    except InputError:
        rng = np.random.default_rng([SEED, crc32(plan[0].encode()), plan[1]])
        arrays = record_expert(scenes["plain"], world_name(*plan), counts, rng)
        arrays = {name: arrays[name] for name in _NAMES}
        save_arrays(path, arrays, version=_VERSION, compressed=True)
    return ExpertEpisodes(**{name: arrays[name] for name in _NAMES}, scenes=scenes)


def counts_in_name(counts: dict[str, int]) -> str:
    """Episodes of each difficulty as part of a file's name.

    >>> counts_in_name({"easy": 10, "hard": 25})
    'easy10-hard25'
    """
    return "-".join(f"{difficulty}{count}" for difficulty, count in counts.items())


def record_expert(
    scene: Scene, world: str, counts: dict[str, int], rng: np.random.Generator
) -> dict[str, NDArray]:
    """Drive the expert in one world, all its episodes in lock-step.

    Args:
        scene: the world.
        world: its name.
        counts: episodes of each difficulty.
        rng: draws episodes, actuation noise and mistakes.

    Returns:
        Arrays by the names of `ExpertEpisodes`, and (E, T, 3) "odometry".
    """
    episodes = draw_episodes(world, scene, counts, rng)
    fields_ = GridPaths(scene.clearance).fields(episodes.goals[:, :2])
    task, count = ExplorationTask({world: scene}, episodes, rng, limit=STEPS), len(episodes)
    executed, over = np.full(count, STOP), np.zeros(count, np.intp)
    seen, odometry, labels, before = [], [], [], []
    length = np.zeros(count, np.intp)
    for _ in range(STEPS):
        action = expert_actions(scene, fields_, task.poses)
        seen.append(task.poses)
        odometry.append(task.odometry)
        labels.append(action)
        before.append(executed)
        length += over <= AFTER
        over += (action == STOP) | (over > 0)
        mistaken = (rng.random(count) < NOISE) | (action == STOP)
        executed = np.where(mistaken, rng.choice([FORWARD, LEFT, RIGHT], count), action)
        task.step(executed)
    return {
        "poses": np.stack(seen, axis=1),
        "odometry": np.stack(odometry, axis=1),
        "actions": np.stack(labels, axis=1).astype(np.int8),
        "previous": np.stack(before, axis=1).astype(np.int8),
        "length": length.astype(np.int16),
        "goals": episodes.goals,
    }


def expert_actions(scene: Scene, paths: DistanceFields, poses: Array) -> NDArray[np.intp]:
    """Actions (N,) of robots at poses (N, 3), each to the goal of its own index."""
    own = np.arange(len(poses))
    aims = paths.waypoints(poses[:, :2], own, scene.caster, _REACH)
    actions = actions_towards(poses, aims, _STRAIGHT)
    there = np.linalg.norm(poses[:, :2] - paths.goals, axis=1) < ARRIVED
    return np.where(there, STOP, actions)


@dataclass(frozen=True)
class ImitationBatch(Rows):
    """G parts of episodes of `WINDOW` actions, which begin anywhere.

    Attributes:
        images: (G, T, 16, 192, 3) uint8.
        depth: (G, T, 192) metres.
        goal_images: (G, 16, 192, 3) uint8.
        goal_depth: (G, 192) metres.
        previous: (G, T) actions carried out before.
        actions: (G, T) the expert's.
        used: (G, T) whether there is such a step.
    """

    images: NDArray[np.uint8]
    depth: NDArray[np.float32]
    goal_images: NDArray[np.uint8]
    goal_depth: NDArray[np.float32]
    previous: NDArray[np.int64]
    actions: NDArray[np.int64]
    used: NDArray[np.bool_]


@dataclass(frozen=True)
class ImitationSource:
    """Blocks of parts of episodes for `training.train`.

    Attributes:
        recorded: episodes of all worlds.
        worlds: drawn for a block.
        targets: episodes of each world.
        vary: whether colours are changed.
    """

    recorded: Sequence[ExpertEpisodes]
    worlds: int = 8
    targets: int = 4
    vary: bool = True

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        steps = sum(int(world.length.sum()) for world in self.recorded)
        return {"steps": steps, "block": [self.worlds, self.targets, WINDOW], "vary": self.vary}

    def block(self, seed: Sequence[int]) -> ImitationBatch:
        """The block of that seed."""
        return drawn(self.recorded, self.worlds, self._world, np.random.default_rng(seed))

    def _world(self, world: ExpertEpisodes, rng: np.random.Generator) -> ImitationBatch:
        signs = str(rng.choice(SIGNS))
        chosen = rng.integers(len(world.goals), size=self.targets)
        length = world.length[chosen].astype(np.intp)
        first = rng.integers(0, np.maximum(length - WINDOW, 0) + 1)
        steps = first[:, None] + np.arange(WINDOW)
        used = steps < length[:, None]
        steps = np.minimum(steps, length[:, None] - 1)
        poses = np.concatenate([world.poses[chosen[:, None], steps], world.goals[chosen, None]], 1)
        image, depth = PanoramicCamera().look(world.scenes[signs], poses.reshape(-1, 3))
        image = image.reshape(*poses.shape[:2], *image.shape[1:])
        depth = depth.reshape(*poses.shape[:2], -1).astype(np.float32)
        if self.vary:
            for group in np.flatnonzero(rng.random(self.targets) < VARIED[signs]):
                image[group] = recoloured(image[group], rng)
        return ImitationBatch(
            image[:, :-1],
            depth[:, :-1],
            image[:, -1],
            depth[:, -1],
            world.previous[chosen[:, None], steps].astype(np.int64),
            world.actions[chosen[:, None], steps].astype(np.int64),
            used,
        )
