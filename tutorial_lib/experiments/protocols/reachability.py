"""Every estimator in one world: predictions for pairs and edges, and the outcomes."""

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
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.topology.mapping.sparsify import sparsify
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.visibility import mutual_overlap
from tutorial_lib.world.worlds import local_world, scene_of

SURE = 0.99
"""RE that a map demands."""
_CARS = 24


@dataclass(frozen=True)
class Sizes:
    """How many pairs are queried in each world.

    Attributes:
        targets: of the pairs, with five starts each.
        far: far, occluded pairs.
        anchors: frames of which all pairs are queried.
        edges: rollouts of such pairs above `SURE`.
        consecutive: rollouts from an anchor to the next.
    """

    targets: int = 320
    far: int = 1_200
    anchors: int = 190
    edges: int = 30
    consecutive: int = 60


def examine(
    world: int,
    names: tuple[str, ...],
    bounds: dict[str, Any],
    sizes: Sizes,
    seed: int,
    family: str = "",
) -> dict[str, dict[str, Array]]:
    """Predictions of each estimator in one world, and the outcomes; arrays by name."""
    every = estimators(names)
    rng = np.random.default_rng([seed, world])
    name = local_world(world, family=family)
    scene = scene_of(name)
    recorded = RecordedWorld(scene, demonstrate(name, scene, _CARS, int(rng.integers(2**31))))
    paths = GridPaths(scene.clearance)
    pairs = draw_reachability_pairs(recorded, paths, sizes.targets, rng)
    starts, far = far_pairs(recorded, paths, sizes.far, rng)
    frames = np.sort(rng.choice(len(recorded.poses), sizes.anchors, replace=False))
    outcomes = {c: _driven(recorded, pairs, c) for c in {j.controller for j in every.values()}}
    given, found = features(recorded, pairs), {}
    for name, estimator in every.items():
        outcome = outcomes[estimator.controller]
        queries = Queries(recorded, paths, estimator, np.random.default_rng([seed, world]))
        predicted = queries.from_poses(pairs.starts, pairs.targets)
        bound = bounds[estimator.controller].predict_proba(given)[:, 1]
        found[name] = {
            "predicted": predicted,
            "reached": outcome.reached.astype(float),
            "seen": pairs.seen,
            "bound": bound,
            "far": queries.from_frames(starts, far),
            "consecutive": queries.consecutive(sizes.consecutive),
            "edges": queries.edges(frames, sizes.edges),
        }
    return found


@dataclass(frozen=True)
class Queries:
    """One estimator in one world."""

    recorded: RecordedWorld
    paths: GridPaths
    estimator: Estimator
    rng: np.random.Generator

    def from_poses(self, starts: Array, targets: NDArray[np.intp]) -> Array:
        """Probabilities (N,) from poses (N, 3) to frames (N,)."""
        seen = Simulation(self.recorded.scene, starts).observe()
        return self.estimator.predict(self.recorded, seen, targets)

    def from_frames(self, starts: NDArray[np.intp], targets: NDArray[np.intp]) -> Array:
        """Probabilities (N,) from frames (N,) to frames (N,)."""
        return self.estimator.predict(self.recorded, self.recorded.observe(starts), targets)

    def consecutive(self, count: int) -> Array:
        """Whether C reached the next anchor, where RE is above `SURE`; (M,)."""
        pairs = []
        for trajectory in self.rng.permutation(len(self.recorded.trajectories)):
            frames = self.recorded.frames_of(trajectory)
            seen, prepared = (
                self.recorded.observe(frames),
                self.estimator.targets(self.recorded, frames),
            )
            anchors = frames[sparsify(self.estimator.reachability, seen, prepared, SURE)]
            pairs += list(pairwise(anchors))
            if len(pairs) >= 2 * count:
                break
        starts, targets = np.array(pairs).T
        sure = self.from_frames(starts, targets) > SURE
        return self._reached(starts[sure], targets[sure], count)

    def edges(self, frames: NDArray[np.intp], count: int) -> Array:
        """Whether C reached the target, for random pairs of frames (A,) above `SURE`; (M,)."""
        index = np.arange(len(frames))
        rows, columns = (grid.ravel() for grid in np.meshgrid(index, index, indexing="ij"))
        apart = rows != columns
        rows, columns = rows[apart], columns[apart]
        seen, prepared = (
            self.recorded.observe(frames),
            self.estimator.targets(self.recorded, frames),
        )
        sure = self.estimator.query_all(seen, prepared, rows, columns) > SURE
        return self._reached(frames[rows[sure]], frames[columns[sure]], count)

    def _reached(self, starts: NDArray[np.intp], targets: NDArray[np.intp], count: int) -> Array:
        chosen = self.rng.permutation(len(starts))[:count]
        poses = self.recorded.poses[starts[chosen]]
        pairs = reachability_pairs(self.recorded, self.paths, poses, targets[chosen])
        if not len(pairs):
            return np.empty(0)
        outcomes = _driven(self.recorded, pairs, self.estimator.controller, all_of_them=True)
        return outcomes.reached.astype(float)


def far_pairs(
    recorded: RecordedWorld, paths: GridPaths, count: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Frames (N,) and (N,) of far, occluded pairs: over 5 m apart, both overlaps below 0.1."""
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
    pairs: ReachabilityPairs,
    controller: str,
    all_of_them: bool = False,
) -> RolloutOutcomes:
    predictor = WaypointNetwork(CONTROLLERS[controller])
    return roll_out_pairs(
        recorded, pairs, by_waypoints(predictor), predictor.view.camera, all_of_them
    )
