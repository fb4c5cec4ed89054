"""Training data of the learned global goal (`ans_like`): half-explored maps with frontiers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

FRONTIERS = 16
"""Of a map, the nearest ones; farther ones are not learnt from."""


@dataclass(frozen=True, eq=False)
class GoalMaps:
    """N half-explored maps.

    Attributes:
        crops: (N, CROP, CROP) uint8, see `interfaces.FrontierScorer`.
        frontiers: (N, FRONTIERS, 3) x and y in the robot's frame, and metres to go.
        remaining: (N, FRONTIERS) metres from a frontier to the goal; infinite for none.
        pairs: (N, 12, HIDDEN) what the multi-task network has of each direction and the goal.
    """

    crops: NDArray[np.uint8]
    frontiers: NDArray[np.float32]
    remaining: NDArray[np.float32]
    pairs: NDArray[np.float16]

    def targets(self, groups: NDArray[np.intp] | slice) -> GoalMaps:
        """A subset of the maps."""
        return GoalMaps(*(getattr(self, field.name)[groups] for field in fields(self)))

    def tensor(self, name: str) -> Tensor:
        """One of the arrays; floating-point ones in single precision."""
        array = torch.from_numpy(getattr(self, name))
        return array.float() if array.is_floating_point() else array

    @classmethod
    def joined(cls, parts: Sequence[GoalMaps]) -> GoalMaps:
        """All maps of the parts."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True)
class GoalMapSource:
    """Blocks of maps for `training.train`: any of all worlds.

    Attributes:
        recorded: the maps.
        worlds: 1, since maps of all worlds are drawn together.
        targets: of a block.
    """

    recorded: GoalMaps
    worlds: int = 1
    targets: int = 512

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        return {"maps": len(self.recorded.crops), "block": [self.worlds, self.targets]}

    def block(self, seed: Sequence[int]) -> GoalMaps:
        """The block of that seed."""
        rng = np.random.default_rng(seed)
        return self.recorded.targets(rng.integers(len(self.recorded.crops), size=self.targets))
