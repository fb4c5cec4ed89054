"""Is a probability right? How it is measured, and how it is mended (Guo et al. 2017)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import isotonic_regression, minimize
from scipy.stats import rankdata

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array

BINS = 10
_KNOTS = 20
_STEEP = 0.05  # least slope of a calibration, so that no two scores become one


@dataclass(frozen=True)
class Reliability:
    """A reliability diagram: B bins of equal mass.

    Attributes:
        predicted: (B,) mean probability.
        measured: (B,) share that came true.
        count: (B,) how many.
    """

    predicted: Array
    measured: Array
    count: NDArray[np.intp]

    @property
    def ece(self) -> float:
        """Expected calibration error: the mean gap, each bin as often as it has predictions."""
        gap = np.abs(self.predicted - self.measured)
        return float((gap * self.count).sum() / self.count.sum())


def reliability(predicted: ArrayLike, came_true: ArrayLike, bins: int = BINS) -> Reliability:
    """Sort probabilities (N,) into bins of equal mass, and compare them with what happened (N,).

    Raises:
        InputError: when there are fewer predictions than bins, or something is not in [0, 1].

    >>> round(reliability([0.2, 0.2, 0.8, 0.8], [0, 0, 1, 1], bins=2).ece, 3)
    0.2
    """
    predicted, came_true = _checked(predicted, came_true)
    if not 1 <= bins <= len(predicted):
        raise InputError(f"reliability: {bins} bins for {len(predicted)} predictions; give fewer")
    order = np.argsort(predicted, kind="stable")
    parts = np.array_split(order, bins)
    return Reliability(
        np.array([predicted[part].mean() for part in parts]),
        np.array([came_true[part].mean() for part in parts]),
        np.array([len(part) for part in parts]),
    )


def brier(predicted: ArrayLike, came_true: ArrayLike) -> float:
    """Mean squared error of probabilities (N,).

    >>> brier([1.0, 0.5], [1, 0])
    0.125
    """
    predicted, came_true = _checked(predicted, came_true)
    return float(((predicted - came_true) ** 2).mean())


def auc(scores: ArrayLike, came_true: ArrayLike) -> float:
    """How often something that came true has the higher score (N,) than something that did not.

    >>> auc([0.1, 0.4, 0.35, 0.8], [0, 0, 1, 1])
    0.75
    """
    true = np.asarray(came_true) > 0.5
    if true.all() or not true.any():
        return float("nan")
    ranks = rankdata(scores)
    least = true.sum() * (true.sum() + 1) / 2
    return float((ranks[true].sum() - least) / (true.sum() * (~true).sum()))


def sigmoid(logits: ArrayLike) -> Array:
    """Probabilities of logits."""
    return 1.0 / (1.0 + np.exp(-np.asarray(logits, dtype=float)))


def logit(probability: ArrayLike) -> Array:
    """Logits of probabilities."""
    probability = np.asarray(probability, dtype=float)
    return np.log(probability) - np.log1p(-probability)


def fit_temperature(logits: Array, came_true: ArrayLike) -> tuple[float, float]:
    """The temperature and the offset that make logits (N,) fit best: ``logit / T + offset``."""
    label = np.asarray(came_true, dtype=float)

    def loss(x: Array) -> float:
        z = logits * np.exp(x[0]) + x[1]
        return float((np.logaddexp(0.0, z) - label * z).mean())

    found = minimize(loss, np.zeros(2), method="Nelder-Mead").x
    return float(np.exp(-found[0])), float(found[1])


@dataclass(frozen=True)
class Calibration:
    """A rising line through knots that turns a network's logits into calibrated ones.

    Attributes:
        raw: (K,) logits of the network, rising.
        mended: (K,) logits of what was measured there, rising.
    """

    raw: tuple[float, ...] = (-1.0, 1.0)
    mended: tuple[float, ...] = (-1.0, 1.0)

    def __post_init__(self) -> None:
        raw, mended = np.asarray(self.raw), np.asarray(self.mended)
        fits = len(raw) == len(mended) >= 2 and np.isfinite([*raw, *mended]).all()
        if not (fits and (np.diff(raw) > 0).all() and (np.diff(mended) > 0).all()):
            raise InputError("calibration: give as many rising finite numbers, two at least, twice")

    def __call__(self, logits: ArrayLike) -> Array:
        """Probabilities of a network's logits; beyond the knots the line goes on as it ends."""
        logits, raw, mended = np.asarray(logits, float), np.array(self.raw), np.array(self.mended)
        line = np.interp(logits, raw, mended)
        first = (mended[1] - mended[0]) / (raw[1] - raw[0])
        last = (mended[-1] - mended[-2]) / (raw[-1] - raw[-2])
        line += np.minimum(logits - raw[0], 0.0) * first + np.maximum(logits - raw[-1], 0.0) * last
        return sigmoid(line)


def fit_isotonic(logits: Array, came_true: ArrayLike, knots: int = _KNOTS) -> Calibration:
    """The rising line that fits what happened (N,) best, through bins of logits (N,).

    Bins become smaller towards the upper end, where maps and plans ask. Shares are drawn to one
    half a little, as if each bin had one more errand that half succeeded: none is 0 or 1.
    """
    order = np.argsort(logits, kind="stable")
    logits, label = logits[order], np.asarray(came_true, dtype=float)[order]
    shares = np.linspace(0.0, 1.0, knots - 2)[1:-1]
    tail = 1.0 - 0.5 ** np.arange(1, 4) * (1.0 - shares[-1])
    parts = np.split(np.arange(len(logits)), (np.append(shares, tail) * len(logits)).astype(int))
    parts = [part for part in parts if len(part)]
    count = np.array([len(part) for part in parts], dtype=float)
    raw = np.array([logits[part].mean() for part in parts])
    share = np.array([(label[part].sum() + 0.5) / (len(part) + 1.0) for part in parts])
    mended = logit(isotonic_regression(share, weights=count).x)
    distinct = np.append(True, np.diff(raw) > 1e-6)
    raw, mended = raw[distinct], mended[distinct]
    for i in range(1, len(raw)):
        mended[i] = max(mended[i], mended[i - 1] + _STEEP * (raw[i] - raw[i - 1]))
    return Calibration(tuple(raw.round(4).tolist()), tuple(mended.round(4).tolist()))


def _checked(predicted: ArrayLike, came_true: ArrayLike) -> tuple[Array, Array]:
    predicted, came_true = np.asarray(predicted, float), np.asarray(came_true, float)
    if predicted.shape != came_true.shape or predicted.ndim != 1 or not len(predicted):
        shapes = f"predictions {predicted.shape}, outcomes {came_true.shape}"
        raise InputError(f"{shapes}; give as many of both, (N,)")
    for name, values in (("predictions", predicted), ("outcomes", came_true)):
        if not ((values >= 0) & (values <= 1)).all():
            raise InputError(f"{name}: not all from 0 to 1; give probabilities, and 0 or 1")
    return predicted, came_true
