"""Rollouts per second of pairs of start and target, and queries of RE per second."""

import time
from dataclasses import dataclass, replace

import numpy as np
from joblib import Parallel, delayed

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.world.worlds import scene_of, world_name

JOBS = 2
"""Processes side by side, as on the reference machine."""
_BATCH = 256


@dataclass(frozen=True)
class Settings:
    """Settings of the benchmark.

    Attributes:
        cars: that record the trajectories.
        targets: of the rollouts in each process.
        anchors: all pairs of which are queried in each process.
        plain: queries without cached embeddings in each process.
    """

    cars: int = 16
    targets: int = 400
    anchors: int = 120
    plain: int = 1_024


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Roll out pairs with k = 2, and query RE on all pairs of anchors, in two processes."""
    world, seed = options.worlds[0], options.seed
    few = replace(settings, targets=20, anchors=20)
    with Parallel(n_jobs=JOBS) as side_by_side:
        # The first round loads and compiles.
        side_by_side(delayed(measure)(world, seed, few) for _ in range(JOBS))
        found = side_by_side(delayed(measure)(world, seed + i, settings) for i in range(JOBS))
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
    note = f"k = 2, {JOBS} processes of one thread; cached: both images of a pair encoded before"
    return rows, [note]


def measure(world: int, seed: int, settings: Settings) -> dict[str, tuple[int, float]]:
    """Numbers of rollouts, cached and plain queries, and the seconds that they took."""
    name = world_name("apartment", world)
    scene, rng = scene_of(name), np.random.default_rng(seed)
    recorded = RecordedWorld(scene, demonstrate(name, scene, settings.cars, seed))
    paths = GridPaths(scene.clearance)
    pairs = draw_reachability_pairs(recorded, paths, settings.targets, rng)
    policy = by_waypoints(WaypointNetwork("waypoint_k2"))
    begun = time.perf_counter()
    outcomes = roll_out_pairs(recorded, pairs, policy)
    driven = int(outcomes.driven.sum()), time.perf_counter() - begun
    network, count = ReachabilityNetwork("reach_k2"), settings.anchors
    frames = np.sort(rng.choice(len(recorded.poses), count, replace=False))
    observations = recorded.observe(frames)
    poses = recorded.poses[recorded.context(frames, network.architecture.k)]
    contexts = network.view.render(scene, poses)
    current, prepared = network.encode(observations), network.prepare(contexts)
    rows, columns = (indices.ravel() for indices in np.indices((count, count)))
    begun = time.perf_counter()
    for first in range(0, len(rows), _BATCH):
        part = slice(first, first + _BATCH)
        network.compare(current[rows[part]], prepared[columns[part]])
    cached = len(rows), time.perf_counter() - begun
    begun = time.perf_counter()
    for _ in range(settings.plain // _BATCH):
        one, other = rng.integers(count, size=(2, _BATCH))
        network.outputs_uncached(observations[one], contexts[other])
    plain = settings.plain, time.perf_counter() - begun
    return {"rollouts": driven, "cached": cached, "plain": plain}


EXPERIMENT = Experiment(
    "reachability",
    run,
    (20_000,),
    settings=Settings(),
    quick_settings=Settings(targets=120, anchors=60),
)
