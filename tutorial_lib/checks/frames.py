"""Frame numbers that students give, and loops that never end."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.check import WrongAnswer


class Patient(np.ndarray):
    """An array that loses patience with whoever reads it again and again."""

    left: list[int]

    def __array_finalize__(self, source: object) -> None:
        self.left = getattr(source, "left", [0])

    def __getitem__(self, index: Any) -> Any:  # noqa: ANN401 - as numpy's own
        self.left[0] -= 1
        if self.left[0] < 0:
            raise WrongAnswer(
                "choose_anchors: your function never ends. Where not even frame i + 1 can be "
                "reached so surely, it is the next anchor all the same: one must get on"
            )
        return super().__getitem__(index)


def frame_numbers(what: str, got: object) -> NDArray[np.intp]:
    """The frame numbers (A,) that a student gave."""
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    try:
        numbers = np.asarray(got if isinstance(got, np.ndarray) else list(got), dtype=float)
    except (TypeError, ValueError):
        kind = type(got).__name__
        raise WrongAnswer(f"{what}: this came back: {kind}; return the frames' numbers") from None
    if numbers.ndim != 1:
        raise WrongAnswer(f"{what}: shape {numbers.shape}, but a flat list of frames is needed")
    if not len(numbers) or (numbers != np.round(numbers)).any():
        raise WrongAnswer(f"{what}: return whole numbers of frames, one at least")
    return numbers.astype(np.intp)
