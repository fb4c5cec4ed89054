"""A growing row of things that come in batches, such as prepared targets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError


class Shelf:
    """Batches laid end to end; numbers select from all of them.

    A batch is an array, or anything that an array of numbers selects from and whose class has a
    method `joined` that makes one of a list, as observations and encoded targets do. Batches stay
    where they are, so that adding one costs nothing for those before.
    """

    def __init__(self) -> None:
        """Nothing yet."""
        self._batches: list[Any] = []
        self._batch = self._row = np.empty(0, dtype=np.intp)

    def __len__(self) -> int:
        return len(self._batch)

    def append(self, batch: Any) -> None:  # noqa: ANN401
        """Put a batch behind the others."""
        count = len(batch)
        self._batch = np.append(self._batch, np.full(count, len(self._batches)))
        self._row = np.append(self._row, np.arange(count))
        self._batches.append(batch)

    def __getitem__(self, numbers: ArrayLike) -> Any:  # noqa: ANN401
        """What has those numbers (N,), N > 0, as one batch."""
        numbers = np.asarray(numbers)
        which, rows = self._batch[numbers], self._row[numbers]
        order = np.argsort(which, kind="stable")
        bounds = np.flatnonzero(np.diff(which[order])) + 1
        parts = [self._batches[which[some[0]]][rows[some]] for some in np.split(order, bounds)]
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
