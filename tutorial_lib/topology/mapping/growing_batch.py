"""A growing batch, such as the prepared targets of a map."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError


class GrowingBatch:
    """Batches laid end to end; indices select from all of them.

    A batch is an array, or anything that an array of indices selects from and whose class has a
    method `joined` that makes one of a list, as observations and encoded targets do. Batches are
    merged with those before once they are as long, so that there are few and adding one is cheap.
    """

    def __init__(self) -> None:
        """Nothing yet."""
        self._batches: list[Any] = []
        self._first = [0]

    def __len__(self) -> int:
        return self._first[-1]

    def append(self, batch: Any) -> None:  # noqa: ANN401
        """Put a batch behind the others."""
        self._batches.append(batch)
        self._first.append(len(self) + len(batch))
        while len(self._batches) > 1 and len(self._batches[-1]) >= len(self._batches[-2]):
            last = self._batches.pop()
            self._batches[-1] = joined([self._batches[-1], last])
            del self._first[-2]

    def __getitem__(self, indices: ArrayLike) -> Any:  # noqa: ANN401
        """The items at indices (N,), N > 0, as one batch."""
        indices = np.asarray(indices)
        which = np.searchsorted(self._first, indices, side="right") - 1
        order = np.argsort(which, kind="stable")
        bounds = np.flatnonzero(np.diff(which[order])) + 1
        parts = []
        for some in np.split(order, bounds):
            batch = which[some[0]]
            parts.append(self._batches[batch][indices[some] - self._first[batch]])
        return parts[0] if len(parts) == 1 else joined(parts)[np.argsort(order)]


def joined(parts: list[Any]) -> Any:  # noqa: ANN401
    """Batches end to end, as one.

    Raises:
        InputError: when it is not known how.
    """
    kind = type(parts[0])
    if kind is np.ndarray:
        return np.concatenate(parts)
    if not hasattr(kind, "joined"):
        raise InputError(
            f"map: {kind.__name__} has no method `joined`; let `prepare` return an array, or give "
            "the class a method that makes one of a list of them"
        )
    return kind.joined(parts)
