"""Panoramas at random places of many worlds with all labels: the data of the multi-task network.

A plan is recorded once, since its signs change what it looks like and nothing else. Files hold
poses and labels; the images are rendered when they are loaded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import RADIUS
from tutorial_lib.exploration.episodes import FAMILIES
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.files import make_folder, save_arrays
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of, world_name

PANORAMAS = 300
"""Of each world (Chaplot et al. 2020, 5)."""
OTHERS = ("scanned", "maze", "hall")
"""In place of every eighth training world, in turn."""
SHORTEST = 1.0
"""Metres that a direction must be traversable to be one to choose."""
FARTHEST = 16.0
"""Metres between two panoramas beyond which a pair has no labels."""
SEED = 11
"""Of the poses."""
VERSION = 2
"""Of the recorded labels."""
_EIGHTH, _NOWHERE, _ELSEWHERE = 8, -1, -2  # ends and goals in no room are not in the same
_NAMES = ("poses", "explorable", "kinds", "rooms", "room", "connected", "metres", "far")


@dataclass(frozen=True, eq=False)
class PanoramaWorld:
    """P panoramas of one plan with their labels; those of pairs by source, then by goal.

    Attributes:
        poses: (P, 3).
        explorable: (P, 12) F_G's labels.
        kinds: (P, 12) kind of room at each direction's end.
        rooms: (P, 12) number of the room there, negative in none.
        room: (P,) number of the room of each place, negative in none.
        connected: (P, P) F_L's labels.
        metres: (P, P, 12) from each direction's end to the goal; infinite for a direction that is
            not traversable for `SHORTEST`, and for pairs that are farther apart than `FARTHEST`.
        far: (P, P) geodesic metres, infinite beyond `FARTHEST`.
        depth: (P, 192) metres.
        images: (P, 16, 192, 3) uint8 by signs.
    """

    poses: Array
    explorable: NDArray[np.bool_]
    kinds: NDArray[np.int8]
    rooms: NDArray[np.int16]
    room: NDArray[np.int16]
    connected: NDArray[np.bool_]
    metres: NDArray[np.float16]
    far: NDArray[np.float16]
    depth: NDArray[np.float16]
    images: dict[str, NDArray[np.uint8]]


def training_plan(seed: int) -> tuple[str, int]:
    """Family and seed of a training world: apartments and offices, and every eighth another one.

    >>> [training_plan(seed)[0] for seed in (0, 1, 7, 15)]
    ['apartment', 'office', 'scanned', 'maze']
    """
    if seed % _EIGHTH == _EIGHTH - 1:
        return OTHERS[seed // _EIGHTH % len(OTHERS)], seed
    return unseen_plan(seed)


def unseen_plan(seed: int) -> tuple[str, int]:
    """Family and seed of a world of validation or test."""
    return FAMILIES[seed % len(FAMILIES)], seed


def panorama_worlds(
    plans: Sequence[tuple[str, int]], work: Path, count: int = PANORAMAS, jobs: int = 2
) -> list[PanoramaWorld]:
    """The panoramas of plans, recorded where they are missing, and rendered.

    So an interrupted recording resumes where it stopped, with the same files.

    Args:
        plans: family and seed of each.
        work: folder for the recordings.
        count: panoramas of each.
        jobs: processes.
    """
    folder = work / "panoramas"
    make_folder(folder)
    return for_each(_load, plans, folder, count, label="panoramas", jobs=jobs)


def _load(plan: tuple[str, int], folder: Path, count: int) -> PanoramaWorld:
    """One plan's panoramas, recorded if their file is missing or damaged."""
    path = folder / f"{plan[0]}-{plan[1]}-{count}.npz"
    scenes = {signs: scene_of(world_name(*plan, signs=signs)) for signs in SIGNS}
    try:
        arrays = load_arrays(path, _NAMES, version=VERSION)
    except InputError:
        rng = np.random.default_rng([SEED, crc32(plan[0].encode()), plan[1]])
        arrays = labels_of(scenes["plain"], random_poses(scenes["plain"], count, rng))
        save_arrays(path, arrays, version=VERSION, compressed=True)
    camera, poses = PanoramicCamera(), arrays["poses"]
    looks = {signs: camera.look(scene, poses) for signs, scene in scenes.items()}
    images = {signs: image for signs, (image, _) in looks.items()}
    depth = looks["plain"][1].astype(np.float16)
    return PanoramaWorld(**{name: arrays[name] for name in _NAMES}, depth=depth, images=images)


def random_poses(scene: Scene, count: int, rng: np.random.Generator) -> Array:
    """Poses (count, 3) anywhere in the largest part of a world where a robot fits."""
    paths = GridPaths(scene.clearance)
    nodes = rng.choice(np.flatnonzero(paths.largest), count)
    places = paths.points[nodes] + rng.uniform(-0.5, 0.5, (count, 2)) * paths.resolution
    return np.column_stack([places, rng.uniform(-np.pi, np.pi, count)])


def labels_of(scene: Scene, poses: Array) -> dict[str, NDArray]:
    """Labels of panoramas at poses (P, 3), by the names of `PanoramaWorld`."""
    labels = PanoramaLabels(scene, poses)
    count = len(poses)
    source, goal = (index.ravel() for index in np.indices((count, count)))
    metres = labels.metres(source, goal).reshape(count, count, -1)
    far = np.where(metres[..., -1] <= FARTHEST, metres[..., -1], np.inf)
    metres = np.where(np.isfinite(far)[..., None], metres[..., :-1], np.inf)
    metres = np.where((labels.lengths >= SHORTEST)[:, None], metres, np.inf)
    gaps = np.linalg.norm(poses[:, None, :2] - poses[:, :2], axis=-1)
    near = np.nonzero(gaps <= RADIUS)
    connected = np.zeros((count, count), bool)
    connected[near] = labels.connected(*near)
    room = room_numbers(scene.plan, poses[:, :2])
    ends = room_numbers(scene.plan, labels.ends.reshape(-1, 2))
    return {
        "poses": poses,
        "explorable": labels.explorable,
        "kinds": labels.end_rooms.astype(np.int8),
        "rooms": ends.reshape(count, -1),
        "room": np.where(room == _NOWHERE, _ELSEWHERE, room).astype(np.int16),
        "connected": connected,
        "metres": metres.astype(np.float16),
        "far": far.astype(np.float16),
    }


def room_numbers(plan: FloorPlan, points: Array) -> NDArray[np.int16]:
    """(N,) index of the room in which each point (N, 2) lies, -1 for none."""
    numbers = np.full(len(points), _NOWHERE, np.int16)
    for number, room in enumerate(plan.rooms):
        numbers[room.contains(points)] = number
    return numbers
