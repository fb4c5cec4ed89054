"""The anchors of a sparsified trajectory, with their observations and contexts."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.sparsify import contextified, sparsify
from tutorial_lib.topology.mapping.vertices import Vertices
from tutorial_lib.topology.query import check_seen
from tutorial_lib.validation import batch, floats, instance, integers, with_methods


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
        check_seen(self.observations)
        batch("contexts", instance("contexts", self.contexts, np.ndarray))
        floats("timestamps", self.timestamps, ("A",))
        counts = len(self.observations), len(self.contexts), len(self.timestamps)
        if len(set(counts)) > 1 or counts[0] < 2:
            raise InputError(
                f"anchors: {counts[0]} observations, {counts[1]} contexts, {counts[2]} timestamps; "
                "give as many of each, two at least"
            )
        if self.prepared is not None:
            Vertices.checked(self.prepared, counts[0])

    def __len__(self) -> int:
        return len(self.observations)

    def subset(self, index: NDArray[np.intp]) -> tuple[Observation, NDArray, Array]:
        """Observations, contexts and timestamps of those that an array of indices selects."""
        index = integers("index", index, ("N",), least=0, most=len(self) - 1)
        return self.observations[index], self.contexts[index], self.timestamps[index]


def anchors_of(
    reachability: Reachability,
    observations: Observation,
    images: NDArray,
    k: int,
    threshold: float,
    timestamps: Array,
) -> Anchors:
    """Sparsify a trajectory, and keep what a map needs.

    Args:
        reachability: RE.
        observations: (T,) of the trajectory.
        images: (T, ...) the same frames in the networks' view.
        k: images of context on either side of an anchor.
        threshold: p_sparsify.
        timestamps: (T,) seconds.
    """
    with_methods("reachability", reachability, "prepare", "probability")
    check_seen(observations)
    frames = len(observations)
    timestamps = floats("timestamps", timestamps, (frames,))
    if len(batch("images", images)) != frames:
        raise InputError(f"images: {len(images)}, observations: {frames}; give as many of each")
    contexts = contextified(images, k)
    prepared = reachability.prepare(contexts)
    kept = sparsify(reachability, observations, prepared, threshold)
    return Anchors(
        observations[kept], contexts[kept], timestamps[kept], prepared[kept], reachability
    )
