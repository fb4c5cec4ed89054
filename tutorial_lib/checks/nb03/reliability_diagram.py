"""The check of the reliability diagram, in notebook 03."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, check, close, parts
from tutorial_lib.checks.framework.wording import both
from tutorial_lib.checks.nb03.forms import calling, one_number, vector
from tutorial_lib.geometry import Array

Diagram = tuple[Array, Array, float]
Bins = list[NDArray[np.intp]]
_NEAR = 1e-7


def reliability_diagram(predicted: Array, came_true: Array, bins: int) -> Diagram:
    """Mean prediction (B,) and share that came true (B,) in bins of equal mass, and the ECE."""
    return _diagram(predicted, came_true, np.array_split(np.argsort(predicted), bins))


def _diagram(predicted: Array, came_true: Array, groups: Bins) -> Diagram:
    means, shares = _means(predicted, groups), _means(came_true, groups)
    count = np.array([len(group) for group in groups])
    return means, shares, float((count * np.abs(means - shares)).sum() / count.sum())


def _means(values: Array, groups: Bins) -> Array:
    return np.array([values[group].mean() if len(group) else np.nan for group in groups])


def _random(count: int, seed: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    predicted = rng.beta(1.2, 0.6, count)
    return predicted, (rng.random(count) < predicted**1.7).astype(float)


def _few(predicted: list[float], came_true: list[int], bins: int) -> tuple[Array, Array, int]:
    return np.array(predicted), np.array(came_true, dtype=float), bins


_CASES = {
    "200 predictions in ten bins": (*_random(200, 3), 10),
    "203 predictions in ten bins": (*_random(203, 4), 10),
    "38 predictions in five bins": (*_random(38, 5), 5),
    "17 predictions in one bin": (*_random(17, 6), 1),
    "9 predictions in nine bins": (*_random(9, 7), 9),
    "29 predictions in twenty bins": (*_random(29, 9), 20),
    "four predictions in two bins": _few([0.9, 0.1, 0.6, 0.2], [1, 0, 0, 0], 2),
    "equal predictions": _few([0.7, 0.2, 0.2, 0.7, 0.2, 0.9], [1, 0, 0, 1, 0, 1], 3),
    "equal predictions of which some come true": _few(
        [0.5, 0.5, 0.9, 0.5, 0.9, 0.5, 0.9, 0.9], [1, 0, 1, 0, 1, 0, 0, 1], 2
    ),
}
_HINTS: dict[type[Exception], str] = {
    ValueError: "N need not be a multiple of B, so the bins cannot all be rows of one table: see "
    "np.array_split",
    ZeroDivisionError: "a bin must not be empty; bins of equal mass never are",
    IndexError: "there are N predictions, 0 to N - 1, and B bins",
    TypeError: "predicted and came_true are arrays (N,), bins is a whole number",
}


@check(reliability_diagram, (*_random(2000, 8), 10))
def check_reliability_diagram(student: Callable[..., Any]) -> None:
    """Few and many predictions, most of them near 1, in bins that come out even or not."""
    invoke = calling(_HINTS)
    words = "return three things: mean predictions, shares that came true, ECE"
    for name, case in _CASES.items():
        predicted, came_true, bins = case
        what = f"reliability_diagram, {name}"
        got = parts(what, invoke(what, student, *case), 3, words)
        means = vector(f"{what}, means", got[0], bins, "the mean prediction of each bin")
        shares = vector(f"{what}, shares", got[1], bins, "the share of each bin that came true")
        ece = one_number(f"{what}, ECE", got[2], "the ECE")
        groups = _even_groups(predicted, means, bins)
        usual = np.array_split(np.argsort(predicted, kind="stable"), bins)
        want = _diagram(predicted, came_true, usual if groups is None else groups)
        first, second, third = _mistakes(predicted, came_true, usual, groups)
        _expect(f"{what}, means", means, want[0], first, _means_apart)
        _expect(f"{what}, shares", shares, want[1], second, _shares_apart)
        _expect(f"{what}, ECE", ece, want[2], third, _ece_apart, tolerance=_NEAR)


def _expect(
    what: str,
    got: Array | float,
    want: Array | float,
    mistakes: Mapping[str, Array | float],
    apart: Callable[[Any, Any], str],
    tolerance: float = 1e-6,
) -> None:
    """Demand one answer; the first of the mistakes that gives a wrong one is named."""

    def same(other: Array | float) -> bool:
        return close(np.asarray(got), other, tolerance=tolerance)

    if not same(want):
        named = (words for words, mistaken in mistakes.items() if same(mistaken))
        raise WrongAnswer(f"{what}: {next(named, None) or apart(got, want)}")


def _even_groups(predicted: Array, means: Array, bins: int) -> Bins | None:
    """The bins with these means, if their sizes differ by one at most; None if they do not."""
    order, size = np.argsort(predicted, kind="stable"), len(predicted) // bins
    groups, first = [], 0
    for mean in means:
        fits = [
            order[first : first + count]
            for count in (size, size + 1)
            if abs(predicted[order[first : first + count]].mean() - mean) < _NEAR
        ]
        if not fits:
            return None
        # Of equal predictions as many as are left for this bin.
        groups.append(fits[-1] if len(order) % bins else fits[0])
        first += len(groups[-1])
    return groups if first == len(order) else None


def _means_apart(got: Array, want: Array) -> str:
    words = "the next N / B predictions make a bin, also equal ones; take their mean, unrounded"
    return f"{words} ({_bin_apart(got, want, 'the mean prediction')})"


def _shares_apart(got: Array, want: Array) -> str:
    words = "of the pairs in each bin, the mean of came_true, from 0 to 1"
    return f"{words} ({_bin_apart(got, want, 'the share that came true')})"


def _bin_apart(got: Array, want: Array, what: str) -> str:
    if np.isnan(got).any():
        return f"{what} of bin {int(np.isnan(got).argmax())} is not a number; is that bin empty?"
    worst = int(np.abs(got - want).argmax())
    mine, right = both(got[worst], want[worst])
    return f"{what} of bin {worst} is {mine}, but {right} is right"


def _ece_apart(got: float, want: float) -> str:
    words = "is right: the sum over the bins of n_b / N times the gap between its two means"
    mine, right = both(got, want)
    return f"the ECE is {mine}, but {right} {words}"


def _mistakes(
    predicted: Array, came_true: Array, usual: Bins, groups: Bins | None
) -> tuple[dict[str, Array], dict[str, Array], dict[str, float]]:
    """Known mistakes of the three answers, and what they give."""
    bins, order = len(usual), np.argsort(predicted, kind="stable")
    chosen = usual if groups is None else groups
    count = np.array([len(group) for group in chosen])
    plain = np.split(np.arange(len(order)), np.cumsum(count)[:-1])
    size = len(order) // bins
    heavy = np.split(order, size * np.arange(1, bins))
    short = [group[:size] for group in heavy]
    from_lowest = (predicted - predicted.min()) / max(np.ptp(predicted), 1e-12)

    def equally_wide(x: Array) -> Array:
        number = np.clip((x * bins).astype(int), 0, bins - 1)
        return _means(predicted, [np.flatnonzero(number == b) for b in range(bins)])

    wide, spread = equally_wide(predicted), equally_wide(from_lowest)
    means, shares = _means(predicted, chosen), _means(came_true, chosen)
    middle = np.array([(predicted[group].min() + predicted[group].max()) / 2 for group in chosen])
    medians = np.array([np.median(predicted[group]) for group in chosen])
    sizes = "these bins are equally wide; each is to have as many predictions as the next"
    left = "the last bin has all that is left over; the sizes of bins differ by one at most"
    lost = "the predictions that are left over are missing; each belongs to a bin"
    rising = "the bins rise: the lowest predictions come first"
    first = {
        left: _means(predicted, heavy),
        lost: _means(predicted, short),
        sizes: wide,
        f"from the lowest to the highest prediction {sizes}": spread,
        f"{sizes}, and none is empty": np.nan_to_num(wide),
        "sort the predictions before you cut them into bins": _means(predicted, plain),
        "give the mean of a bin's predictions, not the middle between its ends": middle,
        "that is the middle of equally wide bins; give the mean prediction": (
            (np.arange(bins) + 0.5) / bins
        ),
        "give the mean of a bin's predictions, not the median": medians,
        "give the mean of a bin's predictions, not their sum": means * count,
        "predictions come first, what came true second": shares,
        rising: means[::-1],
    }
    its = "what came true belongs to its prediction"
    second = {
        f"{its}: put both in the same order": _means(came_true, plain),
        f"{its}: do not sort it by itself": _means(np.sort(came_true), plain),
        "give the share that came true, not how many": shares * count,
        "that is the mean prediction again; give the share that came true": means,
        "give the share that came true, not the share that did not": 1 - shares,
        "the share is of the predictions of this bin, not of all N": shares * count / len(order),
        rising: shares[::-1],
    }
    gap, weight = np.abs(means - shares), count / len(order)
    signed, squared = ((means - shares) * weight).sum(), (gap**2 * weight).sum()
    single = np.abs(predicted - came_true).mean()
    third = {
        "too high and too low must not cancel: take absolute gaps": signed,
        "too high and too low must not cancel, so take absolute gaps": -signed,
        "the gap of each bin counts; absolute values come before the sum": abs(signed),
        "that is the largest gap; take the mean": gap.max(),
        "take the gaps, not their squares": squared,
        "take the gaps, not the root of their mean square": np.sqrt(squared),
        "that is how far single predictions are off; compare the means of bins": single,
        "that is the sum over all bins; take the mean": gap.sum(),
        "that is not divided by N yet": (gap * count).sum(),
        "a bin counts as often as it has predictions: weigh the gaps by n_b / N": gap.mean(),
    }
    return first, second, third
