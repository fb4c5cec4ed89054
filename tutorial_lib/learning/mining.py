"""Hard negatives: pairs of which a network is sure, found by asking it about all pairs of a world.

A map is made of the pairs with the highest scores among very many, so the mistakes of a network are
far more frequent there than among pairs drawn at random.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs, reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes, roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.outcome_data import kept_outcomes
from tutorial_lib.learning.policies import by_waypoints, encoded
from tutorial_lib.learning.weights import digest_of, load_card
from tutorial_lib.parallel import for_each
from tutorial_lib.world.simulation import Sensors, Simulation

OWN = 3.0
"""Metres along one drive within which pairs are not searched: they are drawn often enough."""
_AT_ONCE = 512


@dataclass(frozen=True)
class Search:
    """How pairs are searched in one world.

    Attributes:
        anchors: frames that are paired with each other.
        pairs: that are kept at most, besides those that are hopeless.
        hopeless: that are kept at most; nobody need drive to know how they end.
        sure: probability from which on a pair is one to look at.
    """

    anchors: int = 160
    pairs: int = 100
    hopeless: int = 400
    sure: float = 0.5

    def find(
        self,
        reachability: ReachabilityNetwork,
        recorded: RecordedWorld,
        paths: GridPaths,
        rng: np.random.Generator,
    ) -> tuple[ReachabilityPairs, int]:
        """Pairs of which the network is sure, by target, and how many it was asked about.

        If there are too many hopeless ones, the surest are kept; of the others, some are drawn.
        """
        frames = np.sort(rng.choice(len(recorded.poses), self.anchors, replace=False))
        start, target = (pairs.ravel() for pairs in np.meshgrid(frames, frames, indexing="ij"))
        own = recorded.first[start] == recorded.first[target]
        apart = ~own | (np.abs(recorded.arc[start] - recorded.arc[target]) > OWN)
        start, target = start[apart], target[apart]
        logits = all_logits(reachability, recorded, recorded.poses[start], target)
        probability = reachability.calibration(logits)
        sure = np.flatnonzero(probability > self.sure)
        sure = sure[np.argsort(-probability[sure], kind="stable")]
        found = reachability_pairs(recorded, paths, recorded.poses[start[sure]], target[sure])
        hopeless = np.flatnonzero(found.hopeless)[: self.hopeless]
        others = rng.permutation(np.flatnonzero(~found.hopeless))[: self.pairs]
        rows = np.concatenate([hopeless, others])
        rows = rows[np.argsort(found.targets[rows], kind="stable")]
        return found.some(rows), len(start)


def all_logits(
    reachability: ReachabilityNetwork,
    recorded: RecordedWorld,
    starts: Array,
    targets: NDArray[np.intp],
) -> Array:
    """Logits (N,), not calibrated, from poses `starts` (N, 3) to recorded frames `targets` (N,).

    What is seen from a pose, and each target, is encoded once.
    """
    poses, which = np.unique(starts, axis=0, return_inverse=True)
    camera = reachability.view.camera
    seen = Simulation(recorded.scene, poses, sensors=Sensors(camera=camera)).observe()
    frames, shown = np.unique(targets, return_inverse=True)
    prepared = encoded(reachability, recorded, frames)
    current = reachability.encode(seen)
    logits = [
        reachability.compare(current[which[some]], prepared[shown[some]])[:, 0]
        for some in np.array_split(np.arange(len(starts)), 1 + len(starts) // _AT_ONCE)
    ]
    return np.concatenate(logits)


def mined_outcomes(
    reachability: ReachabilityNetwork,
    controller: str,
    drives: list[RecordedWorld],
    work: Path,
    search: Search | None = None,
    jobs: int = 2,
) -> list[RolloutOutcomes]:
    """Search each world, and send the controller on what was found; files that are there are kept.

    Args:
        reachability: the network whose mistakes are wanted.
        controller: name of the weights of C_WP.
        drives: of the worlds.
        work: folder for the outcomes.
        search: how pairs are searched.
        jobs: processes.
    """
    search = Search() if search is None else search
    folder = work / "mined" / controller
    folder.mkdir(parents=True, exist_ok=True)
    calibrated = digest_of(reachability.network), reachability.calibration
    recipe = f"{calibrated} {load_card(controller).sha256[:16]} {search}"
    items = [
        (folder / f"{recorded.trajectories[0].world.replace('/', '-')}.npz", recorded)
        for recorded in drives
    ]
    arguments = (recipe, reachability, controller, search)
    return for_each(_mined, items, *arguments, label="hard negatives", jobs=jobs)


def _mined(
    item: tuple[Path, RecordedWorld],
    recipe: str,
    reachability: ReachabilityNetwork,
    controller: str,
    search: Search,
) -> RolloutOutcomes:
    path, recorded = item

    def drive() -> RolloutOutcomes:
        paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng(len(recorded.poses))
        errands, _ = search.find(reachability, recorded, paths, rng)
        predictor = WaypointNetwork(controller)
        return roll_out_pairs(recorded, errands, by_waypoints(predictor), predictor.view.camera)

    return kept_outcomes(path, recipe, drive)
