"""The check of temperature scaling, in notebook 03."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect, expect_close
from tutorial_lib.checks.nb03.reach_loss import reach_loss
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import reliability, sigmoid

_TEMPERATURES = np.geomspace(0.05, 20.0, 600)


def fit_temperature(logits: Array, labels: Array) -> float:
    """The temperature for which the loss of logits (N,) over it is smallest, to one percent."""
    return float(_TEMPERATURES[_losses(logits, labels).argmin()])


def _losses(logits: Array, labels: Array) -> Array:
    """(600,) loss at each temperature."""
    ones = np.ones(len(logits))
    return np.array([reach_loss(logits / t, labels, ones) for t in _TEMPERATURES])


def _logits(temperature: float, blunders: float = 0.0, soft: bool = False) -> tuple[Array, Array]:
    """Logits (600,) that should be divided by about this temperature, and labels.

    A share of `blunders` turns out the opposite of what is expected; squared errors mind it less.
    """
    rng = np.random.default_rng(7)
    logits = rng.normal(1.0, 2.0, 600) * temperature
    probability = blunders + (1 - 2 * blunders) * sigmoid(logits / temperature)
    return logits, probability if soft else (rng.random(600) < probability).astype(float)


@check(fit_temperature, _logits(2.5))
def check_fit_temperature(student: Callable[..., Any]) -> None:
    """An overconfident network, an underconfident one, and soft labels."""
    cases = (
        ("an overconfident network", _logits(2.0, blunders=0.12)),
        ("an underconfident network", _logits(0.4)),
        ("soft labels", _logits(1.8, soft=True)),
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
    probabilities = [sigmoid(logits / t) for t in _TEMPERATURES]
    squares = _TEMPERATURES[np.argmin([((p - labels) ** 2).mean() for p in probabilities])]
    errors = [reliability(p, labels).ece for p in probabilities]
    mistakes = {
        "that is 1 / T: the logits are divided by the temperature": 1 / best,
        "that is the smallest loss; give the temperature that has it": losses.min(),
        "that is the logarithm of the temperature": np.log(best),
        "a temperature below 1 is allowed, it makes a network more confident": 1.0,
        "the cross-entropy is to be smallest, not the squared error": squares,
        "the cross-entropy is to be smallest, not the ECE, which jumps when a pair changes bins": (
            _TEMPERATURES[np.argmin(errors)]
        ),
        "the loss is to be smallest, not largest": _TEMPERATURES[losses.argmax()],
    }
    same = partial(np.isclose, rtol=0.012)
    expect(what, got, best, mistakes.items(), same, _no_temperature)


def _no_temperature(got: float, best: float) -> str:
    """What is wrong with a temperature, when no known mistake gives it."""
    if got <= 0:
        return f"{got:.3g}, but a temperature is greater than 0"
    if got == int(got) and got >= len(_TEMPERATURES) / 100:
        words = "is that the index of the best temperature in a list? Give the temperature"
        return f"{got:.0f}; {words}"
    return f"{got:.4g}, but {best:.4g} is right"
