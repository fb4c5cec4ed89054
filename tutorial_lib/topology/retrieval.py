"""Which vertices are worth asking RE about: those that look alike, by cheap comparison.

RE compares two pictures in a network. An embedding is computed from each picture alone, so those of
all vertices are kept, and all of them are compared with a new one by products of matrices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array


class Index:
    """Embeddings (V, R, D) of vertices: R directions of what is seen in parts of the picture.

    Two pictures are alike when each part of either has a counterpart in the other: the mean over
    its parts of the best cosine (late interaction).
    """

    def __init__(self) -> None:
        """No vertices yet."""
        self._parts = np.empty((0, 0, 0), dtype=np.float32)
        self._used = 0

    def __len__(self) -> int:
        return self._used

    def append(self, embeddings: NDArray) -> None:
        """Add those (N, R, D) of new vertices.

        Raises:
            InputError: when they have another size than those before, or are not finite.
        """
        embeddings = _checked(embeddings)
        if self._used and embeddings.shape[1:] != self._parts.shape[1:]:
            raise InputError(
                f"embeddings: {embeddings.shape[1:]} where the map has {self._parts.shape[1:]}; "
                "embed all with the same network"
            )
        needed = self._used + len(embeddings)
        if needed > len(self._parts):
            grown = np.empty((max(needed, 2 * len(self._parts)), *embeddings.shape[1:]), np.float32)
            grown[: self._used] = self._parts[: self._used]
            self._parts = grown
        self._parts[self._used : needed] = embeddings
        self._used = needed

    def likeness(self, embeddings: NDArray) -> Array:
        """(N, V) how much N pictures, embedded as (N, R, D), look like the vertices."""
        asked, kept = _checked(embeddings), self._parts[: self._used]
        flat = kept.reshape(-1, kept.shape[-1])
        found = np.empty((len(asked), self._used))
        for row, one in enumerate(asked):
            cosine = (one @ flat.T).reshape(len(one), self._used, -1)  # (R, V, R)
            found[row] = cosine.max(axis=2).mean(axis=0) + cosine.max(axis=0).mean(axis=1)
        return found / 2

    def propose(self, embeddings: NDArray, count: int) -> NDArray[np.intp]:
        """(N, min(count, V)) numbers of the vertices that look most alike."""
        count = min(count, self._used)
        likeness = self.likeness(embeddings)
        return np.argpartition(-likeness, max(count - 1, 0), axis=1)[:, :count]


def _checked(embeddings: NDArray) -> NDArray[np.float32]:
    embeddings = np.asarray(embeddings, dtype=np.float32)
    embeddings = embeddings[:, None] if embeddings.ndim == 2 else embeddings
    if embeddings.ndim != 3 or not np.isfinite(embeddings).all():
        raise InputError(f"embeddings: {embeddings.shape}; give finite (N, R, D) or (N, D)")
    return embeddings
