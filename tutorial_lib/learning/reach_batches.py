"""Training data for reachability: pairs with outcomes, rendered while the network learns."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.reachability_pairs import STARTS
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes
from tutorial_lib.geometry import Array
from tutorial_lib.learning.batches import Batch, drawn, posed
from tutorial_lib.learning.networks import Architecture

NEAR_IN_TIME, FAR_IN_TIME = 20, 100
"""Frames: at most so many apart is close, at least so many is far (SPTM's authors)."""
LONGEST_TIME = 60
"""Frames that ViNG's prediction of time goes up to; here a car drives 3 m meanwhile."""


@dataclass(frozen=True)
class LabelledWorld:
    """A world with labelled pairs.

    Attributes:
        recorded: its trajectories.
        outcomes: of pairs whose targets are frames of those trajectories.
        mined: outcomes of hard negative mining, if any.
    """

    recorded: RecordedWorld
    outcomes: RolloutOutcomes
    mined: RolloutOutcomes | None = None


@dataclass(frozen=True)
class OutcomeSource:
    """Blocks of pairs with their outcomes.

    Attributes:
        labelled: all worlds.
        architecture: of the network to be trained.
        mined: share of the targets that are taken from mined pairs, in worlds that have any.
        worlds: drawn for a block.
        targets: of each world, with `STARTS` starts each.
        vary: whether images are augmented.
        alone: share of the targets whose one image stands for all of their context.
    """

    labelled: Sequence[LabelledWorld]
    architecture: Architecture
    mined: float = 0.1
    worlds: int = 16
    targets: int = 64
    vary: bool = True
    alone: float = 0.0

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        mined = sum(len(world.mined) for world in self.labelled if world.mined is not None)
        return {
            "errands": sum(len(world.outcomes) for world in self.labelled),
            "reached": int(sum(world.outcomes.reached.sum() for world in self.labelled)),
            "mined": [mined, self.mined if mined else 0.0],
            "block": [self.worlds, self.targets, STARTS],
            "vary": self.vary,
            **({"alone": self.alone} if self.alone else {}),
        }

    def block(self, seed: Sequence[int]) -> Batch:
        """The block of that seed: targets of `worlds` worlds, shuffled."""
        return drawn(self.labelled, self.worlds, self._world, np.random.default_rng(seed))

    def _world(self, world: LabelledWorld, rng: np.random.Generator) -> Batch:
        shares = [(world.outcomes, self.targets)]
        if world.mined is not None and len(world.mined):
            from_mined = rng.binomial(self.targets, self.mined)
            shares = [(world.outcomes, self.targets - from_mined), (world.mined, from_mined)]
        return Batch.joined(
            [self._part(world.recorded, *share, rng) for share in shares if share[1]]
        )

    def _part(
        self,
        recorded: RecordedWorld,
        outcomes: RolloutOutcomes,
        targets: int,
        rng: np.random.Generator,
    ) -> Batch:
        pairs = outcomes.pairs
        frames, rows = by_target(pairs.targets, targets, rng)
        label = outcomes.reached[rows]
        return rendered(
            recorded,
            self.architecture,
            pairs.starts[rows].reshape(targets, STARTS, 3),
            frames,
            {"reached": label, "weight": np.ones(len(rows)), "overlap": pairs.overlap[rows]},
            rng if self.vary else None,
            self.alone,
        )


@dataclass(frozen=True)
class ProximitySource:
    """SPTM's blocks: are two images of a trajectory close in time?

    Attributes:
        recorded_worlds: trajectories of all worlds.
        architecture: of the network to be trained.
        worlds, targets: as for `OutcomeSource`.
        near: frames between half of the pairs, at most.
    """

    recorded_worlds: Sequence[RecordedWorld]
    architecture: Architecture
    worlds: int = 16
    targets: int = 64
    near: int = NEAR_IN_TIME

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        frames = sum(len(recorded.poses) for recorded in self.recorded_worlds)
        return {"frames": frames, "apart": [self.near, FAR_IN_TIME]}

    def block(self, seed: Sequence[int]) -> Batch:
        """The block of that seed: targets of `worlds` worlds, shuffled."""
        return drawn(self.recorded_worlds, self.worlds, self._world, np.random.default_rng(seed))

    def _world(self, recorded: RecordedWorld, rng: np.random.Generator) -> Batch:
        frames = rng.integers(len(recorded.poses), size=self.targets)
        target = np.repeat(frames, STARTS)
        apart = rng.integers(-self.near, self.near + 1, size=len(target))
        near = np.clip(target - apart, recorded.first[target], recorded.last[target])
        far = rng.integers(len(recorded.poses), size=len(target))
        close = rng.random(len(target)) < 0.5
        sources = np.where(close, near, far)
        own = recorded.first[sources] == recorded.first[target]
        apart = np.where(own, np.abs(sources - target), FAR_IN_TIME)
        labels = {**self.labels(apart, sources <= target), "overlap": np.zeros(2)}
        starts = recorded.poses[sources].reshape(self.targets, STARTS, 3)
        return rendered(recorded, self.architecture, starts, frames, labels, rng)

    def labels(self, apart: NDArray[np.intp], ahead: NDArray[np.bool_]) -> dict[str, NDArray]:
        """`reached` and `weight` (N,) of pairs so many frames apart, the target ahead or not."""
        del ahead
        decided = (apart <= NEAR_IN_TIME) | (apart >= FAR_IN_TIME)
        return {"reached": apart <= NEAR_IN_TIME, "weight": decided}


@dataclass(frozen=True)
class TimeSource(ProximitySource):
    """ViNG's blocks: how soon does a drive come from one image to another?

    The label is 1 for at once, and 0 from `LONGEST_TIME` on and for images of other trajectories.
    Nothing is known of targets behind, which are left out.
    """

    near: int = LONGEST_TIME

    def labels(self, apart: NDArray[np.intp], ahead: NDArray[np.bool_]) -> dict[str, NDArray]:
        """See `ProximitySource.labels`."""
        soon = np.maximum(1.0 - apart / LONGEST_TIME, 0.0)
        return {"reached": soon, "weight": ahead | (apart >= FAR_IN_TIME)}


def rendered(
    recorded: RecordedWorld,
    architecture: Architecture,
    starts: Array,
    frames: NDArray[np.intp],
    labels: dict[str, NDArray],
    rng: np.random.Generator | None = None,
    alone: float = 0.0,
) -> Batch:
    """Images from `starts` (G, S, 3) and of the targets `frames` (G,), with labels.

    Args:
        recorded: the world.
        architecture: has the view and the size of the context.
        starts: S for each target.
        frames: of the targets.
        labels: `reached` and `weight` (G * S,), `overlap` (G * S, 2).
        rng: augments the images; they are not augmented unless given.
        alone: share of the targets that have no context but their own image, with `rng`.
    """
    view, count = architecture.looks_at, starts.shape[0] * starts.shape[1]
    shown = recorded.context(frames, architecture.k)
    if rng is not None and alone:
        shown = np.where(rng.random((len(frames), 1)) < alone, frames[:, None], shown)
    poses = recorded.poses[shown]
    current, contexts = view.render(recorded.scene, starts), view.render(recorded.scene, poses)
    if rng is not None:
        current, contexts = view.vary([current, contexts], rng)
    overlap = np.broadcast_to(labels["overlap"], (count, 2)).astype(np.float32)
    targets = posed(starts, recorded.poses[frames][:, None]).reshape(count, 4)
    return Batch(
        current=current.reshape(count, *current.shape[2:]),
        contexts=contexts,
        waypoint=targets[:, :2],
        turn=targets[:, 2:],
        overlap=overlap,
        context_poses=posed(starts[:, :, None], poses[:, None]).reshape(count, -1, 4),
        action=np.zeros((count, 0), np.float32),
        reached=labels["reached"].astype(np.float32),
        weight=labels["weight"].astype(np.float32),
        # The relative pose of an image can be predicted only if the views overlap.
        placed=(overlap.min(axis=1) >= 0.1).astype(np.float32),
    )


def by_target(
    targets: NDArray[np.intp], count: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Draw `count` of the targets, and `STARTS` rows of each.

    Args:
        targets: (N,) frame of each row; those of one target in a row.
        count: G.
        rng: draws.

    Returns:
        (G,) frames and (G * STARTS,) rows; a target with fewer rows repeats some of them.
    """
    begins = np.flatnonzero(np.diff(targets, prepend=-1))
    sizes = np.diff(np.append(begins, len(targets)))
    chosen = rng.integers(len(begins), size=count)
    offset = rng.random(count) * sizes[chosen]
    turn = (offset.astype(np.intp)[:, None] + np.arange(STARTS)) % sizes[chosen, None]
    return targets[begins[chosen]], (begins[chosen, None] + turn).ravel()
