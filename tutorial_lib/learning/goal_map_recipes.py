"""How the learned global goal is trained that frontier exploration can take (`ans_like`).

Its data are half-explored maps with frontiers. Robots that follow an expert's path (see
`imitation_data`) map what they see. Somewhere on the way each looks for a goal, its own or another
one's: which of the frontiers leads there?
"""

import time
from collections.abc import Sequence
from pathlib import Path
from zlib import crc32

import numpy as np
import torch
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.frontier import CROP, SIDE, all_frontiers, crops
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.files import make_folder, save_arrays
from tutorial_lib.learning.exploration_data import training_plan, unseen_plan
from tutorial_lib.learning.exploration_recipes import FIRST_STOPPING
from tutorial_lib.learning.goal_map_network import (
    FRONTIERS,
    GoalMapArchitecture,
    GoalMapNetwork,
    GoalMapObjective,
    GoalMaps,
    GoalMapSource,
)
from tutorial_lib.learning.imitation_data import EPISODES, counts_in_name, record_expert
from tutorial_lib.learning.imitation_recipes import BaselineRecipe
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.weights import Card, digest_of, load_card, load_network
from tutorial_lib.parallel import for_each
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of, world_name

STEPS = 8_000
SEED = 17
"""Of episodes and of the places on the way."""
_EVERY = 2  # actions between two panoramas that are mapped
_LEAST, _CUTS = 6, 4  # actions before a robot looks for frontiers, and how often it does
_OWN = 0.3  # share of goals that are those of the expert's path
_FARTHEST = 16.0  # metres to a goal
_VERSION = 2
_NAMES = ("poses", "goals", "crops", "frontiers", "remaining")


def goal_maps(
    plans: Sequence[tuple[str, int]],
    network: PanoramaNetwork,
    work: Path,
    counts: dict[str, int] = EPISODES,
    jobs: int = 2,
) -> GoalMaps:
    """Maps in plans, recorded where they are missing, with what a trained network sees there.

    Args:
        plans: family and seed of each.
        network: the trained multi-task network.
        work: folder for the recordings.
        counts: episodes of each plan, by difficulty.
        jobs: processes.
    """
    folder = work / "goal_maps"
    make_folder(folder)
    return GoalMaps.joined(for_each(_load, plans, network, folder, counts, label="maps", jobs=jobs))


def _load(
    plan: tuple[str, int], network: PanoramaNetwork, folder: Path, counts: dict[str, int]
) -> GoalMaps:
    """One plan's maps, with each kind of signs.

    A depth camera's maps are the same with all signs and networks, predicted ones are not.
    """
    parts, name = [], f"{plan[0]}-{plan[1]}-{counts_in_name(counts)}"
    for signs in SIGNS:
        world = world_name(*plan, signs=signs)
        scene, mark = scene_of(world), ""
        if network.architecture.sensor == "rgb":
            mark = f"-{signs}-{digest_of(network)}"
        path = folder / f"{name}{mark}.npz"
        try:
            arrays = load_arrays(path, _NAMES, version=_VERSION)
        except InputError:
            rng = np.random.default_rng([SEED, crc32(plan[0].encode()), plan[1]])
            arrays = record_maps(scene, world, network, counts, rng)
            save_arrays(path, arrays, version=_VERSION, compressed=True)
        pairs = pair_features(network, scene, arrays["poses"], arrays["goals"])
        crops, frontiers, remaining = (arrays[n] for n in ("crops", "frontiers", "remaining"))
        parts.append(GoalMaps(crops, frontiers, remaining, pairs))
    return GoalMaps.joined(parts)


@torch.inference_mode()
def pair_features(
    network: PanoramaNetwork, scene: Scene, poses: Array, goals: Array
) -> NDArray[np.float16]:
    """(N, 12, HIDDEN) what a network has of directions at poses (N, 3) and goals (N, 3)."""
    found = []
    for first in range(0, len(poses), 64):
        encoded = []
        for places in (poses[first : first + 64], goals[first : first + 64]):
            images, depth = PanoramicCamera().look(scene, places)
            encoded.append(
                network.encode(torch.from_numpy(images), torch.from_numpy(depth).float())
            )
        found.append(network.directions(*encoded)[0].half().numpy())
    return np.concatenate(found)


def record_maps(
    scene: Scene,
    world: str,
    network: PanoramaNetwork,
    counts: dict[str, int],
    rng: np.random.Generator,
) -> dict[str, NDArray]:
    """Half-explored maps on the expert's paths in one world, by the names of `GoalMaps`.

    They are as an agent's are: by noisy odometry, of measured depth or of what `network` predicts.

    Args:
        scene: the world.
        world: its name.
        network: predicts depth if its sensor has none.
        counts: episodes of each difficulty.
        rng: draws episodes, goals, and where on the way a robot looks for frontiers.
    """
    driven = record_expert(scene, world, counts, rng)
    count = len(driven["goals"])
    cuts = rng.integers(_LEAST, np.maximum(driven["length"], _LEAST + 1), (_CUTS, count))
    maps = LocalMaps(count, SIDE)
    distances = GridPaths(scene.clearance).fields(driven["goals"][:, :2], shortest=True)
    parts = []
    for step in range(int(cuts.max()) + 1):
        here, odometry = driven["poses"][:, step], driven["odometry"][:, step]
        due = np.flatnonzero((cuts == step).any(axis=0))
        seen = np.arange(count) if step % _EVERY == 0 else due
        if len(seen):
            maps.observe(seen, odometry[seen], _ranges(network, scene, here[seen]))
        if len(due):
            own = rng.random(len(due)) < _OWN
            goal = np.where(own, due, rng.integers(count, size=len(due)))
            near = distances.distance(here[due, :2], goal) < _FARTHEST
            if near.any():
                mine = due[near]
                found = _looked(maps, mine, odometry[mine], here[mine], goal[near], distances)
                parts.append({**found, "goals": driven["goals"][goal[near]]})
    whole = {name: np.concatenate([part[name] for part in parts]) for name in _NAMES}
    choice = np.isfinite(whole["remaining"]).sum(axis=1) > 1
    return {name: values[choice] for name, values in whole.items()}


@torch.inference_mode()
def _ranges(network: PanoramaNetwork, scene: Scene, poses: Array) -> Array:
    """(N, W) metres that the depth camera measures, or that a network without one predicts."""
    images, depth = PanoramicCamera().look(scene, poses)
    if network.architecture.sensor == "rgbd":
        return depth
    columns = network.columns(torch.from_numpy(images), None)
    return network.encoder.log_ranges(columns).exp().numpy().astype(float)


def _looked(
    maps: LocalMaps,
    robots: NDArray[np.intp],
    odometry: Array,
    poses: Array,
    goals: NDArray[np.intp],
    distances: DistanceFields,
) -> dict[str, NDArray]:
    """What robots (M,) know of their maps, and how far frontiers are from goals.

    By odometry (M, 3) they know where a frontier is; poses (M, 3) say where that is in the world.
    """
    found = all_frontiers(maps, robots, odometry)
    frontiers = np.zeros((len(robots), FRONTIERS, 3), np.float32)
    remaining = np.full((len(robots), FRONTIERS), np.inf, np.float32)
    for row in range(len(robots)):
        mine = np.flatnonzero(found.robots == row)
        mine = mine[np.argsort(found.metres[mine], kind="stable")][:FRONTIERS]
        local = to_local(odometry[row], found.places[mine])
        frontiers[row, : len(mine)] = np.column_stack([local, found.metres[mine]])
        places = to_world(poses[row], local)
        remaining[row, : len(mine)] = distances.distance(places, goals[row])
    around = crops(maps, robots, odometry, CROP)
    return {"poses": poses, "crops": around, "frontiers": frontiers, "remaining": remaining}


def _recipe(sensor: str) -> BaselineRecipe:
    settings = Settings(
        max_steps=STEPS,
        targets=32,
        learning_rate=1e-3,
        warmup_steps=200,
        eval_interval=500,
        patience=STEPS,
    )
    command, architecture = f"train ans_like --sensor {sensor}", GoalMapArchitecture(sensor)
    return BaselineRecipe(
        f"ans_like_{sensor}", command, architecture, settings, f"nts_{sensor}", worlds=120
    )


GOAL_MAPS = {sensor: _recipe(sensor) for sensor in ("rgb", "rgbd")}
"""What `train ans_like` can train, by sensor."""


def train_goal_map(
    recipe: BaselineRecipe, work: Path, jobs: int = 2
) -> tuple[GoalMapNetwork, Card]:
    """Train a learned global goal, including its data.

    Recordings and checkpoints are kept in `work`, from which an interrupted run resumes.

    Args:
        recipe: what to train.
        work: folder for recordings and checkpoint.
        jobs: processes that record.

    Returns:
        The network and its card.
    """
    begun = time.monotonic()
    seeing = load_network(recipe.start, wanted=PanoramaNetwork)
    plans = [training_plan(seed) for seed in range(recipe.worlds)]
    source = GoalMapSource(goal_maps(plans, seeing, work, recipe.episodes, jobs))
    plans = [unseen_plan(FIRST_STOPPING + i) for i in range(recipe.validation_worlds)]
    unseen = GoalMapSource(goal_maps(plans, seeing, work, recipe.episodes, jobs))
    validation = [unseen.block([FIRST_STOPPING, i]) for i in range(3)]
    start = load_card(recipe.start).sha256
    said = {"start": start, "worlds": recipe.worlds, **source.recipe}
    return recipe.train(source, validation, work, begun, said, GoalMapObjective())
