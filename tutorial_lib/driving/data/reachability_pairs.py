"""Pairs that reachability is learnt from: a start anywhere, and a frame of a trajectory as target.

Meng 2020 (III-C, IV) draws both from one trajectory with probability 0.6 and from two otherwise.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.perturbation import TRAINING_PERTURBATION, Perturbation, perturbed
from tutorial_lib.driving.data.recorded_world import MOST_PAIRS, RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import time_limit
from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, floats, instance, integers, whole
from tutorial_lib.world.visibility import FIELD_OF_VIEW, mutual_overlap

SAME, OTHER = 3, 2
"""Starts of each target on its own trajectory, and on others."""
STARTS = SAME + OTHER
SEEN = 0.1
"""Overlap of both views from which on the outcome of a pair can be predicted from them."""
FAR = 5.0
"""Metres of geodesic beyond which a pair without overlap is not rolled out."""
_AS_RECORDED = 0.35  # share of unperturbed starts: a map queries such pairs
_ALONG, _LONG = (-1.0, 4.0), (-6.0, 20.0)  # metres along the trajectory from start to target
_LONG_SHARE = 0.35
_NEAR = 4.0  # metres between start and target of near pairs on two trajectories
_TRIES = 24  # candidates among which a near or a similar place is sought


@dataclass(frozen=True)
class ReachabilityPairs:
    """N starts and targets in one world.

    Attributes:
        starts: (N, 3) poses.
        targets: (N,) frames of the recorded trajectories.
        overlap: (N, 2) share of the first view in the target's, and vice versa.
        geodesic: (N,) metres; inf where there is no path.
    """

    starts: Array
    targets: NDArray[np.intp]
    overlap: Array
    geodesic: Array

    def __len__(self) -> int:
        return len(self.starts)

    def subset(self, index: NDArray) -> "ReachabilityPairs":
        """Those that an array of indices or a mask selects."""
        return ReachabilityPairs(*(getattr(self, field.name)[index] for field in fields(self)))

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(N,) whether the views overlap enough to predict the outcome from them."""
        return np.all(self.overlap >= SEEN, axis=1)

    @property
    def far_and_occluded(self) -> NDArray[np.bool_]:
        """(N,) whether the target is far away and shares nothing with the first view."""
        return (self.geodesic > FAR) & (self.overlap < SEEN).all(axis=1)

    @property
    def limit(self) -> Array:
        """(N,) time limit in seconds."""
        return time_limit(self.geodesic)


def draw_reachability_pairs(
    recorded: RecordedWorld,
    paths: GridPaths,
    targets: int,
    rng: np.random.Generator,
    perturbation: Perturbation = TRAINING_PERTURBATION,
    field_of_view: float = FIELD_OF_VIEW,
) -> ReachabilityPairs:
    """Draw pairs whose targets are random frames of recorded trajectories.

    Of the `STARTS` starts of each target three are on its own trajectory, mostly within a few
    metres. One is on another trajectory near by, and one anywhere: half of those in a room of the
    same type. Starts are perturbed, but for a third of them.

    Args:
        recorded: the trajectories of one world.
        paths: its geodesics.
        targets: G, of which each has `STARTS` starts in a row.
        rng: draws everything.
        perturbation: of the starts.
        field_of_view: radians of the camera, for the overlaps.

    Returns:
        Fewer than G * `STARTS`: those with no room to start in are left out.
    """
    instance("recorded", recorded, RecordedWorld)
    instance("paths", paths, GridPaths)
    instance("rng", rng, np.random.Generator)
    instance("perturbation", perturbation, Perturbation)
    targets = whole("targets", targets, least=0, most=MOST_PAIRS)
    frames = rng.integers(len(recorded.poses), size=targets)
    sources = np.empty((targets, STARTS), dtype=np.intp)
    along = rng.uniform(*_ALONG, size=(targets, SAME))
    long = rng.random((targets, SAME)) < _LONG_SHARE
    along = np.where(long, rng.uniform(*_LONG, size=(targets, SAME)), along)
    own = np.repeat(frames, SAME)
    sources[:, :SAME] = recorded.frame_at(own, -along.ravel()).reshape(targets, SAME)
    sources[:, SAME:] = _elsewhere(recorded, frames, rng)
    starts, found = perturbed(recorded.scene, recorded.poses[sources.ravel()], perturbation, rng)
    kept = rng.random(len(starts)) < _AS_RECORDED
    starts[kept] = recorded.poses[sources.ravel()[kept]]
    ready = np.flatnonzero(found | kept)
    goals = np.repeat(frames, STARTS)[ready]
    return reachability_pairs(recorded, paths, starts[ready], goals, field_of_view)


def reachability_pairs(
    recorded: RecordedWorld,
    paths: GridPaths,
    starts: Array,
    targets: NDArray[np.intp],
    field_of_view: float = FIELD_OF_VIEW,
) -> ReachabilityPairs:
    """The pairs from `starts` (N, 3) to frames `targets` (N,) that a path connects, measured.

    Views overlap as those of a camera do whose `field_of_view` is so many radians.
    """
    most = len(instance("recorded", recorded, RecordedWorld).poses) - 1
    targets = integers("targets", targets, ("N",), least=0, most=most)
    starts = floats("starts", starts, ("N", 3))
    alike(starts=starts, targets=targets)
    instance("paths", paths, GridPaths)
    goals = recorded.poses[targets]
    overlap = mutual_overlap(recorded.scene.caster, starts, goals, field_of_view)
    geodesic = paths.between(starts[:, :2], goals[:, :2])
    return ReachabilityPairs(starts, targets, overlap, geodesic).subset(np.isfinite(geodesic))


def _elsewhere(
    recorded: RecordedWorld, frames: NDArray[np.intp], rng: np.random.Generator
) -> NDArray[np.intp]:
    """(G, 2) frames of other trajectories: one near each of `frames` (G,), and one anywhere."""
    count = len(recorded.poses)
    tried = rng.integers(count, size=(2, len(frames), _TRIES))
    other = recorded.first[tried] != recorded.first[frames][:, None]
    gap = recorded.poses[tried, :2] - recorded.poses[frames, None, :2]
    near = other[0] & (np.linalg.norm(gap[0], axis=-1) < _NEAR)
    kind = _kinds(recorded)
    alike = other[1] & (kind[tried[1]] == kind[frames][:, None])
    alike &= np.linalg.norm(gap[1], axis=-1) > _NEAR
    alike &= rng.random((len(frames), 1)) < 0.5
    # The first that fits, or else the first on another trajectory.
    chosen = np.where(near.any(axis=1), near.argmax(axis=1), other[0].argmax(axis=1))
    anywhere = np.where(alike.any(axis=1), alike.argmax(axis=1), other[1].argmax(axis=1))
    rows = np.arange(len(frames))
    return np.stack([tried[0][rows, chosen], tried[1][rows, anywhere]], axis=1)


def _kinds(recorded: RecordedWorld) -> NDArray[np.intp]:
    """(F,) index of the type of the room in which each frame was recorded."""
    kinds: dict[str, int] = {}
    kind = np.full(len(recorded.poses), -1)
    for room in recorded.scene.plan.rooms:
        inside = room.contains(recorded.poses[:, :2])
        kind[inside] = kinds.setdefault(room.kind, len(kinds))
    return kind
