"""Every estimator in one world: what it says about errands and edges, and what happened."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.reachability_pairs import (
    FAR,
    SEEN,
    ReachabilityPairs,
    draw_reachability_pairs,
    reachability_pairs,
)
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes, roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS, Estimator, estimators
from tutorial_lib.experiments.protocols.geometry_bound import features
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import WaypointNetwork, use_threads
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.topology.mapping.sparsify import sparsify
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.visibility import mutual_overlap
from tutorial_lib.world.worlds import local_world, scene_of

SURE = 0.99
"""What a map asks for."""
_CARS = 24


@dataclass(frozen=True)
class Sizes:
    """How much is asked in each world.

    Attributes:
        targets: of the errands, with five starts each.
        far: pairs that are far apart and see nothing of each other.
        anchors: frames that are all paired with each other.
        edges: pairs of those that are driven, of those of which an estimator is sure.
        consecutive: pairs of consecutive anchors that are driven.
    """

    targets: int = 320
    far: int = 1_200
    anchors: int = 190
    edges: int = 30
    consecutive: int = 60


def examine(
    world: int, names: tuple[str, ...], bounds: dict[str, Any], sizes: Sizes, seed: int
) -> dict[str, dict[str, Array]]:
    """What each estimator says about one world, and what happened; arrays by name."""
    use_threads(1)  # the worlds are run side by side
    rng = np.random.default_rng([seed, world])
    name = local_world(world)
    scene = scene_of(name)
    recorded = RecordedWorld(scene, demonstrate(name, scene, _CARS, int(rng.integers(2**31))))
    paths = GridPaths(scene.clearance)
    errands = draw_reachability_pairs(recorded, paths, sizes.targets, rng)
    starts, far = far_pairs(recorded, paths, sizes.far, rng)
    frames = np.sort(rng.choice(len(recorded.poses), sizes.anchors, replace=False))
    every = estimators(names)
    outcomes = {c: _driven(recorded, errands, c) for c in {j.controller for j in every.values()}}
    given, found = features(recorded, errands), {}
    for name, judge in every.items():
        outcome = outcomes[judge.controller]
        asked = Asker(recorded, paths, judge, np.random.default_rng([seed, world]))
        told = asked.judge_poses(errands.starts, errands.targets)
        bound = bounds[judge.controller].predict_proba(given)[:, 1]
        found[name] = {
            "told": told,
            "reached": outcome.reached.astype(float),
            "seen": errands.seen,
            "bound": bound,
            "far": asked.judge_frames(starts, far),
            "consecutive": asked.consecutive(sizes.consecutive),
            "edges": asked.edges(frames, sizes.edges),
        }
    return found


@dataclass(frozen=True)
class Asker:
    """One estimator in one world."""

    recorded: RecordedWorld
    paths: GridPaths
    judge: Estimator
    rng: np.random.Generator

    def judge_poses(self, starts: Array, targets: NDArray[np.intp]) -> Array:
        """Probabilities (N,) from poses (N, 3) to frames (N,)."""
        seen = Simulation(self.recorded.scene, starts).observe()
        return self.judge.judge(self.recorded, seen, targets)

    def judge_frames(self, starts: NDArray[np.intp], targets: NDArray[np.intp]) -> Array:
        """Probabilities (N,) from frames (N,) to frames (N,)."""
        return self.judge.judge(self.recorded, self.recorded.observe(starts), targets)

    def consecutive(self, count: int) -> Array:
        """Whether C got from anchor to anchor, where the sparsifier was sure of it; (M,)."""
        pairs = []
        for trajectory in self.rng.permutation(len(self.recorded.trajectories)):
            frames = self.recorded.frames_of(trajectory)
            seen, prepared = (
                self.recorded.observe(frames),
                self.judge.targets(self.recorded, frames),
            )
            anchors = frames[sparsify(self.judge.reachability, seen, prepared, SURE)]
            pairs += list(pairwise(anchors))
            if len(pairs) >= 2 * count:
                break
        starts, targets = np.array(pairs).T
        sure = self.judge_frames(starts, targets) > SURE
        return self._reached(starts[sure], targets[sure], count)

    def edges(self, frames: NDArray[np.intp], count: int) -> Array:
        """Whether C got there, for some of all pairs of frames (A,) that would be edges; (M,)."""
        number = np.arange(len(frames))
        rows, columns = (pairs.ravel() for pairs in np.meshgrid(number, number, indexing="ij"))
        apart = rows != columns
        rows, columns = rows[apart], columns[apart]
        seen, prepared = self.recorded.observe(frames), self.judge.targets(self.recorded, frames)
        sure = self.judge.ask_all(seen, prepared, rows, columns) > SURE
        return self._reached(frames[rows[sure]], frames[columns[sure]], count)

    def _reached(self, starts: NDArray[np.intp], targets: NDArray[np.intp], count: int) -> Array:
        some = self.rng.permutation(len(starts))[:count]
        poses = self.recorded.poses[starts[some]]
        errands = reachability_pairs(self.recorded, self.paths, poses, targets[some])
        if not len(errands):
            return np.empty(0)
        outcomes = _driven(self.recorded, errands, self.judge.controller, all_of_them=True)
        return outcomes.reached.astype(float)


def far_pairs(
    recorded: RecordedWorld, paths: GridPaths, count: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Frames (N,), and others more than 5 m away; neither sees a tenth of the other's view."""
    spare, goals = 3 * count, max(count // 6, 1)
    starts = rng.integers(len(recorded.poses), size=spare)
    targets = np.sort(rng.integers(len(recorded.poses), size=goals))[
        np.arange(spare) * goals // spare
    ]
    first, second = recorded.poses[starts], recorded.poses[targets]
    far = paths.between(first[:, :2], second[:, :2]) > FAR
    starts, targets = starts[far], targets[far]
    both = mutual_overlap(recorded.scene.caster, first[far], second[far])
    hidden = rng.permutation(np.flatnonzero((both < SEEN).all(axis=1)))[:count]
    return starts[hidden], targets[hidden]


def _driven(
    recorded: RecordedWorld,
    errands: ReachabilityPairs,
    controller: str,
    all_of_them: bool = False,
) -> RolloutOutcomes:
    predictor = WaypointNetwork(CONTROLLERS[controller])
    return roll_out_pairs(
        recorded, errands, by_waypoints(predictor), predictor.view.camera, all_of_them
    )
