"""Is a probability right? How it is measured, and how it is mended (Guo et al. 2017)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import isotonic_regression, minimize
from scipy.special import expit

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, floats, whole

BINS = 10
_KNOTS = 20
_STEEP = 0.05  # least slope of a calibration, so that no two scores become one
_PLACES = 4  # decimals of its knots; mended ones have two more, for the least slope
_BOUNDS = ((1e-3, 1e3), (-100.0, 100.0))  # of 1 / temperature and the offset


@dataclass(frozen=True)
class Reliability:
    """A reliability diagram: B bins of equal mass; fewer and uneven where predictions are equal.

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

    Equal probabilities share a bin, so that the order of the rows does not matter.

    Raises:
        InputError: when there are fewer predictions than bins, or something is not in [0, 1].

    >>> round(reliability([0.2, 0.2, 0.8, 0.8], [0, 0, 1, 1], bins=2).ece, 3)
    0.2
    """
    predicted, came_true = _checked("predicted", predicted, came_true, least=0.0, most=1.0)
    whole("bins", bins, least=1, most=len(predicted))
    dealt = np.array_split(np.arange(len(predicted)), bins)
    parts = _binned(predicted, [rows[0] for rows in dealt])
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
    predicted, came_true = _checked("predicted", predicted, came_true, least=0.0, most=1.0)
    return float(((predicted - came_true) ** 2).mean())


def auc(scores: ArrayLike, came_true: ArrayLike) -> float:
    """How often something that came true has the higher score (N,) than something that did not.

    Not a number where all of them came true, or none.

    >>> auc([0.1, 0.4, 0.35, 0.8], [0, 0, 1, 1])
    0.75
    """
    scores, came_true = _checked("scores", scores, came_true, infinite=True)
    true = came_true > 0.5
    if true.all() or not true.any():
        return float("nan")
    ranks = _ranks(scores)
    least = true.sum() * (true.sum() + 1) / 2
    return float((ranks[true].sum() - least) / (true.sum() * (~true).sum()))


def sigmoid(logits: ArrayLike) -> Array:
    """Probabilities of logits."""
    return expit(floats("logits", logits, infinite=True))


def logit(probability: ArrayLike) -> Array:
    """Logits of probabilities."""
    probability = floats("probability", probability, least=0.0, most=1.0)
    return np.log(probability) - np.log1p(-probability)


def fit_temperature(logits: Array, came_true: ArrayLike) -> tuple[float, float]:
    """The temperature and the offset that make logits (N,) fit best: ``logit / T + offset``.

    The loss is convex in 1 / T and the offset. They are bounded, since what is always right or
    never is fitted best by infinite ones.
    """
    logits, label = _checked("logits", logits, came_true)

    def loss(x: Array) -> tuple[float, Array]:
        z = logits * x[0] + x[1]
        gap = sigmoid(z) - label
        gradient = np.array([(gap * logits).mean(), gap.mean()])
        return float((np.logaddexp(0.0, z) - label * z).mean()), gradient

    exact = {"ftol": 0.0, "gtol": 1e-9, "maxiter": 1_000}
    found = minimize(loss, [1.0, 0.0], jac=True, bounds=_BOUNDS, method="L-BFGS-B", options=exact).x
    return 1.0 / float(found[0]), float(found[1])


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
        raw, mended = floats("raw", self.raw, ("K",)), floats("mended", self.mended, ("K",))
        fits = len(raw) == len(mended) >= 2
        if not (fits and (np.diff(raw) > 0).all() and (np.diff(mended) > 0).all()):
            raise InputError("calibration: raw, mended: give as many rising finite numbers")

    def __call__(self, logits: ArrayLike) -> Array:
        """Probabilities of a network's logits; beyond the knots the line goes on as it ends."""
        logits = floats("logits", logits, infinite=True)
        raw, mended = np.array(self.raw), np.array(self.mended)
        line = np.interp(logits, raw, mended)
        first = (mended[1] - mended[0]) / (raw[1] - raw[0])
        last = (mended[-1] - mended[-2]) / (raw[-1] - raw[-2])
        line += np.minimum(logits - raw[0], 0.0) * first + np.maximum(logits - raw[-1], 0.0) * last
        return expit(line)


def fit_isotonic(logits: Array, came_true: ArrayLike, knots: int = _KNOTS) -> Calibration:
    """The rising line that fits what happened (N,) best, through bins of logits (N,).

    Bins become smaller towards the upper end, where maps and plans query. Shares are drawn to one
    half a little, as if each bin had one more pair that half succeeded: none is 0 or 1.
    """
    # Logits that differ by less share a bin, so that knots can be rounded and still rise.
    logits, label = _checked("logits", logits, came_true)
    logits = np.round(logits, _PLACES)
    whole("knots", knots, least=4, most=1_000)
    shares = np.linspace(0.0, 1.0, knots - 2)[1:-1]
    tail = 1.0 - 0.5 ** np.arange(1, 4) * (1.0 - shares[-1])
    parts = _binned(logits, (np.append(shares, tail) * len(logits)).astype(int))
    if len(parts) < 2:
        raise InputError("logits: all alike, and no rising line leads through one point")
    count = np.array([len(part) for part in parts], dtype=float)
    raw = np.array([logits[part].mean() for part in parts]).round(_PLACES)
    share = np.array([(label[part].sum() + 0.5) / (len(part) + 1.0) for part in parts])
    mended = logit(isotonic_regression(share, weights=count).x)
    for i in range(1, len(raw)):
        mended[i] = max(mended[i], mended[i - 1] + _STEEP * (raw[i] - raw[i - 1]))
    return Calibration(tuple(raw.tolist()), tuple(mended.round(_PLACES + 2).tolist()))


def _binned(values: Array, cuts: ArrayLike) -> list[NDArray[np.intp]]:
    """Rows of each bin, when sorted values (N,) are cut before the rows `cuts`, rising.

    Equal values all go to the bin in which their middle lies. No bin is empty.
    """
    order = np.argsort(values, kind="stable")
    middle = _ranks(values)[order] - 1.0
    number = np.searchsorted(cuts, middle, side="right")
    return np.split(order, np.flatnonzero(np.diff(number)) + 1)


def _ranks(values: ArrayLike) -> Array:
    """Ranks from 1 on; equal values share the middle one (scipy.stats is slow to import)."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - (counts - 1) / 2)[inverse]


def _checked(
    name: str,
    values: ArrayLike,
    came_true: ArrayLike,
    least: float = -np.inf,
    most: float = np.inf,
    infinite: bool = False,
) -> tuple[Array, Array]:
    """What was predicted (N,) and the share (N,) that came true, as many of both."""
    values = floats(name, values, ("N",), least=least, most=most, infinite=infinite, empty=False)
    came_true = floats("came_true", came_true, ("N",), least=0.0, most=1.0)
    alike(**{name: values, "came_true": came_true})
    return values, came_true
