"""The check of the loss of RE, in notebook 03."""

from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, case, exercise
from tutorial_lib.checks.framework.wording import both
from tutorial_lib.checks.nb03.forms import calling, one_number
from tutorial_lib.geometry import Array

Case = tuple[Array, Array, Array]
"""logits, labels and weights, (N,) each."""


def reach_loss(logits: Array, labels: Array, weights: Array) -> float:
    """Weighted mean of the cross-entropy of logits (N,) with labels (N,) in [0, 1]."""
    each = np.logaddexp(0.0, logits) - labels * logits
    return float((weights * each).sum() / weights.sum())


def _arrays(*rows: list[float]) -> Case:
    logits, labels, weights = (np.array(row, dtype=float) for row in rows)
    return logits, labels, weights


def _random(count: int, seed: int) -> Case:
    """Soft and hard labels, and weights of which some are 0."""
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random(count) < 0.5, rng.integers(2, size=count), rng.random(count))
    weights = rng.uniform(0.0, 3.0, count) * (rng.random(count) < 0.8)
    return rng.normal(0.5, 3.0, count), labels, np.append(weights[:-1], 0.7)


CASES = {
    "hard labels": _arrays([0.3, -1.2, 2.0, -0.5], [1.0, 0.0, 0.0, 1.0], [1.0] * 4),
    "soft labels": _arrays([0.3, -1.2, 2.0, -0.5], [0.7, 0.04, 0.55, 0.2], [1.0] * 4),
    "weights": _arrays([0.3, -1.2, 2.0, -0.5, 1], [1, 0, 0, 1, 0.3], [1, 0.5, 2, 0, 3]),
    "equal weights of 2": _arrays([0.3, -1.2, 2.0], [1.0, 0.0, 0.0], [2.0] * 3),
    "small weights": _arrays([0.3, -4.0, 2.0], [1.0, 1.0, 0.0], [1.0, 0.04, 0.001]),
    "one pair": _arrays([-0.7], [1.0], [0.25]),
    "50 pairs": _random(50, 1),
    "7 pairs": _random(7, 2),
}
SURE = {
    "very sure, and right": _arrays([1000.0, -1000.0], [1.0, 0.0], [1.0, 1.0]),
    "very sure, and wrong": _arrays([60.0, -1000.0, 1000.0], [0.0, 1.0, 0.25], [1.0] * 3),
    "sure, and wrong": _arrays([45.0, -45.0], [0.0, 1.0], [1.0, 3.0]),
}
MISTAKES = """
a loss is positive: turn its sign round
    return float -> return -float
pairs that are not reached count too: there is a second term, with 1 - y
    np.logaddexp(0.0, logits) - labels * logits -> labels * np.logaddexp(0, -logits)
pairs that are reached count too: there is a term with y
    np.logaddexp(0.0, logits) - labels * logits -> (1 - labels) * np.logaddexp(0, logits)
the wrong way round: a high logit predicts that the target will be reached
    - labels -> - (1 - labels)
the term y z is missing: without it the labels do not count
    - labels * logits -> - 0
it is log(1 + exp(z)) minus y z, not plus
    - labels -> + labels
np.logaddexp(0, z) is log(exp(0) + exp(z)); with 1 in place of 0 it is log(e + exp(z))
    np.logaddexp(0.0, -> np.logaddexp(1,
the logarithm is the natural one, np.log
    weights * each -> weights * each / np.log(2)
the logarithm is the natural one, not that to the base 10
    weights * each -> weights * each / np.log(10)
labels may lie between 0 and 1: do not round them
    - labels -> - (labels > 0.5)
labels may lie between 0 and 1: one is not always either 1 or 0
    - labels -> - (labels == 1)
divide by the sum of the weights, not by the largest one
    / weights.sum() -> / weights.max()
a weight multiplies the whole loss of its pair, not only the part with the label
    (weights * each).sum() / weights.sum() -> each.mean()
    - labels -> - weights * labels
a weight says how much a pair counts, not only whether it does
    (weights * each).sum() / weights.sum() -> each[weights > 0].mean()
the weights do not count yet
    (weights * each).sum() / weights.sum() -> each.mean()
divide by the sum of the weights, not by the number of pairs
    / weights.sum() -> / len(weights)
divide by the sum of the weights, not by the number of those above 0
    / weights.sum() -> / (weights > 0).sum()
that is the sum; divide it by the sum of the weights
    / weights.sum() -> / 1
that is the squared error, not the cross-entropy
    np.logaddexp(0.0, logits) - labels * logits -> (1 / (1 + np.exp(-logits)) - labels) ** 2
that is the absolute error, which is smallest for a claim of 0 or 1
    np.logaddexp(0.0, logits) - labels * logits -> np.abs(1 / (1 + np.exp(-logits)) - labels)
logits are no probabilities; the sigmoid makes them so
    np.logaddexp(0.0, logits) - labels * logits -> -labels * np.log(p) - (1 - labels) * np.log1p(-p)
    each = -> p = np.clip(logits, 1e-7, 1 - 1e-7); each =
the sigmoid is taken twice: the loss wants logits
    each = -> logits = 1 / (1 + np.exp(-logits)); each =
a median or an average without weights is no weighted mean
    (weights * each).sum() / weights.sum() -> np.median(each)
"""
_HINTS: dict[type[Exception], str] = {
    ValueError: "all three are (N,), and the loss is one number",
    TypeError: "logits, labels and weights are arrays (N,), so use numpy's functions, not math's",
    ZeroDivisionError: "weights may hold a 0; divide by their sum only",
    OverflowError: "exp(1000) is too large a number; np.logaddexp(0, z) is log(1 + exp(z))",
    NameError: "is it imported, and spelt right?",
    IndexError: "all three are (N,); N can be 1",
}


def _form(what: str, got: Any, logits: Array, *_: object) -> float:  # noqa: ANN401 - students'
    if isinstance(got, np.ndarray) and got.shape == logits.shape and len(logits) > 1:
        raise WrongAnswer(f"{what}: one loss for each pair came back; return their weighted mean")
    return one_number(what, got, "the weighted mean of the losses")


def _broken(got: float, want: float, logits: Array, labels: Array, weights: Array) -> str:
    """Which part of the rule a wrong loss breaks."""
    if abs(got - want) < 1e-3 * abs(want):
        return "nearly right: is something rounded, or of 32 bits? Keep all digits of all numbers"
    if np.ptp(weights) == 0.0:
        return "the loss of each pair is log(1 + exp(z)) - y z, by logit z and label y as they are"
    return "the loss of each pair times its weight, however small; the sum over that of the weights"


def _apart(got: float, want: float, logits: Array, labels: Array, *_: Array) -> str:
    """A loss that no known mistake gives, beside the right one."""
    if np.isnan(got):
        return "the loss is not a number; is something divided by zero, or log taken of it?"
    first = reach_loss(logits[:1], labels[:1], np.ones(1))
    words = f"the first pair, with z = {logits[0]:.3g} and y = {labels[0]:.3g}, has the loss"
    mine, right = both(got, want)
    return f"{mine}, but {right} is right; {words} {first:.4g} alone"


def _limited(got: float, want: float, *case: Array) -> str:
    """How the loss of sure predictions was computed, if not from logits."""
    if not np.isfinite(got):
        words = "infinite, since exp(1000) is too large a number"
        if np.isnan(got):
            words = "not a number, since log(0) was taken, of a probability that is exactly 0 or 1"
        return f"the loss is {words}; np.logaddexp(0, z) is log(1 + exp(z)) for every z"
    mine, right = both(got, want)
    if abs(got) < abs(want):
        words = "the probability was clipped, or the logit: a mistake costs the same however sure"
        words = f"{words} the network was; take the logit as it is"
        return f"{mine}, but {right} is right: {words}"
    return f"{mine}, but {right} is right; stay with the logit, by the second form"


check_reach_loss = exercise(
    reach_loss,
    CASES,
    MISTAKES,
    about="Hard and soft labels, weights, and logits whose exponential overflows.",
    example=case(np.linspace(-4, 4, 4000), np.linspace(0, 1, 4000), np.ones(4000)),
    later={"cases": SURE, "difference": _limited, "broken": lambda *_: ""},
    invoke=calling(_HINTS),
    form=_form,
    same=lambda got, want, *_: bool(np.isclose(got, want, rtol=1e-6, atol=1e-7)),
    difference=_apart,
    broken=_broken,
)
