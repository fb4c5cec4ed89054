"""The check of the pair encoder's first layer, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import call, parts
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array


def split_first_layer(weights: Array) -> tuple[Array, Array]:
    """The part of weights (F, 9, H, W) that applies to cur and to tgt, each (F, 3, H, W)."""
    own, other, difference = np.split(weights, 3, axis=1)
    return own + difference, other - difference


@check(split_first_layer, (np.ones((48, 9, 16, 5)),))
def check_split_first_layer(student: Callable[..., Any]) -> None:
    """Random weights of the first layer: shapes, then each half."""
    weights = np.random.default_rng(2).normal(size=(4, 9, 3, 5))
    a, b, d = np.split(weights, 3, axis=1)
    answer = call(student, weights)
    words = "return two arrays, for cur and for tgt"
    for_cur, for_tgt = parts("split_first_layer", answer, 2, words)
    forgot = "the third part sees cur - tgt, so both images: it belongs to both halves"
    mixed = "the channels are stacked: 0 to 2 are cur's, 3 to 5 tgt's, 6 to 8 the difference's"
    thirds = weights[:, 0::3] + weights[:, 2::3]
    first = {forgot: a, "that is the part of tgt; cur comes first": b - d, mixed: thirds}
    first |= {"cur enters the difference with a plus": a - d}
    second = {
        "tgt enters the difference with a minus": b + d,
        "tgt has the weights B of its own as well; only D changes its sign": -d,
        "D, not B, changes its sign": d - b,
        forgot: b,
    }
    expect_close("weights for cur", for_cur, a + d, 1e-9, first)
    expect_close("weights for tgt", for_tgt, b - d, 1e-9, second)
