"""The vertices of a map: contextified anchors, stored so that RE can be queried about them."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch
from tutorial_lib.topology.query import query
from tutorial_lib.validation import batch

Indices = NDArray[np.intp]
"""Of vertices."""
_AT_ONCE = 2_048


class Vertices:
    """Anchors, indexed from 0 in the order in which they were added; an index never changes.

    Attributes:
        reachability: RE.
        observations: at each vertex.
        contexts: images (2k+1, ...) of each as a target.
        timestamps: (V,) seconds.
        queries: pairs that RE was queried about so far.
    """

    def __init__(self, reachability: Reachability) -> None:
        """No vertices."""
        self.reachability = reachability
        self.observations, self.contexts, self._prepared = (GrowingBatch() for _ in range(3))
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
    ) -> Indices:
        """Add vertices, and return their indices; `prepared` are the contexts from `prepare`."""
        first = len(self)
        self.observations.append(observations)
        self.contexts.append(contexts)
        self._prepared.append(prepared)
        self.timestamps = np.append(self.timestamps, timestamps)
        return np.arange(first, len(self))

    def prepare(self, contexts: NDArray) -> Any:  # noqa: ANN401
        """Targets (N,) prepared for RE, and checked.

        Raises:
            InputError: when the estimator returns something that cannot be stored.
        """
        return self.checked(self.reachability.prepare(contexts), len(contexts))

    @staticmethod
    def checked(prepared: Any, count: int) -> Any:  # noqa: ANN401
        """The `prepared` targets, if there are `count` and an array of indices selects from them.

        Raises:
            InputError: otherwise.
        """
        kind = type(prepared).__name__
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
        return batch("prepared", prepared)

    def prepared_targets(self, indices: ArrayLike) -> Any:  # noqa: ANN401
        """The prepared targets of vertices (N,), N > 0, as one batch."""
        return self._prepared[indices]

    def between(self, sources: ArrayLike, targets: ArrayLike) -> Array:
        """RE (N,) from vertices to vertices."""
        return self.query(self.observations, sources, self._prepared, targets)

    def into(self, observations: Observation, rows: ArrayLike, targets: ArrayLike) -> Array:
        """RE (N,) from `observations` at rows (N,), to vertices (N,)."""
        return self.query(observations, rows, self._prepared, targets)

    def onward(self, sources: ArrayLike, prepared: Any, rows: ArrayLike) -> Array:  # noqa: ANN401
        """RE (N,) from vertices (N,) to `prepared` targets at rows (N,)."""
        return self.query(self.observations, sources, prepared, rows)

    def query(
        self,
        seen: Any,  # noqa: ANN401
        sources: ArrayLike,
        prepared: Any,  # noqa: ANN401
        targets: ArrayLike,
    ) -> Array:
        """RE (N,) of pairs, sorted by source, since estimators encode a repeated one once."""
        sources, targets = np.asarray(sources, dtype=int), np.asarray(targets, dtype=int)
        self.queries += len(sources)
        probabilities = np.empty(len(sources))
        order = np.argsort(sources, kind="stable")
        for rows in np.array_split(order, 1 + len(order) // _AT_ONCE):
            if rows.size:
                probabilities[rows] = query(
                    self.reachability, seen[sources[rows]], prepared[targets[rows]]
                )
        return probabilities
