"""Training data: blocks of pairs from many worlds, rendered while the network learns."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.driving.data.perturbation import TRAINING_PERTURBATION, Perturbation
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array, relative, to_world
from tutorial_lib.interfaces import Controller, Observation
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.pairs import Pairs, draw_pairs
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.sensors import Laser

STARTS = 4
"""Starts for each target: its pictures are encoded once for all of them."""


@dataclass(frozen=True)
class Batch:
    """G targets with S starts each; N = G * S pairs, those of one target in a row.

    Attributes:
        current: (N, H, W, C) pictures, as the view gives them.
        contexts: (G, 2k+1, H, W, C) pictures.
        waypoint: (N, 2) metres.
        turn: (N, 2) cosine and sine of the heading difference.
        overlap: (N, 2).
        context_poses: (N, 2k+1, 4) x, y, cosine and sine of where each picture was taken.
        action: (N, 2) what the demonstrating driver would do; empty unless asked for.
        reached: (N,) how probable it is that C reaches the target; 0 unless asked for.
        weight: (N,) 1 for pairs that can be learnt from, 0 for others.
        placed: (N,) 1 for pairs of which `context_poses` can be learnt, 0 for others.
    """

    current: NDArray
    contexts: NDArray
    waypoint: NDArray[np.float32]
    turn: NDArray[np.float32]
    overlap: NDArray[np.float32]
    context_poses: NDArray[np.float32]
    action: NDArray[np.float32]
    reached: NDArray[np.float32]
    weight: NDArray[np.float32]
    placed: NDArray[np.float32]

    def tensor(self, name: str) -> Tensor:
        """One of the labels."""
        return torch.from_numpy(getattr(self, name))

    def targets(self, groups: NDArray[np.intp] | slice) -> "Batch":
        """Some of the targets, with all their starts."""
        count, starts = len(self.contexts), len(self.current) // len(self.contexts)
        picked = {"contexts": self.contexts[groups]}
        for field in fields(self):
            if field.name != "contexts":
                values = getattr(self, field.name)
                by_target = values.reshape(count, starts, *values.shape[1:])[groups]
                picked[field.name] = by_target.reshape(len(by_target) * starts, *values.shape[1:])
        return Batch(**picked)


@dataclass(frozen=True)
class Source:
    """Where training data comes from.

    Attributes:
        drives: of all worlds.
        architecture: of the network that is to learn.
        driver: whose actions are to be learnt; needed for the output "action".
        perturbation: of the starts.
        worlds: that a block is made of.
        targets: of each of them.
        starts: of each target.
        close: share of pairs whose target is very near; most mistakes are made there.
        clutter: share of starts before which one or two things stand that were not recorded.
        vary: whether the pictures' looks are changed at random.
    """

    drives: Sequence[RecordedWorld]
    architecture: Architecture
    driver: Controller | None = None
    perturbation: Perturbation = TRAINING_PERTURBATION
    worlds: int = 16
    targets: int = 64
    starts: int = STARTS
    close: float = 0.35
    clutter: float = 0.3
    vary: bool = True

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, so far as it can be told in a few words."""
        return {
            "frames": sum(len(recorded.poses) for recorded in self.drives),
            "perturbation": asdict(self.perturbation),
            "block": [self.worlds, self.targets, self.starts],
            "close": self.close,
            "clutter": self.clutter,
            "vary": self.vary,
        }

    def block(self, seed: Sequence[int]) -> Batch:
        """The block of that seed: targets of `worlds` worlds, well mixed."""
        rng = np.random.default_rng(seed)
        parts = [
            self._world(self.drives[i], rng)
            for i in rng.integers(len(self.drives), size=self.worlds)
        ]
        block = joined(parts)
        return block.targets(rng.permutation(len(block.contexts)))

    def _world(self, recorded: RecordedWorld, rng: np.random.Generator) -> Batch:
        pairs = draw_pairs(
            recorded,
            self.targets,
            self.starts,
            self.architecture.k,
            self.perturbation,
            rng,
            self.close,
        )
        view, count = self.architecture.looks_at, self.targets * self.starts
        discs = clutter(pairs.starts.reshape(-1, 3), self.clutter, rng)
        current = view.render(recorded.scene, pairs.starts, discs)
        contexts = view.render(recorded.scene, pairs.contexts)
        if self.vary:
            current, contexts = view.vary([current, contexts], rng)
        places = posed(pairs.starts[:, :, None], pairs.contexts[:, None])
        labels, valid = pairs.labels, pairs.valid.ravel().astype(np.float32)
        return Batch(
            current.reshape(count, *current.shape[2:]),
            contexts,
            labels.waypoint.astype(np.float32),
            _turn(labels.heading),
            labels.overlap.astype(np.float32),
            places.reshape(count, -1, 4),
            self._actions(recorded, pairs, discs),
            np.zeros_like(valid),
            valid,
            np.ones_like(valid),
        )

    def _actions(self, recorded: RecordedWorld, pairs: Pairs, discs: Discs) -> NDArray[np.float32]:
        """What the driver does at each start, given the waypoint that is to be predicted."""
        poses, frames = pairs.starts.reshape(-1, 3), pairs.sources.ravel()
        if self.driver is None:
            return np.zeros((len(poses), 0), np.float32)
        seen = Observation(
            image=np.zeros((len(poses), 0, 0, 3), np.uint8),
            depth=None,
            laser=Laser().scan(recorded.scene, poses, discs),
            odometry=np.zeros((len(poses), 3)),
            speed=recorded.speed[frames],
            steering=recorded.steering[frames],
        )
        return self.driver.act(seen, pairs.labels.waypoint).astype(np.float32)


def joined(parts: Sequence[Batch]) -> Batch:
    """All targets of several batches in one."""
    return Batch(
        **{
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(Batch)
        }
    )


def posed(origins: Array, poses: Array) -> NDArray[np.float32]:
    """Poses (..., 3) as seen from others: (..., 4) x, y, cosine and sine of the heading."""
    seen = relative(origins, poses)
    return np.concatenate([seen[..., :2], _turn(seen[..., 2])], axis=-1, dtype=np.float32)


def clutter(poses: Array, share: float, rng: np.random.Generator) -> Discs:
    """Round things of any colour before a `share` of the robots at `poses` (N, 3), one or two each.

    A robot is to find its way past people and boxes that were not there when a drive was recorded.
    """
    owners = np.repeat(np.arange(len(poses)), rng.integers(1, 3, len(poses)))
    owners = owners[(rng.random(len(poses)) < share)[owners]].astype(np.int32)
    count = len(owners)
    bearing, distance = rng.uniform(-1.1, 1.1, count), rng.uniform(0.5, 2.5, count)
    ahead = np.stack([distance * np.cos(bearing), distance * np.sin(bearing)], axis=1)
    centres = to_world(poses[owners], ahead)
    circles = np.column_stack([centres, rng.uniform(0.08, 0.25, count)])
    return Discs(circles, owners, rng.uniform(0.0, 255.0, (count, 3)).astype(np.float32))


class Blocks(Protocol):
    """Where batches come from."""

    worlds: int
    targets: int

    @property
    def recipe(self) -> dict[str, Any]:
        """What the blocks depend on, so far as it can be told in a few words."""

    def block(self, seed: Sequence[int]) -> Batch:
        """The block of that seed: `worlds` times `targets` targets, well mixed."""


def batches(source: Blocks, seed: int, first: int, size: int) -> Iterator[Batch]:
    """Batches of `size` targets without end, from the `first` on; the next block is made meanwhile.

    A batch depends on its number and the seed alone, so that training can go on anywhere.

    Raises:
        InputError: when a batch is larger than a block.
    """
    block = source.worlds * source.targets
    if not 1 <= size <= block:
        raise InputError(f"batches: of {size} targets; a block holds {block}: give 1 to {block}")
    each = block // size
    with ThreadPoolExecutor(1) as helper:
        number = first // each
        coming = helper.submit(source.block, [seed, number])
        while True:
            made = coming.result()
            coming = helper.submit(source.block, [seed, number + 1])
            for part in range(first % each if number == first // each else 0, each):
                yield made.targets(slice(part * size, (part + 1) * size))
            number += 1


def _turn(heading: Array) -> NDArray[np.float32]:
    return np.stack([np.cos(heading), np.sin(heading)], axis=-1).astype(np.float32)
