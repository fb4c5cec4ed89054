"""Confidence intervals; worlds, not episodes, are the independent units."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr
from scipy.stats import binomtest

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, floats, with_methods

_DRAWS = 4_000
_FEW_DRAWS = 400  # for measures that take longer than a mean
_LEVEL = float(2 * ndtr(1.96) - 1)  # 95%, as z = 1.96 rounds it


def over_worlds(values: ArrayLike, worlds: ArrayLike) -> tuple[float, float, float]:
    """Mean of all values and its 95% interval, bootstrapped over worlds.

    With only one world, Wilson's interval.

    Args:
        values: (N,) success of each episode, 0 or 1.
        worlds: (N,) the world of each.

    >>> over_worlds([1.0, 1.0, 0.0, 1.0], [0, 0, 1, 1])
    (0.75, 0.5, 1.0)
    """
    values = floats("values", values, ("N",), least=0.0, most=1.0, empty=False)
    units = _numbered(worlds)
    alike(values=values, worlds=units)
    return wilson(values) if units.max() == 0 else _bootstrapped(values, units)


def _numbered(worlds: ArrayLike) -> NDArray[np.intp]:
    """Worlds (N,), whatever they are called, as numbers from 0 on."""
    try:
        names, units = np.unique(np.asarray(worlds), return_inverse=True)
    except (TypeError, ValueError) as error:
        raise InputError("worlds: cannot be sorted; give names or numbers (N,)") from error
    unknown = names.dtype.kind in "fc" and not np.isfinite(names).all()
    if np.ndim(worlds) != 1 or not len(names) or names.dtype.kind not in "iufU" or unknown:
        raise InputError(f"worlds: shape {np.shape(worlds)}; give names or numbers (N,)")
    return units


def _bootstrapped(values: Array, units: NDArray[np.intp]) -> tuple[float, float, float]:
    """Mean of values (N,) and its interval; whole `units` (N,), numbered from 0, are resampled."""
    sums, counts = np.bincount(units, values), np.bincount(units)
    draws = np.random.default_rng(0).integers(len(sums), size=(_DRAWS, len(sums)))
    means = sums[draws].sum(axis=1) / counts[draws].sum(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return float(values.mean()), float(low), float(high)


def measured_over_worlds(
    measure: Callable[..., float], worlds: ArrayLike, *columns: ArrayLike
) -> tuple[float, float, float]:
    """`measure` of all columns (N,), and its 95% interval, bootstrapped over worlds.

    With only one world its rows are resampled. Resamples in which it is NaN are left out.

    >>> measured_over_worlds(lambda x: float(np.max(x)), [0, 0, 1], [1.0, 2.0, 3.0])
    (3.0, 2.0, 3.0)
    """
    with_methods("measure", measure, "__call__")
    values, which = [np.asarray(column) for column in columns], _numbered(worlds)
    for number, column in enumerate(values):
        if column.shape[:1] != which.shape:
            raise InputError(f"columns[{number}]: {column.shape}; give one for each of worlds")
    rows = [np.flatnonzero(which == i) for i in range(which.max() + 1)]
    rows = [np.array([i]) for i in range(len(which))] if len(rows) == 1 else rows
    rng = np.random.default_rng(0)
    found = []
    for _ in range(_FEW_DRAWS):
        drawn = np.concatenate([rows[i] for i in rng.integers(len(rows), size=len(rows))])
        found.append(measure(*(column[drawn] for column in values)))
    kept = np.array(found)[~np.isnan(found)]
    low, high = np.quantile(kept, [0.025, 0.975]) if len(kept) else (np.nan, np.nan)
    return measure(*values), float(low), float(high)


def difference(
    first: ArrayLike, second: ArrayLike, worlds: ArrayLike
) -> tuple[float, float, float]:
    """Mean of `first` - `second` on the same episodes (N,) and its 95% interval.

    Bootstrapped over worlds; with only one world, over its episodes.

    >>> difference([1.0, 1.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0, 0, 1, 1])
    (0.5, 0.5, 0.5)
    """
    first, second = floats("first", first, ("N",)), floats("second", second, ("N",), empty=False)
    units = _numbered(worlds)
    alike(first=first, second=second, worlds=units)
    gap = first - second
    return _bootstrapped(gap, units if units.max() else np.arange(len(gap)))


def wilson(values: Array) -> tuple[float, float, float]:
    """Share of successes among `values` (N,), each 0 or 1, and Wilson's 95% interval."""
    values = floats("values", values, ("N",), least=0.0, most=1.0, empty=False)
    test = binomtest(round(float(np.sum(values))), len(values))
    interval = test.proportion_ci(confidence_level=_LEVEL, method="wilson")
    return float(np.mean(values)), float(interval.low), float(interval.high)
