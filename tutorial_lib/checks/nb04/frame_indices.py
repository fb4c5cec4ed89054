"""Indices of frames that students return."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.checks.framework.check import WrongAnswer


def frame_indices(what: str, got: Any, *_: object) -> NDArray[np.intp]:  # noqa: ANN401
    """The indices of frames (A,) that a student returned."""
    got = returned(what, got)
    try:
        numbers = np.asarray(got if isinstance(got, np.ndarray) else list(got), dtype=float)
    except (TypeError, ValueError):
        kind = type(got).__name__
        raise WrongAnswer(
            f"{what}: this came back: {kind}; return the indices of the frames"
        ) from None
    if numbers.ndim != 1:
        raise WrongAnswer(f"{what}: shape {numbers.shape}, but a flat list of frames is needed")
    if not len(numbers) or (numbers != np.round(numbers)).any():
        raise WrongAnswer(f"{what}: return whole numbers, the indices of frames, at least one")
    return numbers.astype(np.intp)
