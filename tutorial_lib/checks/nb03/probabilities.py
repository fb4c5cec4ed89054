"""The checks of notebook 03 that judge probabilities: their loss, their diagram, their mending."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, call, check, expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import reliability, sigmoid

Function = Callable[..., Any]


def reach_loss(logits: Array, labels: Array, weights: Array) -> float:
    """Weighted mean of the cross-entropy of logits (N,) with labels (N,) in [0, 1]."""
    return float(np.average(np.logaddexp(0.0, logits) - labels * logits, weights=weights))


_LOSS_CASES = (
    ("hard labels", [0.3, -1.2, 2.0, -0.5], [1.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]),
    ("soft labels", [0.3, -1.2, 2.0, -0.5], [0.7, 0.04, 0.55, 0.2], [1.0, 1.0, 1.0, 1.0]),
    ("weights", [0.3, -1.2, 2.0, -0.5, 1.0], [1.0, 0.0, 0.0, 1.0, 0.3], [1.0, 0.5, 2.0, 0.0, 3.0]),
    ("very sure, and right", [1000.0, -1000.0], [1.0, 0.0], [1.0, 1.0]),
    ("very sure, and wrong", [60.0, -1000.0, 1000.0], [0.0, 1.0, 0.25], [1.0, 1.0, 1.0]),
)
_CLIPS = (1e-16, 1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)


@check(reach_loss, (np.linspace(-4, 4, 4000), np.linspace(0, 1, 4000), np.ones(4000)))
def check_reach_loss(student: Function) -> None:
    """Hard and soft labels, weights, and logits of which no exponential can be taken."""
    for name, *numbers in _LOSS_CASES:
        case = [np.array(column) for column in numbers]
        what, want = f"reach_loss, {name}", reach_loss(*case)
        with np.errstate(all="ignore"):
            got, mistakes = call(student, *case), _misjudged(*case)
        if np.shape(got) == case[0].shape:
            raise WrongAnswer(f"{what}: one loss for each pair; return their weighted mean")
        if np.shape(got) == () and got is not None and name.startswith("very sure"):
            _expect_no_limit(what, float(got), want, case)
        expect_close(what, got, want, 1e-6 * (1 + want), mistakes)


def _expect_no_limit(what: str, got: float, want: float, case: list[Array]) -> None:
    """Demand that the loss was neither lost on the way nor limited."""
    if not np.isfinite(got):
        words = "infinite, since exp(1000) is too large a number"
        if np.isnan(got):
            words = "not a number, since log(0) was taken, of a probability that is exactly 0 or 1"
        raise WrongAnswer(f"{what}: {words}; np.logaddexp(0, z) is log(1 + exp(z)) for every z")
    with np.errstate(over="ignore"):
        chance = sigmoid(case[0])
    for low in _CLIPS:
        limited = _entropy(np.clip(chance, low, 1.0 - low), *case[1:])
        if np.isclose(got, limited, rtol=0.02) and not np.isclose(got, want, rtol=0.02):
            words = "the probability was clipped, so that a mistake costs the same however sure"
            raise WrongAnswer(f"{what}: {words} the network was; stay with the logit")


def _entropy(chance: Array, labels: Array, weights: Array) -> float:
    """The loss from probabilities, as it stands in books."""
    with np.errstate(all="ignore"):
        each = -labels * np.log(chance) - (1 - labels) * np.log1p(-chance)
    return float(np.average(each, weights=weights))


def _misjudged(logits: Array, labels: Array, weights: Array) -> dict[str, float]:
    """Known mistakes, and the losses they give."""
    chance, nothing = sigmoid(logits), np.logaddexp(0.0, logits)
    each = nothing - labels * logits

    def mean(values: Array) -> float:
        return float(np.average(values, weights=weights))

    return {
        "a loss is positive: turn its sign round": -mean(each),
        "pairs that are not reached count, too: there is a second term, with 1 - y": mean(
            labels * np.logaddexp(0.0, -logits)
        ),
        "the wrong way round: a high logit says that the target will be reached": mean(
            nothing - (1 - labels) * logits
        ),
        "labels may lie between 0 and 1: do not round them": mean(
            nothing - (labels > 0.5) * logits
        ),
        "the weights do not count yet": float(each.mean()),
        "divide by the sum of the weights, not by the number of pairs": float(
            (weights * each).mean()
        ),
        "that is the sum; divide it by the sum of the weights": float((weights * each).sum()),
        "that is the squared error, not the cross-entropy": mean((chance - labels) ** 2),
        "that is the absolute error, which is smallest for a claim of 0 or 1": mean(
            np.abs(chance - labels)
        ),
        "logits are no probabilities; the sigmoid makes them so": _entropy(
            np.clip(logits, 1e-7, 1 - 1e-7), labels, weights
        ),
    }


Diagram = tuple[Array, Array, float]


def reliability_diagram(predicted: Array, came_true: Array, bins: int) -> Diagram:
    """Mean prediction (B,) and share that came true (B,) in bins of equal mass, and the ECE."""
    found = reliability(predicted, came_true, bins)
    return found.predicted, found.measured, found.ece


_CHANCES = np.random.default_rng(3).beta(1.2, 0.6, 203)
_CAME_TRUE = (np.random.default_rng(4).random(203) < _CHANCES**1.7).astype(float)


@check(reliability_diagram, (np.repeat(_CHANCES, 10), np.repeat(_CAME_TRUE, 10), 10))
def check_reliability_diagram(student: Function) -> None:
    """203 predictions in ten bins of equal mass, most of them near 1; and four in two."""
    few = np.array([0.9, 0.1, 0.6, 0.2]), np.array([1.0, 0.0, 0.0, 0.0]), 2
    cases = (("203 predictions", (_CHANCES, _CAME_TRUE, 10)), ("four predictions", few))
    for name, case in cases:
        wanted = reliability_diagram(*case)
        with np.errstate(all="ignore"):
            got = call(student, *case)
        if got is None:
            raise WrongAnswer("reliability_diagram: nothing came back; is a return missing?")
        if not isinstance(got, tuple | list) or len(got) != 3:
            raise WrongAnswer("reliability_diagram: return three things: predicted, measured, ece")
        parts = zip(("predicted", "measured", "ece"), got, wanted, _misbinned(*case), strict=True)
        for part, answer, want, mistakes in parts:
            expect_close(f"{part}, {name}", answer, want, 1e-9, mistakes)


def _misbinned(
    predicted: Array, came_true: Array, bins: int
) -> tuple[dict[str, Array], dict[str, Array], dict[str, float]]:
    """Known mistakes of the three answers, and what they give."""
    order = np.argsort(predicted, kind="stable")
    parts, plain = np.array_split(order, bins), np.array_split(np.arange(len(order)), bins)
    number = np.clip((predicted * bins).astype(int), 0, bins - 1)
    wide = [np.flatnonzero(number == b) for b in range(bins)]

    def means(values: Array, groups: list[Array]) -> Array:
        return np.array([values[group].mean() if len(group) else np.nan for group in groups])

    said, found = means(predicted, parts), means(came_true, parts)
    gap, count = np.abs(said - found), np.array([len(part) for part in parts])
    sizes = "these bins are equally wide; each is to have as many predictions as the next"
    rising = "the bins rise: the lowest predictions come first"
    first = {
        sizes: means(predicted, wide),
        "sort the predictions before you cut them into bins": means(predicted, plain),
        "give the mean of a bin's predictions, not the middle between its ends": np.array(
            [(predicted[part].min() + predicted[part].max()) / 2 for part in parts]
        ),
        "that is the middle of equally wide bins; give the mean prediction": (
            (np.arange(bins) + 0.5) / bins
        ),
        "predictions come first, what came true second": found,
        rising: said[::-1],
    }
    second = {
        "what came true belongs to its prediction: put both in the same order": means(
            came_true, plain
        ),
        "what came true belongs to its prediction: do not sort it by itself": means(
            np.sort(came_true), plain
        ),
        "give the share that came true, not how many": found * count,
        rising: found[::-1],
    }
    signed = float(((said - found) * count).sum() / count.sum())
    third = {
        "too high and too low must not cancel: take absolute gaps": signed,
        "too high and too low must not cancel, so take absolute gaps": -signed,
        "that is the largest gap; take the mean": float(gap.max()),
        "take the gaps, not their squares": float((gap**2 * count).sum() / count.sum()),
        "that is how far single predictions are off; compare the means of bins": float(
            np.abs(predicted - came_true).mean()
        ),
        "that is the sum over all bins; take the mean": float(gap.sum()),
        "a bin counts as often as it has predictions: weigh the gaps": float(gap.mean()),
    }
    return first, second, third


_TEMPERATURES = np.geomspace(0.05, 20.0, 600)


def fit_temperature(logits: Array, labels: Array) -> float:
    """The temperature for which the loss of logits (N,) over it is smallest, to one percent."""
    return float(_TEMPERATURES[_losses(logits, labels).argmin()])


def _losses(logits: Array, labels: Array) -> Array:
    """(600,) loss at each temperature."""
    ones = np.ones(len(logits))
    return np.array([reach_loss(logits / t, labels, ones) for t in _TEMPERATURES])


def _told(temperature: float, blunders: float = 0.0, soft: bool = False) -> tuple[Array, Array]:
    """Logits (600,) of a network that should be divided by about so much, and labels.

    The opposite happens of what is expected in a share of `blunders`, which squares mind less.
    """
    rng = np.random.default_rng(7)
    logits = rng.normal(1.0, 2.0, 600) * temperature
    chance = blunders + (1 - 2 * blunders) * sigmoid(logits / temperature)
    return logits, chance if soft else (rng.random(600) < chance).astype(float)


@check(fit_temperature, _told(2.5))
def check_fit_temperature(student: Function) -> None:
    """A network that is too sure, one that is not sure enough, and soft labels."""
    cases = (
        ("one too sure", _told(2.0, blunders=0.12)),
        ("one too modest", _told(0.4)),
        ("soft labels", _told(1.8, soft=True)),
    )
    for name, (logits, labels) in cases:
        best, what = fit_temperature(logits, labels), f"fit_temperature, {name}"
        with np.errstate(all="ignore"):
            got = call(student, logits, labels)
        if np.shape(got) == () and isinstance(got, int | float | np.number):
            _expect_temperature(what, float(got), best, logits, labels)
        expect_close(what, got, best, 0.03 * best)


def _expect_temperature(what: str, got: float, best: float, logits: Array, labels: Array) -> None:
    """Name the mistake, where a temperature is wrong and the mistake is known."""
    if got > 0 and abs(np.log(got / best)) < 0.03:
        return
    losses = _losses(logits, labels)
    chances = [sigmoid(logits / t) for t in _TEMPERATURES]
    squares = _TEMPERATURES[np.argmin([((p - labels) ** 2).mean() for p in chances])]
    errors = [reliability(p, labels).ece for p in chances]
    mistakes = {
        "that is 1 / T: the logits are divided by the temperature": 1 / best,
        "that is the smallest loss; give the temperature that has it": losses.min(),
        "that is the logarithm of the temperature": np.log(best),
        "a temperature below 1 is allowed, it makes a network surer": 1.0,
        "the cross-entropy is to be smallest, not the squared error": squares,
        "the cross-entropy is to be smallest, not the ECE, which jumps when a pair changes its "
        "bin": _TEMPERATURES[np.argmin(errors)],
        "the loss is to be smallest, not largest": _TEMPERATURES[losses.argmax()],
    }
    for words, value in mistakes.items():
        if np.isclose(got, value, rtol=0.012):
            raise WrongAnswer(f"{what}: {words}")
    if got <= 0:
        raise WrongAnswer(f"{what}: {got:.3g}, but a temperature is greater than 0")
    if got == int(got) and got >= len(_TEMPERATURES) / 100:
        words = "is that the place of the best temperature in a list? Give the temperature"
        raise WrongAnswer(f"{what}: {got:.0f}; {words}")
