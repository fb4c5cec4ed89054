"""The check of temperature scaling, in notebook 03."""

import numpy as np

from tutorial_lib.checks.engine import case, exercise
from tutorial_lib.checks.nb03.forms import calling, one_number
from tutorial_lib.checks.nb03.reach_loss import reach_loss
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import sigmoid

Case = tuple[Array, Array]
"""Logits and labels, (N,)."""
LOWEST, HIGHEST = 0.05, 20.0
"""The temperatures between which the best one is sought."""


def fit_temperature(logits: Array, labels: Array) -> float:
    """The temperature for which the loss of logits (N,) over it is smallest, to one percent."""
    temperatures = np.geomspace(LOWEST, HIGHEST, 600)
    z = logits / temperatures[:, None]
    losses = (np.logaddexp(0.0, z) - labels * z).mean(axis=1)
    best = temperatures[losses.argmin()]
    return float(best)


def _logits(
    temperature: float, blunders: float = 0.0, soft: bool = False, count: int = 300, seed: int = 7
) -> Case:
    """Logits that should be divided by about this temperature, and labels.

    A share of `blunders` turns out the opposite of what is expected; squared errors mind it less.
    """
    rng = np.random.default_rng(seed)
    logits = rng.normal(1.0, 2.0, count) * temperature
    probability = blunders + (1 - 2 * blunders) * sigmoid(logits / temperature)
    return logits, probability if soft else (rng.random(count) < probability).astype(float)


_OFTEN, _REACHED = _logits(1.6, soft=True, seed=5)
_ALWAYS = np.tile([-0.4, 0.3, 0.5, -0.2, 0.1], 8)
CASES = {
    "an overconfident network": _logits(2.0, blunders=0.12),
    "an underconfident network": _logits(0.4),
    "soft labels": _logits(1.8, soft=True),
    "a network that is hardly sure of anything": _logits(0.08, seed=3),
    "a network that is far too sure": _logits(14.0, seed=4),
    "a few pairs of which a network is wrongly very sure": case(
        np.concatenate([np.tile([1.0, -1.0], 100), np.full(40, 12.0)]),
        np.concatenate([np.tile([1.0, 0.0], 80), np.tile([0.0, 1.0], 20), np.arange(40) != 7]),
    ),
    # Most logits are below 0: without labels, the highest temperature is not the best.
    "a network that seldom predicts a success": (-_OFTEN, 1.0 - _REACHED),
    "few pairs": _logits(1.3, count=40, seed=8),
    "labels of which some are soft": case(
        np.array([2, 1, -1, 3, -2, 2, 1.0]), np.array([1, 0, 0, 1, 0, 0.5, 0.5])
    ),
    "a network that is hardly sure, whose best temperature is 0.065": _logits(0.065, soft=True),
    "a network that is always right, so that the lowest temperature is best": case(
        _ALWAYS, (_ALWAYS > 0).astype(float)
    ),
    "a network that is always wrong, so that the highest temperature is best": case(
        _ALWAYS, (_ALWAYS < 0).astype(float)
    ),
}
MISTAKES = """
that is 1 / T: the logits are divided by the temperature
    float(best) -> 1 / float(best)
that is the smallest loss; give the temperature that has it
    temperatures[losses.argmin()] -> losses.min()
that is the logarithm of the temperature
    float(best) -> float(np.log(best))
that is the temperature with a minus; it is greater than 0
    float(best) -> -float(best)
that is the index of the best temperature in a list; give the temperature
    temperatures[losses.argmin()] -> losses.argmin()
a temperature below 1 is allowed, it makes a network more confident
    float(best) -> max(float(best), 1.0)
a temperature above 1 is allowed, it makes a network less confident
    float(best) -> min(float(best), 1.0)
T is sought from 0.05 to 20; yours never comes below 0.1
    float(best) -> max(float(best), 0.1)
T is sought from 0.05 to 20; yours never comes above 10
    float(best) -> min(float(best), 10.0)
T is sought from 0.05 to 20; yours never comes above 5
    float(best) -> min(float(best), 5.0)
T is sought from 0.05 to 20; yours stays between 0.1 and 10
    float(best) -> min(max(float(best), 0.1), 10.0)
T is sought from 0.05 to 20; yours stays between 0.5 and 2
    float(best) -> min(max(float(best), 0.5), 2.0)
the best temperature comes back rounded; one percent of 0.35 is little
    float(best) -> round(float(best), 1)
a hundredth is more than one percent of 0.065: round nothing, and try values that grow by a factor
    float(best) -> round(float(best), 2)
T is sought from 0.05 to 20; yours stays between 0.5 and 5
    float(best) -> min(max(float(best), 0.5), 5.0)
the cross-entropy is to be smallest, not the squared error
    np.logaddexp(0.0, z) - labels * z -> (sigmoid(z) - labels) ** 2
the cross-entropy is to be smallest, not the absolute error
    np.logaddexp(0.0, z) - labels * z -> np.abs(sigmoid(z) - labels)
the labels do not count yet
    - labels * z -> - 0
yours gives 20 each time, the end of the range: the least loss decides, of logits / t and labels
    float(best) -> 20.0
a label of 1 means reached, as a logit above 0 does; yours has the labels the other way round
    - labels * z -> - (1 - labels) * z
labels may lie between 0 and 1: do not round them
    - labels -> - (labels > 0.5)
the labels are no weights: pairs that are not reached count too
    (np.logaddexp(0.0, z) - labels * z) -> (labels * (np.logaddexp(0.0, z) - labels * z))
the loss takes logits: no sigmoid before it
    logits / temperatures[:, None] -> sigmoid(logits / temperatures[:, None])
the logits are divided by T, not the probabilities
    logits / -> sigmoid(logits) /
the mean prediction may be right and each one wrong: the mean loss decides
    (np.logaddexp(0.0, z) - labels * z).mean(axis=1) -> np.abs((sigmoid(z) - labels).mean(axis=1))
the loss is to be smallest, not largest
    argmin -> argmax
the cross-entropy is to be smallest, not the ECE, which jumps when a pair changes bins
    (np.logaddexp(0.0, z) - labels * z).mean(axis=1) -> _ece(z, labels)
that is the index of the best temperature in a list; give the temperature itself
    temperatures[losses.argmin()] -> losses.argmin()
    600 -> 300
that is the index of the best temperature in a list; give the temperature, not its place
    temperatures[losses.argmin()] -> losses.argmin()
    600 -> 1000
that is the index of the best temperature in a list; give the temperature, a number from 0.05 to 20
    temperatures[losses.argmin()] -> losses.argmin()
    600 -> 100
"""
_HINTS: dict[type[Exception], str] = {
    ValueError: "logits and labels are (N,), and T is one number",
    TypeError: "logits / t is an array (N,) for each t; reach_loss wants weights, too, all 1",
    NameError: "is it imported, and spelt right?",
    ZeroDivisionError: "a temperature is greater than 0",
    IndexError: "the index of the best loss is the index of the best temperature",
}


def _ece(z: Array, labels: Array) -> Array:
    """The ECE, in ten bins, of each row of logits (T, N)."""
    order, gap = np.argsort(z[0]), sigmoid(z) - labels
    first = [part[0] for part in np.array_split(np.arange(len(order)), 10)]
    return np.abs(np.add.reduceat(gap[:, order], first, axis=1)).sum(axis=1)


def _same(got: float, want: float, *_: object) -> bool:
    """Whether two temperatures are equal but for two percent; other numbers, nearly equal."""
    if got > 0 and want > 0:
        return abs(np.log(got / want)) < 0.02
    return bool(np.isclose(got, want, atol=0.01))


def _apart(got: float, want: float, *case: Array) -> str:
    """What is wrong with a temperature, when no known mistake gives it."""
    if not np.isfinite(got):
        return f"{got} is no temperature; give a number from 0.05 to 20"
    if got <= 0:
        return f"{got:.3g}, but a temperature is greater than 0"
    if not 0.99 * LOWEST <= got <= 1.01 * HIGHEST:
        return f"{got:.4g}, but T is sought from 0.05 to 20"
    mine, best = (reach_loss(case[0] / t, case[1], np.ones(len(case[0]))) for t in (got, want))
    losses = f"with T = {got:.4g} the mean loss is {mine:.6f}, with T = {want:.4g} it is {best:.6f}"
    if abs(np.log(got / want)) < 0.5:
        return f"{losses}: near, but not to one percent"
    return f"{losses}, the smallest"


def _broken(got: float, want: float, *_: Array) -> str:
    """What to look at where no known mistake gives a temperature."""
    if not 0.99 * LOWEST <= got <= 1.01 * HIGHEST:
        return "where the loss falls up to an end of the range, T is that end, and no farther"
    if abs(np.log(got / want)) < 0.5:
        return (
            "give T to within one percent: try more values, which grow by a factor, with "
            "the logits as they are, and the best one unrounded"
        )
    return (
        "of all temperatures from 0.05 to 20 take that with the least mean of "
        "reach_loss(logits / T, labels): a formula, or a search from one side, may miss it"
    )


check_fit_temperature = exercise(
    fit_temperature,
    CASES,
    MISTAKES,
    about="Overconfident and underconfident networks, soft labels, and both ends of the range.",
    example=_logits(2.5),
    calls=10,
    invoke=calling(_HINTS),
    form=lambda what, got, *_: one_number(what, got, "the temperature T"),
    same=_same,
    difference=_apart,
    broken=_broken,
)
