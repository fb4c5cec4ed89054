"""What the motion policies of notebook 02 return: accelerations and metrics."""

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, farthest, numbers, parts
from tutorial_lib.geometry import Array

Policies = tuple[Array, Array]
"""Accelerations and metrics."""


def policies_of(
    what: str, answer: object, accelerations: tuple[int, ...], metrics: tuple[int, ...]
) -> Policies:
    """An answer as accelerations and metrics of these shapes."""
    if isinstance(answer, np.ndarray) and accelerations == metrics and len(answer) == 2:
        answer = tuple(answer)
    words = "return two things, the accelerations and the metrics"
    first, second = parts(what, answer, 2, words)
    shapes = tuple(part.shape for part in (first, second) if isinstance(part, np.ndarray))
    if shapes == (metrics, accelerations) and metrics != accelerations:
        raise WrongAnswer(f"{what}: the two are exchanged: give the accelerations first")
    return (
        numbers(f"{what}: the accelerations", first, accelerations),
        numbers(f"{what}: the metrics", second, metrics),
    )


def same_policies(got: Policies, want: Policies, *_: object) -> bool:
    """Whether both parts agree."""
    return all(map(_alike, got, want))


def differing(got: Policies, want: Policies, *_: object) -> str:
    """Which part differs, and where."""
    for name, mine, right in zip(("accelerations", "metrics"), got, want, strict=True):
        if not _alike(mine, right):
            return f"{name}: {farthest(mine, np.asarray(right, float))}"
    return "they agree"


def _alike(mine: Array, right: Array) -> bool:
    return np.allclose(mine, right, rtol=1e-6, atol=1e-6, equal_nan=True)
