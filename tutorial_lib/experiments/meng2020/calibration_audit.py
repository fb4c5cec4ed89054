"""The audit: how many far, occluded pairs, labelled 0 without a rollout, would be reached?"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs
from tutorial_lib.driving.data.rollout_outcomes import roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.learning.recipes import WORK, recorded_worlds_of
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import training_world

WORLDS = tuple(range(320, 344))
"""Training worlds that nothing else uses."""
METRES = (5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, np.inf)
"""Bounds of the geodesic distances, from row to row."""


@dataclass(frozen=True)
class Settings:
    """Settings of the audit.

    Attributes:
        pairs: in each world: 2,016 in all.
        cars: that record the trajectories of a world.
    """

    pairs: int = 84
    cars: int = 16


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Roll out far, occluded pairs and count those that reach their target."""
    names = [training_world(world) for world in options.worlds]
    recorded_worlds_of(names, settings.cars, WORK)
    parts = for_each(run_world, options.worlds, options, settings, label="audit")
    geodesic, reached = (np.concatenate(column) for column in zip(*parts, strict=True))
    world = np.repeat(np.arange(len(parts)), [len(part[0]) for part in parts])
    rows: Rows = []
    for least, most in [*pairwise(METRES), (METRES[0], np.inf)]:
        inside = (geodesic >= least) & (geodesic < most)
        found = over_worlds(reached[inside], world[inside]) if inside.any() else (None,) * 3
        share, low, high = found
        row = {"from_m": least, "to_m": most if np.isfinite(most) else None}
        rows.append(
            row | {"errands": int(inside.sum()), "reached": share, "low": low, "high": high}
        )
    return rows, ["k = 2; both overlaps < 0.1; the last row is all of them"]


def run_world(world: int, options: Options, settings: Settings) -> tuple[Array, Array]:
    """Metres (N,) to far, occluded targets of one training world, and whether reached (N,)."""
    rng, count = np.random.default_rng([options.seed, world]), settings.pairs
    (recorded,) = recorded_worlds_of([training_world(world)], settings.cars, WORK)
    paths = GridPaths(recorded.scene.clearance)
    pairs = draw_reachability_pairs(recorded, paths, 2 * count, rng)
    pairs = pairs.subset(rng.permutation(np.flatnonzero(pairs.far_and_occluded))[:count])
    policy = by_waypoints(WaypointNetwork("waypoint_k2"))
    outcomes = roll_out_pairs(recorded, pairs, policy, all_of_them=True)
    return pairs.geodesic, outcomes.reached.astype(float)


EXPERIMENT = Experiment(
    "audit", run, WORLDS, settings=Settings(), quick_settings=Settings(pairs=21)
)
