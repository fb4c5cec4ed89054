"""What every agent is: it learns a building from drives, and is sent to goals in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.topology.planner import Goals

Robots = NDArray[np.intp]
"""(M,) numbers of robots."""


@dataclass(frozen=True, eq=False)
class Experience:
    """What a robot sensed on one drive, ten times a second; nothing else is learned from.

    Attributes:
        observations: (T,) in order.
        timestamps: (T,) seconds, rising.

    Raises:
        InputError: when there are fewer than two, or not as many of both.
    """

    observations: Observation
    timestamps: Array

    def __post_init__(self) -> None:
        if not 2 <= len(self.observations) == len(self.timestamps):
            raise InputError(
                f"experience: {len(self.observations)} observations, {len(self.timestamps)} "
                "timestamps; give as many of both, two at least"
            )


@runtime_checkable
class Navigation(Protocol):
    """N robots on their ways.

    Attributes:
        arrived: (N,) who declares to have arrived.
        given_up: (N,) who does not go on.
    """

    arrived: NDArray[np.bool_]
    given_up: NDArray[np.bool_]

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of those robots, whose numbers rise: speed in m/s, and steering in rad."""


@runtime_checkable
class Agent(Protocol):
    """A whole system."""

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Learn a building from drives through it."""

    def start(self, goals: Sequence[Goals]) -> Navigation:
        """Send robots that stand somewhere in that building to one goal each."""
