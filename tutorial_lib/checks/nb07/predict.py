"""The check of the filter's prediction, in notebook 07."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import calling, numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close, compare, with_faults
from tutorial_lib.checks.nb07.small_differences import both, of_rounding
from tutorial_lib.checks.nb07.small_models import random_beliefs, random_model
from tutorial_lib.geometry import Array


def predict(belief: Array, motion: Array, lengths: Array, onward: Array) -> Array:
    """The prior (N, V + 1) after N robots have moved by `motion` (N,); see the exercise."""
    return _predicted(belief, motion, lengths, onward)


def _predicted(
    belief: Array, motion: Array, lengths: Array, onward: Array, fault: str = ""
) -> Array:
    """The prediction, with a `fault` if one is named."""
    motion = {
        "small dropped": np.where(motion < 0.05, 0.0, motion),
        "mean motion": np.full_like(motion, motion.mean()),
        "capped": np.minimum(motion, 1.0),
        "base 2": motion * np.log(2.0),
        "no motion": np.ones_like(motion),
    }.get(fault, motion)
    ratio = motion[:, None] / (lengths.mean() if fault == "same length" else lengths)
    if fault == "first robot":
        ratio = np.tile(ratio[:1], (len(belief), 1))
    if fault == "times":
        ratio = motion[:, None] * lengths
    if fault == "inverted":
        with np.errstate(divide="ignore"):
            ratio = lengths / motion[:, None]
    leave = 1.0 - np.exp(ratio if fault == "sign" else -ratio)
    leave = {
        "linear": np.minimum(ratio, 1.0),
        "unclipped": ratio,
        "stays": np.exp(-ratio),
        "all": np.ones_like(ratio),
    }.get(fault, leave)
    if fault == "off stays":
        leave[:, -1] = 0.0
    if fault == "one rests" and (motion == 0).any():
        return belief
    ways = onward.T if fault == "transposed" else onward
    arrives = (belief * leave) @ ways
    if fault == "no way back":
        arrives = (belief * leave)[:, :-1] @ ways[:-1]
    if fault == "two edges":
        far = motion[:, None] > 2 * lengths.mean()
        arrives = np.where(far, arrives @ ways, arrives)
    if fault == "greatest":
        arrives = ((belief * leave)[:, :, None] * ways).max(axis=1)
    if fault == "off never reached":
        arrives[:, -1] = 0.0
    if fault == "leave after":
        arrives = (belief @ ways) * leave
    if fault == "all arrives":
        arrives = belief @ ways
    return {
        "lost": arrives,
        "kept twice": belief + arrives,
        "nothing arrives": belief * (1.0 - leave),
    }.get(fault, belief * (1.0 - leave) + arrives)


_FAULTS = {
    "off the map is a state like the others: it has a length and a row of onward, and a share of "
    "it leaves as well": "off stays",
    "off the map is a state like the others: what leads there arrives there, in the last column": (
        "off never reached"
    ),
    "each robot has moved on its own: one may stand still while another moves": "one rests",
    "what arrives is the sum over all states that lead there, not the greatest of them": "greatest",
    "motion / length, not length / motion: the further it went, the more leaves": "inverted",
    "1 - exp(-motion / length), with a minus in the power": "sign",
    "the share that leaves is 1 - exp(-motion / length), not motion / length": "linear",
    "the share that leaves is 1 - exp(-motion / length); motion / length may be more than 1": (
        "unclipped"
    ),
    "exp(-motion / length) is the share that stays; 1 minus that leaves": "stays",
    "only a share of the belief leaves each vertex; in yours all of it does": "all",
    "the lengths differ: divide by that of each vertex, not by their mean": "same length",
    "motion / length, not motion times length: a long edge is left later": "times",
    "each robot has moved on its own; yours moves all as the first one": "first robot",
    "row v of onward tells where v leads: (belief * leave) @ onward, not its transpose": (
        "transposed"
    ),
    "what leaves is that of the vertex it comes from: belief * leave first, then @ onward": (
        "leave after"
    ),
    "only what leaves arrives elsewhere, not the whole belief": "all arrives",
    "what does not leave stays: add belief * (1 - leave)": "lost",
    "what leaves a vertex is no longer there: take it away": "kept twice",
    "small motions count as well: many of them make a large one": "small dropped",
    "each robot has moved on its own; yours moves all by their mean": "mean motion",
    "a robot may have moved far: do not cut its motion off": "capped",
    "the share that stays is exp(-motion / length), to base e": "base 2",
    "the share that leaves depends on the motion, not on the length alone": "no motion",
    "what leaves arrives over one edge, however far the robot has moved": "two edges",
    "from off the map a robot comes back: onward has a row for it as well": "no way back",
    "what leaves must arrive somewhere: (belief * leave) @ onward is missing": "nothing arrives",
}


def _case(robots: int, vertices: int, seed: int, most: float) -> tuple[Array, ...]:
    rng = np.random.default_rng(seed)
    motion = rng.uniform(0.0, most, robots)
    return random_beliefs(robots, vertices, seed), motion, *random_model(vertices, seed)


_CASES = {
    "one robot that moved half a metre": (
        np.array([[1.0, 0.0, 0.0]]),
        np.array([0.5]),
        np.array([1.0, 2.0, 1.0]),
        np.eye(3)[[1, 2, 0]],
    ),
    "three robots, each with its own motion": _case(3, 4, 1, 1.0),
    "one robot moves, two stand still": (
        random_beliefs(3, 4, 7),
        np.array([0.0, 0.7, 0.0]),
        *random_model(4, 7),
    ),
    "robots that moved far": _case(3, 5, 2, 9.0),
    "a robot that did not move": (random_beliefs(1, 4, 3), np.zeros(1), *random_model(4, 3)),
    "one vertex": _case(2, 1, 4, 2.0),
    "many vertices": _case(4, 12, 5, 1.0),
    "motions of a few centimetres and less": (
        random_beliefs(3, 4, 8),
        np.array([0.03, 0.004, 0.012]),
        *random_model(4, 8),
    ),
}


@check(predict, _case(4, 60, 6, 1.0), calls=300)
def check_predict(student: Callable[..., Any]) -> None:
    """One robot and several, near and far, at rest and not."""
    shapes = "motion[:, None] / lengths has the shape (N, V + 1) of belief"
    compare(
        "predict",
        student,
        _CASES,
        predict,
        with_faults(_predicted, _FAULTS),
        invoke=calling({ValueError: shapes, IndexError: shapes}),
        form=lambda what, got, belief, *_: numbers(what, got, belief.shape),
        same=partial(close, tolerance=1e-9),
        difference=_why,
        broken=_broken,
    )


def _broken(got: Array, want: Array, *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    if of_rounding(got, want):
        return ""
    if not np.allclose(got.sum(axis=1), 1.0, atol=1e-4):
        return (
            "nothing is lost or gained: what leaves a state arrives where its row of onward "
            "leads, the rest stays; off the map is a state like the others"
        )
    return (
        "1 - exp(-metres / length) of the belief leaves, by each robot's own motion, unrounded, "
        "and each state's own length"
    )


def _why(got: Array, want: Array, *_: Any) -> str:  # noqa: ANN401
    """Where a prior is wrong."""
    sums = got.sum(axis=1)
    row = int(np.abs(got - want).max(axis=1).argmax())
    if np.isnan(got).any():
        return "some of it is not a number; is something divided by zero?"
    if not np.isclose(sums[row], 1.0, atol=1e-4):
        return f"the prior of robot {row} sums to {both(sums[row], 1.0)[0]}, not to 1"
    place = int(np.abs(got - want)[row].argmax())
    mine, right = both(got[row, place], want[row, place])
    name = "off the map" if place == want.shape[1] - 1 else f"vertex {place}"
    return f"robot {row}, {name}: {mine}, but {right} is right{of_rounding(got, want)}"
