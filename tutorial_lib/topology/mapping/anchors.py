"""The anchors of a sparsified trajectory, with their observations and contexts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.sparsify import contextified, sparsify

SPACING = 20.0
"""Frames from anchor to anchor that are near enough, on average: SPTM keeps every 20th frame."""


@dataclass(frozen=True, eq=False)
class Anchors:
    """A anchors of one trajectory, in order (Meng 2020, III-D).

    Attributes:
        observations: (A,) at each anchor.
        contexts: (A, 2k+1, ...) images of each anchor in its context, as a target.
        timestamps: (A,) seconds.
        prepared: (A,) the contexts as prepared for sparsifying, so that a map does not do it again.
        prepared_by: the estimator that did.

    Raises:
        InputError: when there are fewer than two, or not as many of each.
    """

    observations: Observation
    contexts: NDArray
    timestamps: Array
    prepared: Any = None
    prepared_by: Reachability | None = None

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
    images: NDArray,
    k: int,
    threshold: float,
    timestamps: Array,
    lenient: Sequence[float] = (),
) -> Anchors:
    """Sparsify a trajectory, and keep what a map needs.

    In open space RE is hardly ever as sure as elsewhere, however near the target, and the anchors
    lie too close to be of use. Such a trajectory is sparsified by the first of the `lenient`
    thresholds that keeps no more than every 20th of its frames (not in the paper).

    Args:
        reachability: RE.
        observations: (T,) of the trajectory.
        images: (T, ...) the same frames in the networks' view.
        k: images of context on either side of an anchor.
        threshold: p_sparsify.
        timestamps: (T,) seconds.
        lenient: thresholds below p_sparsify, falling; the last one is taken when none will do.
    """
    contexts = contextified(images, k)
    prepared = reachability.prepare(contexts)
    for p_sparsify in (threshold, *lenient):
        kept = sparsify(reachability, observations, prepared, p_sparsify)
        if len(observations) >= SPACING * (len(kept) - 1):
            break
    return Anchors(
        observations[kept], contexts[kept], timestamps[kept], prepared[kept], reachability
    )
