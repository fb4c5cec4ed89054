"""Table I of Meng 2020: how often each local controller reaches a target near a recorded drive."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.experiments import ablations
from tutorial_lib.experiments.contenders import contenders
from tutorial_lib.experiments.courses import attempt, courses, worlds_of
from tutorial_lib.experiments.report import Options, Report
from tutorial_lib.experiments.statistics import difference, over_worlds
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import use_threads

PAPER = {"direct": 0.46, "k0": 0.88, "k2": 0.91, "k5": 0.95}
"""Table I of the paper, which is clean."""
_BANDS = {"behind": (-1.0, 0.0), "near": (0.0, 1.0), "middle": (1.0, 2.0), "far": (2.0, 3.1)}

Results = dict[tuple[str, str], dict[str, Array]]
"""What every (controller, condition) made of each episode."""


def run(options: Options) -> Report:
    """Race all controllers on the same episodes.

    With `options.map` the only world is that file's, and there is no shifted palette.
    """
    begun = time.perf_counter()
    if options.ablation:
        return ablations.run(options)
    worlds, count = worlds_of(options)
    places: list[Any] = list(worlds)
    if options.map is not None:
        worlds, places = (), [options.map]
        count = count if options.quick else 2 * count
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
    use_threads(1)  # the worlds are run side by side
    found: Results = {}
    drivers = contenders(seed)
    for condition, course in courses(place, count, seed).items():
        for name, contender in drivers.items():
            found[name, condition] = attempt(course, contender(course.episodes), seed)
    return found


def _joined(parts: list[Results]) -> Results:
    """All worlds one after the other, with the number of each episode's world."""
    joined: Results = {}
    for key in dict.fromkeys(key for part in parts for key in part):
        found = {number: part[key] for number, part in enumerate(parts) if key in part}
        names = next(iter(found.values()))
        columns = {name: np.concatenate([part[name] for part in found.values()]) for name in names}
        sizes = [len(part["reached"]) for part in found.values()]
        joined[key] = columns | {"world": np.repeat(list(found), sizes)}
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
            one, other = results[first], results[second]
            found = difference(one["reached"], other["reached"], one["world"])
            mean, low, high = (100 * value for value in found)
            notes.append(f"{what}: {mean:+.1f} points ({low:+.1f} to {high:+.1f})")
    return tuple(notes)
