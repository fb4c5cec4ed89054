"""How many errands are driven a second, and how many pairs RE is asked about."""

from __future__ import annotations

import time

import numpy as np
from joblib import Parallel, delayed

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork, use_threads
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.world.worlds import scene_of, world_name

WORLD = 20_000
JOBS = 2
"""Processes that drive or ask side by side, as on the reference machine."""
_CARS = 16
_TARGETS, _QUICK_TARGETS = 400, 120
_ANCHORS, _QUICK_ANCHORS = 120, 60
_PLAIN = 1_024
_BLOCK = 256


def run(options: Options) -> Report:
    """Drive errands of k = 2, and ask RE about all pairs of anchors, in two processes."""
    begun = time.perf_counter()
    worlds = options.worlds[:1] or (WORLD,)
    targets = _QUICK_TARGETS if options.quick else _TARGETS
    anchors = _QUICK_ANCHORS if options.quick else _ANCHORS
    with Parallel(n_jobs=JOBS) as side_by_side:
        # The first round loads and compiles.
        side_by_side(delayed(measure)(worlds[0], options.seed, 20, 20) for _ in range(JOBS))
        found = side_by_side(
            delayed(measure)(worlds[0], options.seed + i, targets, anchors) for i in range(JOBS)
        )
    per_second = {
        name: sum(count / seconds for count, seconds in (part[name] for part in found))
        for name in found[0]
    }
    rows = [
        {
            "what": name,
            "count": sum(part[name][0] for part in found),
            "per_s": rate,
            "over_plain": rate / per_second["plain"] if name == "cached" else None,
        }
        for name, rate in per_second.items()
    ]
    took = time.perf_counter() - begun
    notes = (
        f"k = 2, {JOBS} processes of one thread; cached: both pictures of a pair encoded before",
    )
    return Report("reachability", options.seed, worlds, options.quick, took, rows, notes)


def measure(world: int, seed: int, targets: int, anchors: int) -> dict[str, tuple[int, float]]:
    """How many rollouts, cached and plain queries were made, and the seconds they took."""
    use_threads(1)
    name = world_name("apartment", world)
    scene, rng = scene_of(name), np.random.default_rng(seed)
    recorded = RecordedWorld(scene, demonstrate(name, scene, _CARS, seed))
    errands = draw_reachability_pairs(recorded, GridPaths(scene.clearance), targets, rng)
    pilot = by_waypoints(WaypointNetwork("waypoint_k2"))
    begun = time.perf_counter()
    outcomes = roll_out_pairs(recorded, errands, pilot)
    driven = int(outcomes.driven.sum()), time.perf_counter() - begun
    network = ReachabilityNetwork("reach_k2")
    frames = np.sort(rng.choice(len(recorded.poses), anchors, replace=False))
    seen = recorded.observe(frames)
    poses = recorded.poses[recorded.context(frames, network.architecture.k)]
    contexts = network.view.render(scene, poses)
    current, prepared = network.encode(seen), network.prepare(contexts)
    rows, columns = (pairs.ravel() for pairs in np.indices((anchors, anchors)))
    begun = time.perf_counter()
    for first in range(0, len(rows), _BLOCK):
        some = slice(first, first + _BLOCK)
        network.compare(current[rows[some]], prepared[columns[some]])
    cached = len(rows), time.perf_counter() - begun
    begun = time.perf_counter()
    for _ in range(_PLAIN // _BLOCK):
        some = rng.integers(anchors, size=(2, _BLOCK))
        network.outputs_uncached(seen[some[0]], contexts[some[1]])
    return {"rollouts": driven, "cached": cached, "plain": (_PLAIN, time.perf_counter() - begun)}
