"""Table I of Meng 2020: how often each local controller reaches a target near a recorded drive."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import torch
from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.driving.demonstrations import demonstrate
from tutorial_lib.driving.episodes import draw_episodes, with_obstacles
from tutorial_lib.driving.gridpath import GridPaths
from tutorial_lib.driving.recorded import RecordedWorld
from tutorial_lib.driving.rmp import RMPController
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.courses import Contender, Course, contenders
from tutorial_lib.experiments.report import Options, Report
from tutorial_lib.experiments.statistics import over_worlds
from tutorial_lib.geometry import Array
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import local_world, scene_of

WORLDS = tuple(range(20_000, 20_024))
CONDITIONS = ("clean", "noise", "obstacles", "shifted")
PAPER = {"direct": 0.46, "k0": 0.88, "k2": 0.91, "k5": 0.95}
"""Table I of the paper, which is clean."""
NOISE = 1 / 3
OBSTACLES = 2
CARS = 24
"""That record the drives of a world."""
_EPISODES, _QUICK_EPISODES = 100, 40
_BANDS = {"behind": (-1.0, 0.0), "near": (0.0, 1.0), "middle": (1.0, 2.0), "far": (2.0, 3.1)}

Results = dict[tuple[str, str], dict[str, Array]]
"""What every (controller, condition) made of each episode."""


def run(options: Options) -> Report:
    """Race all controllers on the same episodes.

    With `options.map` the only world is that file's, and there is no shifted palette.
    """
    begun = time.perf_counter()
    count = _QUICK_EPISODES if options.quick else _EPISODES
    worlds = options.worlds or (WORLDS[:10] if options.quick else WORLDS)
    places: list[Any] = list(worlds)
    if options.map is not None:
        worlds, places = (), [options.map]
        count = _QUICK_EPISODES if options.quick else 5 * _EPISODES
    run_all = Parallel(n_jobs=-1, return_as="generator")
    jobs = run_all(delayed(race)(place, count, options.seed) for place in places)
    parts = list(tqdm(jobs, total=len(places), desc="meng_table1", disable=None))
    results = _joined(parts)
    rows = [_row(results, *key) for key in results]
    took = time.perf_counter() - begun
    notes = _notes(results)
    return Report("meng_table1", options.seed, worlds, options.quick, took, rows, notes)


def race(place: Any, count: int, seed: int) -> Results:  # noqa: ANN401 - a seed or a file
    """Let every controller drive every condition of one world.

    Args:
        place: seed of a generated world, or a map's file.
        count: episodes.
        seed: of drives, episodes and noise.
    """
    torch.set_num_threads(1)
    found: Results = {}
    drivers = contenders(seed)
    for condition, course in courses(place, count, seed).items():
        for name, contender in drivers.items():
            found[name, condition] = attempt(course, contender, seed)
    return found


def attempt(course: Course, contender: Contender, seed: int) -> dict[str, Array]:
    """One contender on one course; each value is (N,)."""
    drives = course.run(contender(course), seed)
    return {
        "reached": drives.reached.astype(float),
        "collided": drives.collided.astype(float),
        "overlap": course.matched(drives).astype(float),
        "ahead": course.episodes.ahead,
    }


def courses(place: Any, count: int, seed: int) -> dict[str, Course]:  # noqa: ANN401
    """The conditions of one world; shifted colours only where a world is generated."""
    generated = isinstance(place, int)
    name = local_world(place) if generated else str(place)
    scene = scene_of(name) if generated else Scene(import_map(place, seed=seed))
    rng = np.random.default_rng([seed, place if generated else 0])
    drives = demonstrate(name, scene, CARS, int(rng.integers(2**31)), RMPController())
    recorded, paths = RecordedWorld(scene, drives), GridPaths(scene.clearance)
    episodes = draw_episodes(recorded, paths, count, rng)
    spare = draw_episodes(recorded, paths, 12 * count, rng)
    blocked, obstacles = with_obstacles(spare, OBSTACLES, count, rng)
    if not len(blocked):
        raise InputError(f"meng_table1: no room for obstacles in {name}; give a larger world")
    found = {
        "clean": Course(episodes, []),
        "noise": Course(episodes, [], NOISE),
        "obstacles": Course(blocked, obstacles),
    }
    if generated:
        shifted = RecordedWorld(scene_of(local_world(place, "shifted")), drives)
        found["shifted"] = Course(episodes.within(shifted), [])
    return found


def _joined(parts: list[Results]) -> Results:
    """All worlds one after the other, with the number of each episode's world."""
    joined: Results = {}
    for key in parts[0]:
        columns = {
            name: np.concatenate([part[key][name] for part in parts]) for name in parts[0][key]
        }
        sizes = [len(part[key]["reached"]) for part in parts]
        joined[key] = columns | {"world": np.repeat(np.arange(len(parts)), sizes)}
    return joined


def _row(results: Results, controller: str, condition: str) -> dict[str, Any]:
    found = results[controller, condition]
    reached = found["reached"]
    success, low, high = over_worlds(reached, found["world"])
    row: dict[str, Any] = {
        "controller": controller,
        "condition": condition,
        "episodes": len(reached),
        "success": success,
        "low": low,
        "high": high,
        "paper": PAPER.get(controller) if condition == "clean" else None,
        "collided": found["collided"].mean(),
        "success_or_overlap": found["overlap"].mean(),
    }
    for band, (nearest, farthest) in _BANDS.items():
        inside = (found["ahead"] >= nearest) & (found["ahead"] < farthest)
        row[f"success_{band}"] = reached[inside].mean() if inside.any() else None
    return row


def _notes(results: Results) -> tuple[str, ...]:
    """Paired differences, in points."""
    pairs = {
        "oracle - k5, clean": (("oracle", "clean"), ("k5", "clean")),
        "oracle - laser, clean": (("oracle", "clean"), ("laser", "clean")),
        "k5 - k0, clean": (("k5", "clean"), ("k0", "clean")),
        "k5: clean - noise": (("k5", "clean"), ("k5", "noise")),
        "k5: clean - shifted": (("k5", "clean"), ("k5", "shifted")),
    }
    notes = []
    for what, (first, second) in pairs.items():
        if second in results:
            gap = results[first]["reached"] - results[second]["reached"]
            mean, low, high = (100 * v for v in over_worlds(gap, results[first]["world"]))
            notes.append(f"{what}: {mean:+.1f} points ({low:+.1f} to {high:+.1f})")
    return tuple(notes)
