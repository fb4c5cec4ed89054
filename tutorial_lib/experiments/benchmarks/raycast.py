"""How fast are rays and images? pymunk, numpy and numba on the same walls, one thread."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.geometry import Array
from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.materials import Material, Stripe
from tutorial_lib.world.raycast import Fan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera

BATCH = 256
DENSITY = 120 / 14**2
"""Walls per square metre."""
_POSES = 4096
_RANGE = 30.0  # length of pymunk's rays in metres


@dataclass(frozen=True)
class Settings:
    """Settings of the benchmark.

    Attributes:
        walls: sizes of the random scenes.
        seconds: that each method is measured at each size.
    """

    walls: tuple[int, ...] = (50, 120, 500, 5000)
    seconds: float = 1.0


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Measure frames per second, of 64 rays over 120 degrees, for each method and size."""
    rows: Rows = []
    for walls in settings.walls:
        scene, poses = random_scene(walls, np.random.default_rng([options.seed, walls]))
        tasks = methods(scene, poses)
        speeds = {name: rate(task, settings.seconds) for name, task in tasks.items()}
        for name, speed in speeds.items():
            ratio = speed / speeds["pymunk"]
            rows.append({"method": name, "walls": walls, "frames_per_s": speed, "ratio": ratio})
    return rows, ["ratio: to pymunk's loop over bare rays, on the same walls and poses"]


def methods(scene: Scene, poses: Array) -> dict[str, Callable[[int], int]]:
    """For each method, a function that renders the batch of an index and returns its size."""
    fan, caster = Camera().fan, scene.caster
    few, many = Camera(rows=16), Camera(rows=64)
    space = space_of(caster.segments)

    def batch(index: int) -> Array:
        first = index * BATCH % len(poses)
        return poses[first : first + BATCH]

    def counted(work: Callable[[Array], object]) -> Callable[[int], int]:
        def task(index: int) -> int:
            work(batch(index))
            return BATCH

        return task

    def one_by_one(index: int) -> int:
        for pose in batch(index):
            caster.cast(pose[None], fan)
        return BATCH

    def pymunk_loop(index: int) -> int:
        few_poses = batch(index)[:16]
        query_loop(space, few_poses, fan)
        return len(few_poses)

    def numpy_batch(index: int) -> int:
        few_poses = batch(index)[: max(1, 500 // len(caster.segments))]
        numpy_distances(caster.segments, few_poses, fan)
        return len(few_poses)

    return {
        "pymunk": pymunk_loop,
        "numpy": numpy_batch,
        "numba": counted(lambda part: caster.cast(part, fan)),
        "numba_single": one_by_one,
        "image16": counted(lambda part: few.look(scene, part)),
        "image64": counted(lambda part: many.look(scene, part)),
    }


def rate(task: Callable[[int], int], seconds: float) -> float:
    """Frames per second: the median of several measurements, over at least `seconds` in total."""
    task(0)
    speeds = []
    end, index = time.perf_counter() + seconds, 1
    while time.perf_counter() < end or len(speeds) < 3:
        begun, frames = time.perf_counter(), 0
        while time.perf_counter() - begun < seconds / 10:
            frames += task(index)
            index += 1
        speeds.append(frames / (time.perf_counter() - begun))
    return float(np.median(speeds))


def query_loop(space: pymunk.Space, poses: Array, fan: Fan) -> list[float]:
    """Distances by pymunk's segment_query_first, ray by ray."""
    filter_, angles, distances = pymunk.ShapeFilter(), fan.angles.tolist(), []
    for x, y, heading in poses.tolist():
        for angle in angles:
            end = (
                x + _RANGE * math.cos(heading + angle),
                y + _RANGE * math.sin(heading + angle),
            )
            hit = space.segment_query_first((x, y), end, 0.0, filter_)
            distances.append(_RANGE * hit.alpha if hit else math.inf)
    return distances


def numpy_distances(segments: Array, poses: Array, fan: Fan) -> Array:
    """Distances (N, R) by numpy, every ray against every wall at once."""
    angles = poses[:, 2:] + fan.angles
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)[:, :, None]
    start = segments[:, :2] - poses[:, None, None, :2]
    run = segments[:, 2:] - segments[:, :2]
    across = rays[..., 0] * run[:, 1] - rays[..., 1] * run[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (start[..., 0] * run[:, 1] - start[..., 1] * run[:, 0]) / across
        along = (start[..., 0] * rays[..., 1] - start[..., 1] * rays[..., 0]) / across
    hit = (distance >= 0) & (along >= 0) & (along <= 1)
    return np.where(hit, distance, np.inf).min(axis=-1)


def space_of(segments: Array) -> pymunk.Space:
    """A pymunk space with the segments as walls of zero thickness."""
    space = pymunk.Space()
    for x0, y0, x1, y1 in segments.tolist():
        space.add(pymunk.Segment(space.static_body, (x0, y0), (x1, y1), 0.0))
    return space


def random_scene(walls: int, rng: np.random.Generator) -> tuple[Scene, Array]:
    """Walls of 0.5 to 3 m scattered at `DENSITY`, with striped materials, and poses (P, 3)."""
    side = math.sqrt(walls / DENSITY)
    middle, angle = rng.uniform(0, side, (walls, 2)), rng.uniform(0, 2 * np.pi, walls)
    half = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.25, 1.5, (walls, 1))
    materials = tuple(_striped(f"material {i}", rng) for i in range(12))
    plan = FloorPlan(
        family="scattered",
        seed=0,
        walls=np.concatenate([middle - half, middle + half], axis=1),
        wall_materials=tuple(materials[i].name for i in rng.integers(12, size=walls)),
        wall_offsets=rng.uniform(0, 20, walls),
        materials=materials,
        rooms=(Room("open", ((0, 0), (side, 0), (side, side), (0, side))),),
    )
    place = rng.uniform(0, side, (_POSES, 2))
    return Scene(plan), np.column_stack([place, rng.uniform(-np.pi, np.pi, _POSES)])


def _striped(name: str, rng: np.random.Generator) -> Material:
    colours = [tuple(colour) for colour in rng.integers(0, 256, (21, 3)).tolist()]
    starts = np.sort(rng.uniform(0, 24, 20)).tolist()
    stripes = [Stripe(a, a + 0.5, c) for a, c in zip(starts, colours[1:], strict=True)]
    return Material(name, colours[0], tuple(stripes))


EXPERIMENT = Experiment("raycast", run, settings=Settings(), quick_settings=Settings(seconds=0.2))
