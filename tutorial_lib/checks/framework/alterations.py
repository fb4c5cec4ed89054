"""Right answers of which something was taken away: rounded, cut off, or with small numbers lost."""

from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.wording import number_of
from tutorial_lib.geometry import Array

_DIGITS = 9  # up to which answers may be rounded
_NEAR = 2e-5  # share, or difference from 0, up to which an answer is right but for its digits
_FEWEST = 2  # different numbers from which more is concluded than chance would explain
_alike = partial(np.allclose, rtol=0, atol=1e-6, equal_nan=True)


def altered(pairs: Sequence[tuple[Any, Any]]) -> str:
    """What was done to right answers; empty if none of this module's alterations explains all.

    Args:
        pairs: an answer and the right one, of each case.
    """
    values = [(_numbers(got), _numbers(want)) for got, want in pairs]
    if not values or any(g is None or w is None or g.shape != w.shape for g, w in values):
        return ""
    got, want = (np.concatenate(side) for side in zip(*values, strict=True))
    if _alike(want, np.round(want)):  # whole numbers have no digits to lose
        return ""
    return _rounded(got, want) or _nearly(got, want) or _lost(got, want) or _limited(got, want)


def telling(answers: Sequence[Any]) -> bool:
    """Whether answers hold different numbers besides 0, so that few rules give all of them."""
    numbers = [values for values in map(_numbers, answers) if values is not None]
    different = np.unique(np.concatenate(numbers)) if numbers else np.zeros(0)
    return bool(np.count_nonzero(np.isfinite(different) & (different != 0)) >= _FEWEST)


def _rounded(got: Array, want: Array) -> str:
    if _alike(got, np.trunc(want)):
        return "your answers are whole numbers: their digits are cut off; return all digits"
    for digits in range(_DIGITS):
        near = min(1e-6, 10.0 ** -(digits + 3))
        if np.allclose(got, np.round(want, digits), rtol=0, atol=near, equal_nan=True):
            how = f"to {number_of(digits, 'digit')}" if digits else "to whole numbers"
            return f"your answers are rounded {how}; return all digits"
    return ""


def _nearly(got: Array, want: Array) -> str:
    if not np.allclose(got, want, rtol=_NEAR, atol=_NEAR, equal_nan=True):
        return ""
    if np.array_equal(got, got.astype(np.float32), equal_nan=True):
        return "float32 keeps seven digits only: compute with float64, which numpy takes by itself"
    return (
        "nearly right: is something rounded (as in float32), pi written with few digits, or a "
        "small number added?"
    )


def _lost(got: Array, want: Array) -> str:
    """Small numbers that come back as 0."""
    wrong = ~np.isclose(got, want, rtol=0, atol=1e-6, equal_nan=True)
    kept = np.abs(got[~wrong & (got != 0)])
    if not kept.size or not wrong.any() or got[wrong].any():
        return ""
    least = np.abs(want[wrong]).max()
    words = f"numbers as small as {least:.2g} come back as 0; leave none out"
    return words if least < kept.min() else ""


def _limited(got: Array, want: Array) -> str:
    """Numbers beyond a limit that come back as the limit."""
    finite = got[np.isfinite(got)]
    if np.unique(finite).size < 2 or not _alike(got, np.clip(want, finite.min(), finite.max())):
        return ""
    for limit, beyond in ((finite.max(), want > finite.max()), (finite.min(), want < finite.min())):
        if np.unique(want[beyond]).size >= _FEWEST and beyond.mean() < 0.5:
            return f"your answers are cut off at {limit:.4g}; nothing limits them"
    return ""


def _numbers(answer: Any) -> Array | None:  # noqa: ANN401
    """All numbers of an answer, in a row; None if it holds anything else."""
    parts = answer if isinstance(answer, tuple | list) else (answer,)
    with suppress(TypeError, ValueError):
        return np.concatenate([np.asarray(part, dtype=float).ravel() for part in parts])
    return None
