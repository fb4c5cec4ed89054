"""Table I of Meng 2020: how often each local controller reaches a target near a recorded drive."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import difference, in_points, over_worlds
from tutorial_lib.experiments.meng2020 import table1_ablations
from tutorial_lib.experiments.protocols.controllers import controllers
from tutorial_lib.experiments.protocols.local_control import (
    attempt,
    conditions,
    seeds_of,
    worlds_of,
)
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each

PAPER = {"direct": 0.46, "k0": 0.88, "k2": 0.91, "k5": 0.95}
"""Table I of the paper, which is clean. Its direct control has k = 0, ours k = 2."""
_BREAKDOWN = {
    "behind": ("ahead", -1.1, 0.0),
    "to_1m": ("ahead", 0.0, 1.0),
    "to_2m": ("ahead", 1.0, 2.0),
    "to_3m": ("ahead", 2.0, 3.1),
    "not_before_it": ("bearing", np.pi / 3, np.pi + 1e-9),
    "little_overlap": ("overlap", 0.0, 0.1),
    "tight": ("clearance", 0.0, 0.3),
}
"""Parts of the episodes that have a column of their own: what was measured, from, to."""

Results = dict[tuple[str, str], dict[str, Array]]
"""What every (controller, condition) made of each episode."""


def run(options: Options) -> Report:
    """Race all controllers on the same episodes.

    With `options.map` the only world is that file's, and there is no shifted palette.
    """
    begun = time.perf_counter()
    if options.ablation:
        return table1_ablations.run(options)
    worlds, count = worlds_of(options)
    places: list[Any] = list(worlds)
    if options.map is not None:
        worlds, places = (), [options.map]
        count = count if options.quick else 2 * count
    parts = for_each(run_world, places, count, options.seed, label="meng_table1")
    results = _joined(parts)
    rows = [_row(results, *key) for key in results]
    took = time.perf_counter() - begun
    notes = _notes(results)
    where = "" if options.map is None else options.map.name
    return Report("meng_table1", options.seed, worlds, options.quick, took, rows, notes, where)


def run_world(place: Any, count: int, seed: int) -> Results:  # noqa: ANN401 - a seed or a file
    """Let every controller drive every condition of one world.

    Args:
        place: seed of a generated world, or a map's file.
        count: episodes.
        seed: of drives, episodes and noise.
    """
    found: Results = {}
    pilots = controllers(seeds_of(place, seed))
    for condition, course in conditions(place, count, seed).items():
        for name, pilot in pilots.items():
            found[name, condition] = attempt(course, pilot)
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
        "success_or_overlap": found["matched"].mean(),
    }
    for part, (what, least, most) in _BREAKDOWN.items():
        inside = (found[what] >= least) & (found[what] < most)
        row[f"success_{part}"] = reached[inside].mean() if inside.any() else None
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
            notes.append(f"{what}: {in_points(found)}")
    return tuple(notes)
