"""The vertices of a map: contextified anchors, kept so that RE can be asked about them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch
from tutorial_lib.topology.query import ask

Numbers = NDArray[np.intp]
"""Of vertices."""
_AT_ONCE = 2_048


class Vertices:
    """Anchors, numbered from 0 in the order in which they came; none is ever renumbered.

    Attributes:
        reachability: RE, which is asked about them.
        observations: what was sensed at each.
        contexts: pictures (2k+1, ...) of each as a target.
        timestamps: (V,) seconds.
        queries: pairs that RE was asked about until now.
    """

    def __init__(self, reachability: Reachability) -> None:
        """None yet."""
        self.reachability = reachability
        self.observations, self.contexts, self._prepared = (
            GrowingBatch(),
            GrowingBatch(),
            GrowingBatch(),
        )
        self.timestamps = np.empty(0)
        self.queries = 0

    def __len__(self) -> int:
        return len(self.timestamps)

    def append(
        self,
        observations: Observation,
        contexts: NDArray,
        timestamps: Array,
        prepared: Any,  # noqa: ANN401 - whatever the estimator made
    ) -> Numbers:
        """Add vertices, and tell their numbers; `prepared` are the contexts as RE wants them."""
        first = len(self)
        self.observations.append(observations)
        self.contexts.append(contexts)
        self._prepared.append(prepared)
        self.timestamps = np.append(self.timestamps, timestamps)
        return np.arange(first, len(self))

    def prepare(self, contexts: NDArray) -> Any:  # noqa: ANN401
        """Targets (N,) as RE wants them, checked: numbers select from them.

        Raises:
            InputError: when the estimator makes something else of them.
        """
        prepared = self.reachability.prepare(contexts)
        kind, count = type(prepared).__name__, len(contexts)
        try:
            made = len(prepared)
            if made == count:
                prepared[np.arange(count)]
        except (TypeError, IndexError, KeyError) as error:
            raise InputError(
                f"reachability: prepared a {kind} of {count} targets, from which an array of "
                "numbers cannot select; give an array"
            ) from error
        if made != count:
            raise InputError(f"reachability: prepared {made} of {count} targets; give all")
        return prepared

    def prepared_targets(self, indices: ArrayLike) -> Any:  # noqa: ANN401
        """Vertices (N,) as targets that RE has prepared."""
        return self._prepared[indices]

    def between(self, sources: ArrayLike, targets: ArrayLike) -> Array:
        """RE (N,) from vertices to vertices."""
        return self.ask(self.observations, sources, self._prepared, targets)

    def into(self, observations: Observation, rows: ArrayLike, targets: ArrayLike) -> Array:
        """RE (N,) from those of the `observations` that `rows` (N,) counts, to vertices (N,)."""
        return self.ask(observations, rows, self._prepared, targets)

    def onward(self, sources: ArrayLike, prepared: Any, rows: ArrayLike) -> Array:  # noqa: ANN401
        """RE (N,) from vertices (N,) to those of the `prepared` targets that `rows` (N,) counts."""
        return self.ask(self.observations, sources, prepared, rows)

    def ask(
        self,
        seen: Any,  # noqa: ANN401
        sources: ArrayLike,
        prepared: Any,  # noqa: ANN401
        targets: ArrayLike,
    ) -> Array:
        """RE (N,) of pairs, source by source, since estimators encode a repeated one once."""
        sources, targets = np.asarray(sources, dtype=int), np.asarray(targets, dtype=int)
        self.queries += len(sources)
        told = np.empty(len(sources))
        order = np.argsort(sources, kind="stable")
        for some in np.array_split(order, 1 + len(order) // _AT_ONCE):
            if some.size:
                told[some] = ask(self.reachability, seen[sources[some]], prepared[targets[some]])
        return told
