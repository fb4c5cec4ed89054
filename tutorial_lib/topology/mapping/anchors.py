"""What is kept of a trajectory: its anchors, with what was seen and in which context."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.sparsify import contextified, sparsify


@dataclass(frozen=True, eq=False)
class Anchors:
    """A anchors of one trajectory, in order (Meng 2020, III-D).

    Attributes:
        observations: (A,) what was sensed at each anchor.
        contexts: (A, 2k+1, ...) pictures of each anchor in its context, to be a target.
        timestamps: (A,) seconds.

    Raises:
        InputError: when there are fewer than two, or not as many of each.
    """

    observations: Observation
    contexts: NDArray
    timestamps: Array

    def __post_init__(self) -> None:
        counts = len(self.observations), len(self.contexts), len(self.timestamps)
        if len(set(counts)) > 1 or counts[0] < 2:
            raise InputError(
                f"anchors: {counts[0]} observations, {counts[1]} contexts, {counts[2]} timestamps; "
                "give as many of each, two at least"
            )

    def __len__(self) -> int:
        return len(self.observations)

    def subset(self, index: NDArray[np.intp]) -> tuple[Observation, NDArray, Array]:
        """Observations, contexts and timestamps of those that an array of indices selects."""
        return self.observations[index], self.contexts[index], self.timestamps[index]


def anchors_of(
    reachability: Reachability,
    observations: Observation,
    pictures: NDArray,
    k: int,
    threshold: float,
    timestamps: Array,
) -> Anchors:
    """Sparsify a trajectory, and keep what a map needs of it.

    Args:
        reachability: RE.
        observations: (T,) of the trajectory.
        pictures: (T, ...) the same frames as the networks look at them.
        k: pictures of context on either side of an anchor.
        threshold: p_sparsify.
        timestamps: (T,) seconds.
    """
    contexts = contextified(pictures, k)
    numbers = sparsify(reachability, observations, reachability.prepare(contexts), threshold)
    return Anchors(observations[numbers], contexts[numbers], timestamps[numbers])
