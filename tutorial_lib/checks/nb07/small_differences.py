"""What to say of numbers that are nearly right, for the checks of notebook 07."""

from __future__ import annotations

import numpy as np

from tutorial_lib.geometry import Array

_NEAR = 2e-6
"""Differences up to here are rounding, or a small number that was added."""


def both(mine: float, right: float, digits: int = 4) -> tuple[str, str]:
    """Two numbers with as many digits as it takes to see that they differ.

    >>> both(0.25, 0.75)
    ('0.25', '0.75')
    >>> both(0.481400012, 0.4814)
    ('0.48140001', '0.4814')
    """
    for count in range(digits, 17):
        if f"{mine:.{count}g}" != f"{right:.{count}g}":
            return f"{mine:.{count}g}", f"{right:.{count}g}"
    return repr(float(mine)), repr(float(right))


def of_rounding(got: Array, want: Array) -> str:
    """Why an answer is right but for its last digits; empty if it is not.

    >>> of_rounding(np.float32([0.1, 0.3]).astype(float), np.array([0.1, 0.3]))
    '; float32 keeps seven digits only: compute with float64, which numpy takes by itself'
    """
    if not np.isfinite(got).all() or np.abs(got - want).max(initial=0.0) > _NEAR:
        return ""
    if np.array_equal(got, got.astype(np.float32)):
        return (
            "; float32 keeps seven digits only: compute with float64, which numpy takes by itself"
        )
    return "; nearly right: is something rounded (as in float32), or a small number added to it?"


def farthest(got: Array, want: Array, *_: object) -> str:
    """Where two answers of numbers differ most, and why if they hardly do."""
    if np.isnan(got).any():
        return "some of it is not a number; is something divided by zero?"
    with np.errstate(invalid="ignore"):  # inf - inf, where both agree
        apart = np.nan_to_num(np.abs(got - want))
    worst = tuple(int(i) for i in np.unravel_index(apart.argmax(), want.shape))
    mine, right = both(got[worst], want[worst])
    return f"{mine} at {worst}, but {right} is right{of_rounding(got, want)}"
