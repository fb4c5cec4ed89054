"""Training data of the multi-task network: groups of panoramas of one place, all pairs of each."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, bearing_of, bin_of
from tutorial_lib.learning.batches import Rows, drawn
from tutorial_lib.learning.exploration_data import VERSION, PanoramaWorld
from tutorial_lib.learning.views import with_channels
from tutorial_lib.se2 import relative, wrap

FARTHEST_PAIR = 12.0
"""Metres between the panoramas of a pair, along the shortest path."""
NEAR = ((3, 4.0), (2, 8.0), (2, FARTHEST_PAIR))
"""Panoramas of a group besides the first, and within how many metres of it they are drawn."""
GROUP = 1 + sum(count for count, _ in NEAR)
VARIED = {"plain": 0.25, "wayfinding": 0.5}
"""Share of groups in other colours, by signs: the colour of a room hints at its kind, that of a
sign is arbitrary. Signs have all hues, and so have recoloured walls: to a network that is trained
on them no hue of the shifted palette is new."""


@dataclass(frozen=True)
class PanoramaBatch(Rows):
    """G groups of P panoramas; labels of pairs are indexed by source, then by goal.

    Attributes:
        images: (G, P, 16, 192, 3) uint8.
        depth: (G, P, 192) metres.
        explorable: (G, P, 12) 1 where a direction is.
        kinds: (G, P, 12) kind of room at a direction's end, see `panorama_network.KINDS`.
        connected: (G, P, P) 1 where the goal is visible from the source and within 3 m.
        direction: (G, P, P) the goal's direction from the source.
        offset: (G, P, P) its bearing from the middle of that direction, in half bins, -1 to 1.
        nearness: (G, P, P) ``max(1 - d / r, 0)`` for its distance d.
        metres: (G, P, P, 12) from each direction's end to the goal; infinite where none is.
        same_room: (G, P, P, 12) 1 where a direction's end is in the goal's room.
        far: (G, P, P) geodesic metres.
        used: (G, P, P) whether a pair is to be learnt from.
        signs: (G,) whether the group is shown with signs that lead.
    """

    images: NDArray[np.uint8]
    depth: NDArray[np.float32]
    explorable: NDArray[np.float32]
    kinds: NDArray[np.int64]
    connected: NDArray[np.float32]
    direction: NDArray[np.int64]
    offset: NDArray[np.float32]
    nearness: NDArray[np.float32]
    metres: NDArray[np.float32]
    same_room: NDArray[np.float32]
    far: NDArray[np.float32]
    used: NDArray[np.bool_]
    signs: NDArray[np.bool_]

    def pairs(self) -> tuple[Tensor, Tensor, Tensor]:
        """Pairs (N,) to learn from: index among all, and of source and goal among panoramas."""
        group, source, goal = torch.from_numpy(self.used).nonzero(as_tuple=True)
        size = self.used.shape[1]
        return (group * size + source) * size + goal, group * size + source, group * size + goal


@dataclass(frozen=True)
class PanoramaSource:
    """Blocks of groups for `training.train`.

    A group's first panorama is anywhere, the others are drawn within 4, 8 and 12 m of it, and every
    ordered pair of them within 12 m is learnt from. Headings were drawn with the poses; turning a
    source by a multiple of 30 degrees would change nothing, since the network is equivariant.

    Attributes:
        recorded: panoramas and labels of all worlds.
        worlds: drawn for a block.
        targets: groups of each world.
        vary: whether groups are mirrored and their colours changed.
        masked: whether scores are learnt from unconnected pairs only, see `masked`.
    """

    recorded: Sequence[PanoramaWorld]
    worlds: int = 16
    targets: int = 8
    vary: bool = True
    masked: bool = False

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        recipe = {
            "labels": VERSION,
            "panoramas": sum(len(world.poses) for world in self.recorded),
            "signs": sorted({signs for world in self.recorded for signs in world.images}),
            "block": [self.worlds, self.targets, GROUP],
            "vary": self.vary,
            "hues": "all, those of the shifted palette included",
        }
        return recipe | ({"scores": "of unconnected pairs"} if self.masked else {})

    def block(self, seed: Sequence[int]) -> PanoramaBatch:
        """The block of that seed: groups of `worlds` worlds, shuffled."""
        return drawn(self.recorded, self.worlds, self._world, np.random.default_rng(seed))

    def _world(self, world: PanoramaWorld, rng: np.random.Generator) -> PanoramaBatch:
        signs = str(rng.choice(sorted(world.images)))
        groups = draw_groups(world.far, self.targets, rng)
        batch = batch_of(world, signs, groups)
        if self.masked:
            batch = masked(batch)
        if not self.vary:
            return batch
        batch = mirrored(batch, rng.random(len(groups)) < 0.5)
        varied = rng.random(len(groups)) < VARIED[signs]
        for group in np.flatnonzero(varied):
            batch.images[group] = recoloured(batch.images[group], rng)
        return batch


def draw_groups(far: NDArray, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Indices (G, GROUP) of panoramas, the first of each anywhere and the others near it.

    Args:
        far: (P, P) metres between them, infinite without a path.
        count: G.
        rng: source of randomness.
    """
    first = rng.integers(len(far), size=count)
    groups = [first]
    taken = np.zeros((count, len(far)), bool)
    taken[np.arange(count), first] = True
    for metres in np.repeat([metres for _, metres in NEAR], [count for count, _ in NEAR]):
        # The largest of random numbers: any of those that may be drawn, or any other if none may.
        luck = rng.random(taken.shape) + (far[first] <= metres) - 2.0 * taken
        groups.append(luck.argmax(axis=1))
        taken[np.arange(count), groups[-1]] = True
    return np.stack(groups, axis=1)


def batch_of(world: PanoramaWorld, signs: str, groups: NDArray[np.intp]) -> PanoramaBatch:
    """Panoramas of a world, with all labels.

    Args:
        world: the panoramas.
        signs: with which they are shown.
        groups: (G, P) indices of panoramas.
    """
    poses = world.poses[groups]
    sources, goals = groups[:, :, None], groups[:, None, :]
    seen = relative(poses[:, :, None], poses[:, None])
    distance = np.linalg.norm(seen[..., :2], axis=-1)
    bearing = np.arctan2(seen[..., 1], seen[..., 0])
    direction = bin_of(bearing)
    far = world.far[sources, goals].astype(np.float32)
    return PanoramaBatch(
        images=world.images[signs][groups],
        depth=world.depth[groups].astype(np.float32),
        explorable=world.explorable[groups].astype(np.float32),
        kinds=world.kinds[groups].astype(np.int64),
        connected=world.connected[sources, goals].astype(np.float32),
        direction=direction.astype(np.int64),
        offset=(wrap(bearing - bearing_of(direction)) * DIRECTIONS / np.pi).astype(np.float32),
        nearness=np.maximum(1.0 - distance / RADIUS, 0.0).astype(np.float32),
        metres=world.metres[sources, goals].astype(np.float32),
        same_room=(world.rooms[sources] == world.room[goals][..., None]).astype(np.float32),
        far=far,
        used=(sources != goals) & (far <= FARTHEST_PAIR),
        signs=np.full(len(groups), signs == "wayfinding"),
    )


def masked(batch: PanoramaBatch) -> PanoramaBatch:
    """The batch without labels of F_S for pairs of one node (Chaplot et al. 2020, appendix B)."""
    metres = np.where(batch.connected[..., None] > 0, np.float32(np.inf), batch.metres)
    return replace(batch, metres=metres)


def mirrored(batch: PanoramaBatch, groups: NDArray[np.bool_]) -> PanoramaBatch:
    """The batch, with `groups` (G,) of it as a mirror would show them: left and right exchanged."""
    turn = (-np.arange(DIRECTIONS)) % DIRECTIONS
    changed = {field.name: getattr(batch, field.name).copy() for field in fields(batch)}
    changed["images"][groups] = batch.images[groups, :, :, ::-1]
    changed["depth"][groups] = batch.depth[groups, :, ::-1]
    for name in ("explorable", "kinds", "metres", "same_room"):
        changed[name][groups] = getattr(batch, name)[groups][..., turn]
    changed["direction"][groups] = turn[batch.direction[groups]]
    changed["offset"][groups] = -batch.offset[groups]
    return PanoramaBatch(**changed)


def recoloured(images: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Images (..., 3) in other colours, all in the same; colours that were alike stay alike.

    Channels are exchanged, and all are inverted or none: both turn or mirror the circle of hues, so
    that hues keep their distances; hues of the standard palette become those of the shifted one.
    Brightness and contrast change a little.
    """
    level = np.linspace(0.0, 1.0, 256)
    gamma, gain = np.exp(rng.normal(0.0, 0.2)), rng.normal(1.0, 0.1, 3)
    tables = np.clip(gain[:, None] * level**gamma + rng.normal(0.0, 0.04), 0.0, 1.0)
    if rng.random() < 0.5:
        tables = 1.0 - tables
    tables = np.rint(255 * tables).astype(np.uint8)
    return with_channels(images, rng.permutation(3), tables)
