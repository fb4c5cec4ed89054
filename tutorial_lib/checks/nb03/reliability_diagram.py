"""The check of the reliability diagram, in notebook 03."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import call, parts
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import reliability

Diagram = tuple[Array, Array, float]


def reliability_diagram(predicted: Array, came_true: Array, bins: int) -> Diagram:
    """Mean prediction (B,) and share that came true (B,) in bins of equal mass, and the ECE."""
    found = reliability(predicted, came_true, bins)
    return found.predicted, found.measured, found.ece


_PREDICTED = np.random.default_rng(3).beta(1.2, 0.6, 203)


_CAME_TRUE = (np.random.default_rng(4).random(203) < _PREDICTED**1.7).astype(float)


@check(reliability_diagram, (np.repeat(_PREDICTED, 10), np.repeat(_CAME_TRUE, 10), 10))
def check_reliability_diagram(student: Callable[..., Any]) -> None:
    """203 predictions in ten bins of equal mass, most of them near 1; and four in two."""
    few = np.array([0.9, 0.1, 0.6, 0.2]), np.array([1.0, 0.0, 0.0, 0.0]), 2
    cases = (("203 predictions", (_PREDICTED, _CAME_TRUE, 10)), ("four predictions", few))
    for name, case in cases:
        wanted = reliability_diagram(*case)
        with np.errstate(all="ignore"):
            got = call(student, *case)
        words = "return three things: predicted, measured, ece"
        answers = parts("reliability_diagram", got, 3, words)
        names = ("predicted", "measured", "ece")
        for part, *values in zip(names, answers, wanted, _mistakes(*case), strict=True):
            answer, want, mistakes = values
            expect_close(f"{part}, {name}", answer, want, 1e-9, mistakes)


def _mistakes(
    predicted: Array, came_true: Array, bins: int
) -> tuple[dict[str, Array], dict[str, Array], dict[str, float]]:
    """Known mistakes of the three answers, and what they give."""
    order = np.argsort(predicted, kind="stable")
    parts, plain = np.array_split(order, bins), np.array_split(np.arange(len(order)), bins)
    number = np.clip((predicted * bins).astype(int), 0, bins - 1)
    wide = [np.flatnonzero(number == b) for b in range(bins)]

    def means(values: Array, groups: list[Array]) -> Array:
        return np.array([values[group].mean() if len(group) else np.nan for group in groups])

    predictions, measured = means(predicted, parts), means(came_true, parts)
    gap, count = np.abs(predictions - measured), np.array([len(part) for part in parts])
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
        "predictions come first, what came true second": measured,
        rising: predictions[::-1],
    }
    second = {
        "what came true belongs to its prediction: put both in the same order": means(
            came_true, plain
        ),
        "what came true belongs to its prediction: do not sort it by itself": means(
            np.sort(came_true), plain
        ),
        "give the share that came true, not how many": measured * count,
        rising: measured[::-1],
    }
    signed = float(((predictions - measured) * count).sum() / count.sum())
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
