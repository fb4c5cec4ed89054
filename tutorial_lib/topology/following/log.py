"""What went on while paths were followed: kept step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array

# Array fields: the type, and how much of the shape (T, N, 2) they have.
_COLUMNS: dict[str, tuple[type, int]] = {
    "state": (np.int8, 2),
    "active": (np.int32, 2),
    "visited": (np.int32, 2),
    "probability": (np.float64, 2),
    "overlap": (np.float64, 2),
    "waypoint": (np.float64, 3),
}


@dataclass(frozen=True, eq=False)
class FollowerLog:
    """T steps of N robots; row t is how things stood when the action of step t was chosen.

    Attributes:
        state: (T, N) int8, a `State` each.
        active: (T, N) int32, place along the path of the active anchor, -1 while searching.
        visited: (T, N) int32, place of the anchor that was last visited, -1 for none.
        probability: (T, N) RE of the anchor that was active when the step began; not a number
            where it is not queried.
        overlap: (T, N) mean predicted overlap with that anchor; not a number outside Follow.
        waypoint: (T, N, 2) metres in the frame of the robot's odometry; not a number before the
            first.
    """

    state: NDArray[np.int8]
    active: NDArray[np.int32]
    visited: NDArray[np.int32]
    probability: Array
    overlap: Array
    waypoint: Array

    def __len__(self) -> int:
        return len(self.state)

    @classmethod
    def of(cls, steps: Sequence[tuple[NDArray[Any], ...]], robots: int) -> FollowerLog:
        """Put T steps of so many robots together, each a tuple of the columns' rows."""
        columns = []
        for number, (kind, axes) in enumerate(_COLUMNS.values()):
            none = np.empty((0, *(robots, 2)[: axes - 1]), dtype=kind)
            rows = [np.asarray(step[number], dtype=kind)[None] for step in steps]
            columns.append(np.concatenate([none, *rows]))
        return cls(*columns)
