"""Which vertices are worth querying RE about: similar ones, found by comparing embeddings.

RE compares two images in a network. An embedding is computed from each image alone, so those of
all vertices are kept, and all of them are compared with a new one by a product of matrices.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import floats, whole

Embedding = NDArray[np.float32]
"""(N, R, D) embeddings of R parts of an image, or (N, P, R, D) for P images."""
_AT_ONCE = 8  # images; their products with those of a large map fill the memory


def likeness(seen: Embedding, shown: Embedding) -> NDArray[np.float32]:
    """Similarity of N images to each of M targets.

    Two images are alike when each part of either has a counterpart in the other: the sum of the
    means of the best cosines (late interaction). Of a target's images the most similar one counts.

    Args:
        seen: (N, R, D).
        shown: (M, P, R, D), the images of targets in their context.

    Returns:
        (N, M), from -2 to 2.
    """
    seen, shown = _checked("seen", seen, 3), _checked("shown", shown, 4)
    if seen.shape[-1] != shown.shape[-1]:
        raise InputError(
            f"embeddings: seen {seen.shape[-1]} and shown {shown.shape[-1]} dimensions; embed "
            "all with the same network"
        )
    count, images, parts, size = shown.shape
    if not (images and parts and size and seen.shape[1]):
        raise InputError(f"embeddings: seen {seen.shape}, shown {shown.shape}; give some parts")
    laid = np.ascontiguousarray(shown.transpose(3, 1, 2, 0)).reshape(size, -1)
    found = np.empty((len(seen), count), dtype=np.float32)
    for first in range(0, len(seen), _AT_ONCE):
        some = seen[first : first + _AT_ONCE]
        cosines = some.reshape(-1, size) @ laid
        cosines = cosines.reshape(len(some), seen.shape[1], images, parts, count)
        both = cosines.max(axis=3).mean(axis=1) + cosines.max(axis=1).mean(axis=2)
        found[first : first + _AT_ONCE] = both.max(axis=1)
    return found


def most_alike(alike: ArrayLike, count: int) -> NDArray[np.intp]:
    """(N, min(count, M)) indices of the most similar targets, of (N, M); in no order."""
    checked = floats("alike", alike, ("N", "M"), infinite=True)
    # Floats are sorted as they are: in another precision ties would be broken otherwise.
    given = np.asarray(alike)
    sortable = given if given.dtype.kind == "f" else checked
    count = min(whole("count", count, least=0), sortable.shape[1])
    return np.argpartition(-sortable, max(count - 1, 0), axis=1)[:, :count]


class Index:
    """Embeddings of V vertices: as observation (query) and as target (key)."""

    def __init__(self) -> None:
        """No vertices yet."""
        self._seen: list[Embedding] = []
        self._shown: list[Embedding] = []

    def append(self, seen: Embedding, shown: Embedding) -> None:
        """Add N vertices: as observations (N, R, D), and as targets (N, P, R, D)."""
        self._seen.append(_checked("seen", seen, 3))
        self._shown.append(_checked("shown", shown, 4))

    @property
    def seen(self) -> Embedding:
        """(V, R, D)."""
        return self._as_one(self._seen)

    @property
    def shown(self) -> Embedding:
        """(V, P, R, D)."""
        return self._as_one(self._shown)

    @staticmethod
    def _as_one(parts: list[Embedding]) -> Embedding:
        parts[:] = [np.concatenate(parts)] if len(parts) > 1 else parts
        return parts[0]


def _checked(name: str, embeddings: ArrayLike, axes: int) -> Embedding:
    try:
        found = np.asarray(embeddings, dtype=np.float32)
    except (TypeError, ValueError):
        found = np.empty(0, dtype=np.float32)
        embeddings = found
    embeddings = np.empty(0, dtype=np.float32) if np.iscomplexobj(embeddings) else found
    if embeddings.ndim != axes or not np.isfinite(embeddings).all():
        wanted = "(N, R, D)" if axes == 3 else "(N, P, R, D)"
        raise InputError(f"embeddings: {name} {embeddings.shape}; give finite {wanted}")
    return embeddings
