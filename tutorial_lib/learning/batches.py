"""Training data: blocks of pairs from many worlds, rendered while the network learns."""

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from typing import Any, Protocol, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.driving.data.perturbation import TRAINING_PERTURBATION, Perturbation
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Controller, Observation
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.waypoint_pairs import WaypointPairs, draw_waypoint_pairs
from tutorial_lib.se2 import Array, relative, to_world
from tutorial_lib.validation import instance, instances, integers, number, whole, with_methods
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.sensors import Laser

STARTS = 4
"""Starts for each target: its images are encoded once for all of them."""
Made = TypeVar("Made", bound="Rows")
One = TypeVar("One")


@dataclass(frozen=True, eq=False)  # a class without fields would equal all of its kind
class Rows:
    """Arrays, fields of a dataclass, whose rows belong together."""

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))

    def tensor(self, name: str) -> Tensor:
        """One of the arrays; floating-point ones in single precision."""
        array = torch.from_numpy(getattr(self, name))
        return array.float() if array.is_floating_point() else array

    def targets(self: Made, groups: NDArray[np.intp] | slice) -> Made:
        """A subset of the rows."""
        return type(self)(*(getattr(self, field.name)[groups] for field in fields(self)))

    @classmethod
    def joined(cls: type[Made], parts: Sequence[Made]) -> Made:
        """All rows of the parts."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def drawn(
    recorded: Sequence[One],
    worlds: int,
    part: Callable[[One, np.random.Generator], Made],
    rng: np.random.Generator,
) -> Made:
    """A block: a `part` of each of so many of what is `recorded`, drawn and shuffled."""
    parts = [part(recorded[i], rng) for i in rng.integers(len(recorded), size=worlds)]
    block = parts[0].joined(parts)
    return block.targets(rng.permutation(len(block)))


@dataclass(frozen=True)
class Batch(Rows):
    """G targets with S starts each; N = G * S pairs, those of one target in a row.

    Attributes:
        current: (N, H, W, C) images, as the view returns them.
        contexts: (G, 2k+1, H, W, C) images of the targets.
        waypoint: (N, 2) metres.
        turn: (N, 2) cosine and sine of the heading difference.
        overlap: (N, 2).
        context_poses: (N, 2k+1, 4) x, y, cosine and sine of the pose of each context image.
        action: (N, 2) of the demonstrator; empty for other outputs.
        reached: (N,) probability that C reaches the target; 0 for other outputs.
        weight: (N,) 1 for pairs with a label, 0 for others.
        placed: (N,) 1 for pairs with a label for `context_poses`, 0 for others.
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

    def __len__(self) -> int:
        return len(self.contexts)

    def targets(self, groups: NDArray[np.intp] | slice) -> "Batch":
        """A subset of the targets, with all their starts."""
        count, starts = len(self.contexts), len(self.current) // len(self.contexts)
        picked: dict[str, NDArray] = {"contexts": self.contexts[groups]}
        for field in fields(self):
            if field.name != "contexts":
                values = getattr(self, field.name)
                by_target = values.reshape(count, starts, *values.shape[1:])[groups]
                picked[field.name] = by_target.reshape(len(by_target) * starts, *values.shape[1:])
        return Batch(**picked)


@dataclass(frozen=True)
class Source:
    """Blocks of training data for waypoints or actions.

    Attributes:
        recorded_worlds: trajectories of all worlds.
        architecture: of the network to be trained.
        demonstrator: whose actions are labels; needed for the output "action".
        perturbation: of the starts.
        worlds: drawn for a block.
        targets: of each world.
        starts: of each target.
        close: share of pairs whose target is very near, where most mistakes are made.
        clutter: share of starts with one or two unrecorded obstacles in view.
        vary: whether images are augmented.
    """

    recorded_worlds: Sequence[RecordedWorld]
    architecture: Architecture
    demonstrator: Controller | None = None
    perturbation: Perturbation = TRAINING_PERTURBATION
    worlds: int = 16
    targets: int = 64
    starts: int = STARTS
    close: float = 0.35
    clutter: float = 0.3
    vary: bool = True

    def __post_init__(self) -> None:
        instances("recorded_worlds", self.recorded_worlds, RecordedWorld, empty=False)
        instance("architecture", self.architecture, Architecture)
        if self.demonstrator is not None:
            with_methods("demonstrator", self.demonstrator, "act")
        instance("perturbation", self.perturbation, Perturbation)
        for name in ("worlds", "targets", "starts"):
            whole(name, getattr(self, name), least=1)
        for name in ("close", "clutter"):
            number(name, getattr(self, name), least=0.0, most=1.0)
        instance("vary", self.vary, bool)

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        return {
            "frames": sum(len(recorded.poses) for recorded in self.recorded_worlds),
            "perturbation": asdict(self.perturbation),
            "block": [self.worlds, self.targets, self.starts],
            "close": self.close,
            "clutter": self.clutter,
            "vary": self.vary,
        }

    def block(self, seed: Sequence[int]) -> Batch:
        """The block of that seed: targets of `worlds` worlds, shuffled."""
        rng = np.random.default_rng(integers("seed", seed, ("N",), least=0).tolist())
        return drawn(self.recorded_worlds, self.worlds, self._world, rng)

    def _world(self, recorded: RecordedWorld, rng: np.random.Generator) -> Batch:
        view = self.architecture.looks_at
        pairs = draw_waypoint_pairs(
            recorded,
            self.targets,
            self.starts,
            self.architecture.k,
            self.perturbation,
            rng,
            self.close,
            view.camera.field_of_view,
        )
        count = self.targets * self.starts
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

    def _actions(
        self, recorded: RecordedWorld, pairs: WaypointPairs, discs: Discs
    ) -> NDArray[np.float32]:
        """The demonstrator's action at each start, given the true waypoint."""
        poses, frames = pairs.starts.reshape(-1, 3), pairs.sources.ravel()
        if self.demonstrator is None:
            return np.zeros((len(poses), 0), np.float32)
        seen = Observation(
            image=np.zeros((len(poses), 0, 0, 3), np.uint8),
            depth=None,
            laser=Laser().scan(recorded.scene, poses, discs),
            odometry=np.zeros((len(poses), 3)),
            speed=recorded.speed[frames],
            steering=recorded.steering[frames],
        )
        return self.demonstrator.act(seen, pairs.labels.waypoint).astype(np.float32)


def posed(origins: Array, poses: Array) -> NDArray[np.float32]:
    """Poses (..., 3) in the frames of `origins`: (..., 4) x, y, cosine and sine of the heading."""
    seen = relative(origins, poses)
    return np.concatenate([seen[..., :2], _turn(seen[..., 2])], axis=-1, dtype=np.float32)


def clutter(poses: Array, share: float, rng: np.random.Generator) -> Discs:
    """One or two discs of random colour ahead of a `share` of the robots at `poses` (N, 3).

    A robot has to get past people and boxes that were not there during the recording.
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
    """A source of training blocks."""

    @property
    def worlds(self) -> int:
        """Drawn for a block."""

    @property
    def targets(self) -> int:
        """Of each world."""

    @property
    def recipe(self) -> dict[str, Any]:
        """What the blocks depend on, in brief."""

    def block(self, seed: Sequence[int]) -> Rows:
        """The block of that seed: `worlds` times `targets` targets, shuffled."""


def batches(source: Blocks, seed: int, first: int, size: int) -> Generator[Any, None, None]:
    """Batches of `size` targets without end, from the `first` on; the next block is prefetched.

    A batch depends on its index and the seed alone, so that training can resume anywhere.

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
