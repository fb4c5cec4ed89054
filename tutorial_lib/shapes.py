"""Shapes of arrays that compiled code reads together: it would read on beyond the end of one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError

Expected = tuple["int | str", ...]


def fit_together(**arrays: tuple[ArrayLike, Expected]) -> None:
    """Check that arrays have the shapes that a kernel counts on.

    Args:
        arrays: by name, each with its shape, in which a name stands for the same length wherever it
            occurs; the first array that has it says how long.

    Raises:
        InputError: naming the first array that does not fit.

    >>> fit_together(lasers=(np.zeros((2, 96)), ("N", "B")), angles=(np.zeros(96), ("B",)))
    >>> fit_together(robots=([0, 1], ("M",)), odometry=(np.zeros((1, 3)), ("M", 3)))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: odometry: shape (1, 3); give shape (2, 3)
    """
    lengths: dict[str, int] = {}
    for name, (array, shape) in arrays.items():
        found = np.shape(array)
        if len(found) == len(shape):
            for axis, length in zip(shape, found, strict=True):
                if isinstance(axis, str):
                    lengths.setdefault(axis, length)
        wanted = tuple(lengths.get(axis, axis) for axis in shape)
        if found != wanted:
            words = ", ".join(map(str, wanted)) + ("," if len(wanted) == 1 else "")
            raise InputError(f"{name}: shape {found}; give shape ({words})")
