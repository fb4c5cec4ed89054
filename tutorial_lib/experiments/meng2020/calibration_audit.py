"""The audit: what becomes of errands that count as failed without a robot being sent."""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Any

import numpy as np

from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs
from tutorial_lib.driving.data.rollout_outcomes import roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.learning.recipes import WORK, recorded_worlds_of
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import training_world

WORLDS = tuple(range(216, 240))
"""Training worlds, in which nothing else is done."""
ERRANDS, _QUICK_ERRANDS = 84, 21
"""In each world: 2,016 in all."""
METRES = (5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, np.inf)
_CARS = 16


def run(options: Options) -> Report:
    """Send robots on hopeless errands and see how many chance upon the target."""
    begun = time.perf_counter()
    worlds = options.worlds or WORLDS
    count = _QUICK_ERRANDS if options.quick else ERRANDS
    recorded_worlds_of([training_world(world) for world in worlds], _CARS, WORK)
    parts = for_each(chances, worlds, count, options.seed, label="audit")
    geodesic, reached = (np.concatenate(column) for column in zip(*parts, strict=True))
    where = np.repeat(np.arange(len(parts)), [len(part[0]) for part in parts])
    rows: list[dict[str, Any]] = []
    for least, most in [*pairwise(METRES), (METRES[0], np.inf)]:
        inside = (geodesic >= least) & (geodesic < most)
        found = over_worlds(reached[inside], where[inside]) if inside.any() else (None,) * 3
        share, low, high = found
        row = {"from_m": least, "to_m": most if np.isfinite(most) else None}
        rows.append(
            row | {"errands": int(inside.sum()), "reached": share, "low": low, "high": high}
        )
    note = "k = 2; both overlaps < 0.1; the last row is all of them"
    took = time.perf_counter() - begun
    return Report("audit", options.seed, worlds, options.quick, took, rows, (note,))


def chances(world: int, count: int, seed: int) -> tuple[Array, Array]:
    """Metres (N,) to hopeless targets of one training world, and whether they were reached (N,)."""
    rng = np.random.default_rng([seed, world])
    (recorded,) = recorded_worlds_of([training_world(world)], _CARS, WORK)
    errands = draw_reachability_pairs(recorded, GridPaths(recorded.scene.clearance), 2 * count, rng)
    errands = errands.subset(rng.permutation(np.flatnonzero(errands.far_and_occluded))[:count])
    pilot = by_waypoints(WaypointNetwork("waypoint_k2"))
    outcomes = roll_out_pairs(recorded, errands, pilot, all_of_them=True)
    return errands.geodesic, outcomes.reached.astype(float)
