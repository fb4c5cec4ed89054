"""The check of the loss of RE, in notebook 03."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.nb03.forms import calling, one_number
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import sigmoid

Case = tuple[Array, Array, Array]
"""logits, labels and weights, (N,) each."""


def reach_loss(logits: Array, labels: Array, weights: Array) -> float:
    """Weighted mean of the cross-entropy of logits (N,) with labels (N,) in [0, 1]."""
    return float(np.average(_each(logits, labels), weights=weights))


def _each(logits: Array, labels: Array) -> Array:
    return np.logaddexp(0.0, logits) - labels * logits


def _case(logits: list[float], labels: list[float], weights: list[float]) -> Case:
    return np.array(logits), np.array(labels), np.array(weights)


def _random(count: int, seed: int) -> Case:
    """Soft and hard labels, and weights of which some are 0."""
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random(count) < 0.5, rng.integers(2, size=count), rng.random(count))
    weights = rng.uniform(0.0, 3.0, count) * (rng.random(count) < 0.8)
    return rng.normal(0.5, 3.0, count), labels, np.append(weights[:-1], 0.7)


_CASES: dict[str, Case] = {
    "hard labels": _case([0.3, -1.2, 2.0, -0.5], [1.0, 0.0, 0.0, 1.0], [1.0] * 4),
    "soft labels": _case([0.3, -1.2, 2.0, -0.5], [0.7, 0.04, 0.55, 0.2], [1.0] * 4),
    "weights": _case(
        [0.3, -1.2, 2.0, -0.5, 1.0], [1.0, 0.0, 0.0, 1.0, 0.3], [1.0, 0.5, 2.0, 0.0, 3.0]
    ),
    "equal weights of 2": _case([0.3, -1.2, 2.0], [1.0, 0.0, 0.0], [2.0] * 3),
    "small weights": _case([0.3, -4.0, 2.0], [1.0, 1.0, 0.0], [1.0, 0.04, 0.001]),
    "one pair": _case([-0.7], [1.0], [0.25]),
    "50 pairs": _random(50, 1),
    "7 pairs": _random(7, 2),
}
_SURE: dict[str, Case] = {
    "very sure, and right": _case([1000.0, -1000.0], [1.0, 0.0], [1.0, 1.0]),
    "very sure, and wrong": _case([60.0, -1000.0, 1000.0], [0.0, 1.0, 0.25], [1.0] * 3),
    "sure, and wrong": _case([45.0, -45.0], [0.0, 1.0], [1.0, 3.0]),
}
_SMALLEST = (1e-16, 1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
_HINTS: dict[type[Exception], str] = {
    ValueError: "all three are (N,), and the loss is one number",
    TypeError: "logits, labels and weights are arrays (N,), so use numpy's functions, not math's",
    ZeroDivisionError: "weights may hold a 0; divide by their sum only",
    OverflowError: "exp(1000) is too large a number; np.logaddexp(0, z) is log(1 + exp(z))",
    NameError: "is it imported, and spelt right?",
    IndexError: "all three are (N,); N can be 1",
}


@check(reach_loss, (np.linspace(-4, 4, 4000), np.linspace(0, 1, 4000), np.ones(4000)))
def check_reach_loss(student: Callable[..., Any]) -> None:
    """Hard and soft labels, weights, and logits whose exponential overflows."""
    rules = partial(compare, "reach_loss", student, right=reach_loss, form=_form)
    rules = partial(rules, invoke=calling(_HINTS), same=_same)
    rules(_CASES, faults=_FAULTS, difference=_apart, broken=_broken)
    rules(_SURE, faults={}, difference=_limited)


def _form(what: str, got: Any, logits: Array, *_: object) -> float:  # noqa: ANN401 - students'
    if isinstance(got, np.ndarray) and got.shape == logits.shape and len(logits) > 1:
        raise WrongAnswer(f"{what}: one loss for each pair came back; return their weighted mean")
    return one_number(what, got, "the weighted mean of the losses")


def _same(got: float, want: float, *_: object) -> bool:
    return bool(np.isclose(got, want, rtol=1e-6, atol=1e-7))


def _broken(got: float, want: float, logits: Array, labels: Array, weights: Array) -> str:
    """Which part of the rule a wrong loss breaks."""
    if abs(got - want) < 1e-3 * abs(want):
        return "nearly right: is something rounded, or of 32 bits? Keep all digits of all numbers"
    if np.ptp(weights) == 0.0:
        return "the loss of each pair is log(1 + exp(z)) - y z, by logit z and label y as they are"
    return "the loss of each pair times its weight, however small; the sum over that of the weights"


def _apart(got: float, want: float, *case: Array) -> str:
    """A loss that no known mistake gives, beside the right one."""
    if np.isnan(got):
        return "the loss is not a number; is something divided by zero, or log taken of it?"
    first = float(_each(case[0][:1], case[1][:1])[0])
    words = f"the first pair, with z = {case[0][0]:.3g} and y = {case[1][0]:.3g}, has the loss"
    return f"{got:.4g}, but {want:.4g} is right; {words} {first:.4g} alone"


def _limited(got: float, want: float, *case: Array) -> str:
    """How the loss of sure predictions was computed, if not from logits."""
    if not np.isfinite(got):
        words = "infinite, since exp(1000) is too large a number"
        if np.isnan(got):
            words = "not a number, since log(0) was taken, of a probability that is exactly 0 or 1"
        return f"the loss is {words}; np.logaddexp(0, z) is log(1 + exp(z)) for every z"
    if abs(got) < abs(want):
        words = "the probability was clipped, so that a mistake costs the same however sure"
        return f"{got:.4g}, but {want:.4g} is right: {words} the network was; stay with the logit"
    return f"{got:.4g}, but {want:.4g} is right; stay with the logit, by the second form"


def _entropy(probability: Array, labels: Array, weights: Array) -> float:
    """The loss from probabilities, as in textbooks."""
    with np.errstate(all="ignore"):
        each = -labels * np.log(probability) - (1 - labels) * np.log1p(-probability)
    return float(np.average(each, weights=weights))


def _loss(each: Callable[[Array, Array], Array]) -> Callable[..., float]:
    """A loss with another loss of each pair."""
    return lambda z, y, w: float(np.average(each(z, y), weights=w))


_FAULTS: dict[str, Callable[..., float]] = {
    "a loss is positive: turn its sign round": lambda *case: -reach_loss(*case),
    "pairs that are not reached count too: there is a second term, with 1 - y": _loss(
        lambda z, y: y * np.logaddexp(0.0, -z)
    ),
    "pairs that are reached count too: there is a term with y": _loss(
        lambda z, y: (1 - y) * np.logaddexp(0.0, z)
    ),
    "the wrong way round: a high logit predicts that the target will be reached": _loss(
        lambda z, y: _each(z, 1 - y)
    ),
    "the term y z is missing: without it the labels do not count": _loss(
        lambda z, y: np.logaddexp(0.0, z)
    ),
    "it is log(1 + exp(z)) minus y z, not plus": _loss(lambda z, y: np.logaddexp(0.0, z) + y * z),
    "np.logaddexp(0, z) is log(exp(0) + exp(z)); with 1 in place of 0 it is log(e + exp(z))": _loss(
        lambda z, y: np.logaddexp(1.0, z) - y * z
    ),
    "the logarithm is the natural one, np.log": _loss(lambda z, y: _each(z, y) / np.log(2)),
    "the logarithm is the natural one, not that to the base 10": _loss(
        lambda z, y: _each(z, y) / np.log(10)
    ),
    "labels may lie between 0 and 1: do not round them": _loss(lambda z, y: _each(z, y > 0.5)),
    "labels may lie between 0 and 1: one is not always either 1 or 0": _loss(
        lambda z, y: _each(z, y == 1)
    ),
    "divide by the sum of the weights, not by the largest one": (
        lambda z, y, w: (w * _each(z, y)).sum() / w.max()
    ),
    "a weight multiplies the whole loss of its pair, not only the part with the label": (
        lambda z, y, w: (np.logaddexp(0, z) - w * y * z).mean()
    ),
    "a weight says how much a pair counts, not only whether it does": (
        lambda z, y, w: _each(z, y)[w > 0].mean()
    ),
    "the weights do not count yet": lambda z, y, w: float(_each(z, y).mean()),
    "divide by the sum of the weights, not by the number of pairs": lambda z, y, w: float(
        (w * _each(z, y)).mean()
    ),
    "divide by the sum of the weights, not by the number of those above 0": lambda z, y, w: float(
        (w * _each(z, y)).sum() / (w > 0).sum()
    ),
    "that is the sum; divide it by the sum of the weights": lambda z, y, w: float(
        (w * _each(z, y)).sum()
    ),
    "that is the squared error, not the cross-entropy": _loss(lambda z, y: (sigmoid(z) - y) ** 2),
    "that is the absolute error, which is smallest for a claim of 0 or 1": _loss(
        lambda z, y: np.abs(sigmoid(z) - y)
    ),
    "logits are no probabilities; the sigmoid makes them so": lambda z, y, w: _entropy(
        np.clip(z, 1e-7, 1 - 1e-7), y, w
    ),
    "the sigmoid is taken twice: the loss wants logits": _loss(lambda z, y: _each(sigmoid(z), y)),
    "a median or an average without weights is no weighted mean": lambda z, y, w: float(
        np.median(_each(z, y))
    ),
}
