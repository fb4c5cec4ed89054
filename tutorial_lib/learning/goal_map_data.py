"""Half-explored maps with frontiers: the data of the learned global goal (`ans_like`).

Robots that follow an expert's path (see `imitation_data`) map what they see. Somewhere on the way
each looks for a goal, its own or another one's: which of the frontiers leads there?
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import RADIUS
from tutorial_lib.exploration.frontier import all_frontiers, crops
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.files import make_folder, save_arrays
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.learning.imitation_data import EPISODES, counts_in_name, record_expert
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.parallel import for_each
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of, world_name

CROP = 96
"""Cells along a side of the part of the map around a robot, of 0.1 m each."""
FRONTIERS = 16
"""Of a map, the nearest ones; farther ones are not learnt from."""
SEED = 17
"""Of episodes and of the places on the way."""
_SIDE = 24.0  # metres of the whole map
_EVERY = 2  # actions between two panoramas that are mapped
_LEAST, _CUTS = 6, 4  # actions before a robot looks for frontiers, and how often it does
_OWN = 0.3  # share of goals that are those of the expert's path
_FARTHEST = 16.0  # metres to a goal
_VERSION = 2
_NAMES = ("poses", "goals", "crops", "frontiers", "remaining")


@dataclass(frozen=True, eq=False)
class GoalMaps:
    """N half-explored maps.

    Attributes:
        crops: (N, CROP, CROP) uint8, see `interfaces.FrontierScorer`.
        frontiers: (N, FRONTIERS, 3) x and y in the robot's frame, and metres to go.
        remaining: (N, FRONTIERS) metres from a frontier to the goal; infinite for none.
        pairs: (N, 12, HIDDEN) what the multi-task network has of each direction and the goal.
    """

    crops: NDArray[np.uint8]
    frontiers: NDArray[np.float32]
    remaining: NDArray[np.float32]
    pairs: NDArray[np.float16]

    def targets(self, groups: NDArray[np.intp] | slice) -> GoalMaps:
        """A subset of the maps."""
        return GoalMaps(*(getattr(self, field.name)[groups] for field in fields(self)))

    def tensor(self, name: str) -> Tensor:
        """One of the arrays; floating-point ones in single precision."""
        array = torch.from_numpy(getattr(self, name))
        return array.float() if array.is_floating_point() else array

    @classmethod
    def joined(cls, parts: Sequence[GoalMaps]) -> GoalMaps:
        """All maps of the parts."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True)
class GoalMapSource:
    """Blocks of maps for `training.train`: any of all worlds.

    Attributes:
        recorded: the maps.
        worlds: 1, since maps of all worlds are drawn together.
        targets: of a block.
    """

    recorded: GoalMaps
    worlds: int = 1
    targets: int = 512

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        return {"maps": len(self.recorded.crops), "block": [self.worlds, self.targets]}

    def block(self, seed: Sequence[int]) -> GoalMaps:
        """The block of that seed."""
        rng = np.random.default_rng(seed)
        return self.recorded.targets(rng.integers(len(self.recorded.crops), size=self.targets))


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


def _load(plan: tuple[str, int], network: str, folder: Path, counts: dict[str, int]) -> GoalMaps:
    """One plan's maps, with each kind of signs."""
    path = folder / f"{plan[0]}-{plan[1]}-{counts_in_name(counts)}.npz"
    try:
        arrays = load_arrays(path, _NAMES, version=_VERSION)
    except InputError:
        rng = np.random.default_rng([SEED, crc32(plan[0].encode()), plan[1]])
        name = world_name(*plan)
        arrays = record_maps(scene_of(name), name, counts, rng)
        save_arrays(path, arrays, version=_VERSION, compressed=True)
    known = (arrays["crops"], arrays["frontiers"], arrays["remaining"])
    return GoalMaps.joined(
        [
            GoalMaps(
                *known,
                pair_features(
                    network,
                    scene_of(world_name(*plan, signs=signs)),
                    arrays["poses"],
                    arrays["goals"],
                ),
            )
            for signs in SIGNS
        ]
    )


@torch.inference_mode()
def pair_features(
    network: PanoramaNetwork, scene: Scene, poses: Array, goals: Array
) -> NDArray[np.float16]:
    """(N, 12, HIDDEN) what a network has of directions at poses (N, 3) and goals (N, 3)."""
    found = []
    for first in range(0, len(poses), 64):
        encoded = []
        for some in (poses[first : first + 64], goals[first : first + 64]):
            images, depth = PanoramicCamera().look(scene, some)
            encoded.append(
                network.encode(torch.from_numpy(images), torch.from_numpy(depth).float())
            )
        found.append(network.directions(*encoded)[0].half().numpy())
    return np.concatenate(found)


def record_maps(
    scene: Scene, world: str, counts: dict[str, int], rng: np.random.Generator
) -> dict[str, NDArray]:
    """Half-explored maps on the expert's paths in one world, by the names of `GoalMaps`.

    Args:
        scene: the world.
        world: its name.
        counts: episodes of each difficulty.
        rng: draws episodes, goals, and where on the way a robot looks for frontiers.
    """
    driven = record_expert(scene, world, counts, rng)
    count = len(driven["goals"])
    cuts = rng.integers(_LEAST, np.maximum(driven["length"], _LEAST + 1), (_CUTS, count))
    maps, camera = LocalMaps(count, _SIDE, RADIUS), PanoramicCamera()
    distances = GridPaths(scene.clearance).fields(driven["goals"][:, :2], shortest=True)
    parts = []
    for step in range(int(cuts.max()) + 1):
        here, due = driven["poses"][:, step], np.flatnonzero((cuts == step).any(axis=0))
        seen = np.arange(count) if step % _EVERY == 0 else due
        if len(seen):
            maps.observe(seen, here[seen], camera.look(scene, here[seen])[1])
        if len(due):
            own = rng.random(len(due)) < _OWN
            goal = np.where(own, due, rng.integers(count, size=len(due)))
            near = distances.distance(here[due, :2], goal) < _FARTHEST
            if near.any():
                found = _looked(maps, due[near], here[due[near]], goal[near], distances)
                parts.append({**found, "goals": driven["goals"][goal[near]]})
    whole = {name: np.concatenate([part[name] for part in parts]) for name in _NAMES}
    choice = np.isfinite(whole["remaining"]).sum(axis=1) > 1
    return {name: values[choice] for name, values in whole.items()}


def _looked(
    maps: LocalMaps,
    robots: NDArray[np.intp],
    poses: Array,
    goals: NDArray[np.intp],
    distances: DistanceFields,
) -> dict[str, NDArray]:
    """What robots (M,) at poses (M, 3) know of their maps, and how far frontiers are from goals."""
    found = all_frontiers(maps, robots, poses)
    frontiers = np.zeros((len(robots), FRONTIERS, 3), np.float32)
    remaining = np.full((len(robots), FRONTIERS), np.inf, np.float32)
    for row in range(len(robots)):
        mine = np.flatnonzero(found.robots == row)
        mine = mine[np.argsort(found.metres[mine], kind="stable")][:FRONTIERS]
        places = found.places[mine]
        local = to_local(poses[row], places)
        frontiers[row, : len(mine)] = np.column_stack([local, found.metres[mine]])
        remaining[row, : len(mine)] = distances.distance(places, goals[row])
    around = crops(maps, robots, poses, CROP)
    return {"poses": poses, "crops": around, "frontiers": frontiers, "remaining": remaining}
