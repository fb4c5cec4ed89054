"""The check of the loss of RE, in notebook 03."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import sigmoid


def reach_loss(logits: Array, labels: Array, weights: Array) -> float:
    """Weighted mean of the cross-entropy of logits (N,) with labels (N,) in [0, 1]."""
    return float(np.average(np.logaddexp(0.0, logits) - labels * logits, weights=weights))


_CASES = (
    ("hard labels", [0.3, -1.2, 2.0, -0.5], [1.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]),
    ("soft labels", [0.3, -1.2, 2.0, -0.5], [0.7, 0.04, 0.55, 0.2], [1.0, 1.0, 1.0, 1.0]),
    ("weights", [0.3, -1.2, 2.0, -0.5, 1.0], [1.0, 0.0, 0.0, 1.0, 0.3], [1.0, 0.5, 2.0, 0.0, 3.0]),
    ("very sure, and right", [1000.0, -1000.0], [1.0, 0.0], [1.0, 1.0]),
    ("very sure, and wrong", [60.0, -1000.0, 1000.0], [0.0, 1.0, 0.25], [1.0, 1.0, 1.0]),
)


_CLIPS = (1e-16, 1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)


@check(reach_loss, (np.linspace(-4, 4, 4000), np.linspace(0, 1, 4000), np.ones(4000)))
def check_reach_loss(student: Callable[..., Any]) -> None:
    """Hard and soft labels, weights, and logits whose exponential overflows."""
    for name, *numbers in _CASES:
        case = [np.array(column) for column in numbers]
        what, want = f"reach_loss, {name}", reach_loss(*case)
        with np.errstate(all="ignore"):
            got, mistakes = call(student, *case), _mistakes(*case)
        if np.shape(got) == case[0].shape:
            raise WrongAnswer(f"{what}: one loss for each pair; return their weighted mean")
        if np.shape(got) == () and got is not None and name.startswith("very sure"):
            _expect_no_limit(what, float(got), want, case)
        expect_close(what, got, want, 1e-6 * (1 + want), mistakes)


def _expect_no_limit(what: str, got: float, want: float, case: list[Array]) -> None:
    """Demand that the loss neither overflows nor is clipped."""
    if not np.isfinite(got):
        words = "infinite, since exp(1000) is too large a number"
        if np.isnan(got):
            words = "not a number, since log(0) was taken, of a probability that is exactly 0 or 1"
        raise WrongAnswer(f"{what}: {words}; np.logaddexp(0, z) is log(1 + exp(z)) for every z")
    with np.errstate(over="ignore"):
        probability = sigmoid(case[0])
    for low in _CLIPS:
        limited = _entropy(np.clip(probability, low, 1.0 - low), *case[1:])
        if np.isclose(got, limited, rtol=0.02) and not np.isclose(got, want, rtol=0.02):
            words = "the probability was clipped, so that a mistake costs the same however sure"
            raise WrongAnswer(f"{what}: {words} the network was; stay with the logit")


def _entropy(probability: Array, labels: Array, weights: Array) -> float:
    """The loss from probabilities, as in textbooks."""
    with np.errstate(all="ignore"):
        each = -labels * np.log(probability) - (1 - labels) * np.log1p(-probability)
    return float(np.average(each, weights=weights))


def _mistakes(logits: Array, labels: Array, weights: Array) -> dict[str, float]:
    """Known mistakes, and the losses they give."""
    probability, nothing = sigmoid(logits), np.logaddexp(0.0, logits)
    each = nothing - labels * logits

    def mean(values: Array) -> float:
        return float(np.average(values, weights=weights))

    return {
        "a loss is positive: turn its sign round": -mean(each),
        "pairs that are not reached count too: there is a second term, with 1 - y": mean(
            labels * np.logaddexp(0.0, -logits)
        ),
        "the wrong way round: a high logit predicts that the target will be reached": mean(
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
        "that is the squared error, not the cross-entropy": mean((probability - labels) ** 2),
        "that is the absolute error, which is smallest for a claim of 0 or 1": mean(
            np.abs(probability - labels)
        ),
        "logits are no probabilities; the sigmoid makes them so": _entropy(
            np.clip(logits, 1e-7, 1 - 1e-7), labels, weights
        ),
    }
