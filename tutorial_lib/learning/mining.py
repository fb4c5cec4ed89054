"""Hard negative mining: query a network about all pairs of a world, and keep confident ones.

A map consists of the pairs with the highest scores among very many, so a network's errors are far
more frequent there than among pairs drawn at random.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs, reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes, roll_out_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.outcome_data import kept_outcomes
from tutorial_lib.learning.policies import by_waypoints, encoded
from tutorial_lib.learning.weights import digest_of, load_card
from tutorial_lib.parallel import for_each
from tutorial_lib.validation import alike, floats, instance, integers
from tutorial_lib.world.simulation import Sensors, Simulation

OWN = 3.0
"""Metres along a trajectory within which pairs are not mined: they are drawn often enough."""
_AT_ONCE = 512


@dataclass(frozen=True)
class HardNegativeMining:
    """How pairs are mined in one world.

    Attributes:
        frames: that are paired with each other.
        pairs: kept at most, besides the far, occluded ones.
        far_occluded: pairs kept at most; they are labelled without a rollout.
        threshold: RE above which a pair is a candidate.
    """

    frames: int = 160
    pairs: int = 100
    far_occluded: int = 400
    threshold: float = 0.5

    def find(
        self,
        reachability: ReachabilityNetwork,
        recorded: RecordedWorld,
        paths: GridPaths,
        rng: np.random.Generator,
    ) -> tuple[ReachabilityPairs, int]:
        """Pairs with RE above the threshold, by target, and the number of pairs queried.

        Of the far, occluded ones those with the highest RE are kept; the others are drawn.
        """
        frames = np.sort(rng.choice(len(recorded.poses), self.frames, replace=False))
        start, target = (pairs.ravel() for pairs in np.meshgrid(frames, frames, indexing="ij"))
        own = recorded.first[start] == recorded.first[target]
        apart = ~own | (np.abs(recorded.arc[start] - recorded.arc[target]) > OWN)
        start, target = start[apart], target[apart]
        logits = all_logits(reachability, recorded, recorded.poses[start], target)
        probability = reachability.calibration(logits)
        high = np.flatnonzero(probability > self.threshold)
        high = high[np.argsort(-probability[high], kind="stable")]
        angle = reachability.view.camera.field_of_view
        starts = recorded.poses[start[high]]
        found = reachability_pairs(recorded, paths, starts, target[high], angle)
        far = np.flatnonzero(found.far_and_occluded)[: self.far_occluded]
        others = rng.permutation(np.flatnonzero(~found.far_and_occluded))[: self.pairs]
        rows = np.concatenate([far, others])
        rows = rows[np.argsort(found.targets[rows], kind="stable")]
        return found.subset(rows), len(start)


def all_logits(
    reachability: ReachabilityNetwork,
    recorded: RecordedWorld,
    starts: Array,
    targets: NDArray[np.intp],
) -> Array:
    """Uncalibrated logits (N,) from poses `starts` (N, 3) to recorded frames `targets` (N,).

    Each distinct pose and target is encoded once.
    """
    instance("reachability", reachability, ReachabilityNetwork)
    instance("recorded", recorded, RecordedWorld)
    starts = floats("starts", starts, ("N", 3), empty=False)
    targets = integers("targets", targets, ("N",), least=0, most=len(recorded.poses) - 1)
    alike(starts=starts, targets=targets)
    poses, which = np.unique(starts, axis=0, return_inverse=True)
    camera = reachability.view.camera
    try:
        sensors = Sensors(camera=camera, with_depth=True)
        seen = Simulation(recorded.scene, poses, sensors=sensors).observe()
    except InputError as error:
        raise InputError(f"starts: {error}") from error
    frames, shown = np.unique(targets, return_inverse=True)
    prepared = encoded(reachability, recorded, frames)
    current = reachability.encode(seen)
    logits = [
        reachability.compare(current[which[rows]], prepared[shown[rows]])[:, 0]
        for rows in np.array_split(np.arange(len(starts)), 1 + len(starts) // _AT_ONCE)
    ]
    return np.concatenate(logits)


def mined_outcomes(
    reachability: ReachabilityNetwork,
    controller: str,
    recorded_worlds: list[RecordedWorld],
    work: Path,
    mining: HardNegativeMining | None = None,
    jobs: int = 2,
) -> list[RolloutOutcomes]:
    """Mine pairs in each world and roll them out; existing files are kept.

    Args:
        reachability: the network whose errors are sought.
        controller: name of the weights of C_WP.
        recorded_worlds: their trajectories.
        work: folder for the outcomes.
        mining: how pairs are mined.
        jobs: processes.
    """
    mining = HardNegativeMining() if mining is None else mining
    folder = work / "mined" / controller
    make_folder(folder)
    calibrated = digest_of(reachability.network), reachability.calibration
    # The words of the first version, so that files recorded with it still load.
    sizes = (
        f"HardNegativeMining(frames={mining.frames}, pairs={mining.pairs}, "
        f"hopeless={mining.far_occluded}, sure={mining.threshold})"
    )
    recipe = f"{calibrated} {load_card(controller).sha256[:16]} {sizes}"
    items = [
        (folder / f"{recorded.trajectories[0].world.replace('/', '-')}.npz", recorded)
        for recorded in recorded_worlds
    ]
    arguments = (recipe, reachability, controller, mining)
    return for_each(_mined, items, *arguments, label="hard negatives", jobs=jobs)


def _mined(
    item: tuple[Path, RecordedWorld],
    recipe: str,
    reachability: ReachabilityNetwork,
    controller: str,
    mining: HardNegativeMining,
) -> RolloutOutcomes:
    path, recorded = item

    def record() -> RolloutOutcomes:
        paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng(len(recorded.poses))
        pairs, _ = mining.find(reachability, recorded, paths, rng)
        predictor = WaypointNetwork(controller)
        return roll_out_pairs(recorded, pairs, by_waypoints(predictor), predictor.view.camera)

    return kept_outcomes(path, recipe, record)
