"""The check of the filter's prediction, in notebook 07."""

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.checks.engine import calling, close, exercise, numbers
from tutorial_lib.checks.framework.wording import both
from tutorial_lib.checks.nb07.small_models import random_beliefs, random_model
from tutorial_lib.geometry import Array


def predict(belief: Array, motion: Array, lengths: Array, onward: Array) -> Array:
    """The prior (N, V + 1) after N robots have moved by `motion` (N,); see the exercise."""
    leave = 1.0 - np.exp(-motion[:, None] / lengths)
    arrives = (belief * leave) @ onward
    return belief * (1.0 - leave) + arrives


def _moved(motion: ArrayLike, vertices: int, seed: int) -> tuple[Array, ...]:
    """Robots that moved by `motion` (N,) on a map drawn at random."""
    motion = np.asarray(motion)
    return random_beliefs(len(motion), vertices, seed), motion, *random_model(vertices, seed)


def _case(robots: int, vertices: int, seed: int, most: float) -> tuple[Array, ...]:
    return _moved(np.random.default_rng(seed).uniform(0.0, most, robots), vertices, seed)


CASES = {
    "one robot that moved half a metre": (
        np.array([[1.0, 0.0, 0.0]]),
        np.array([0.5]),
        np.array([1.0, 2.0, 1.0]),
        np.eye(3)[[1, 2, 0]],
    ),
    "three robots, each with its own motion": _case(3, 4, 1, 1.0),
    "one robot moves, two stand still": _moved([0.0, 0.7, 0.0], 4, 7),
    "robots that moved far": _case(3, 5, 2, 9.0),
    "a robot that did not move": _moved([0.0], 4, 3),
    "one vertex": _case(2, 1, 4, 2.0),
    "many vertices": _case(4, 12, 5, 1.0),
    "motions of a few centimetres and less": _moved([0.03, 0.004, 0.012], 4, 8),
    "motions of a millimetre and less": _moved([0.001, 0.0003, 0.0001], 4, 9),
}
MISTAKES = """
off the map is a state like the others: it has a length and a row of onward, and a share of it
leaves as well
    arrives = -> leave[:, -1] = 0.0; arrives =
off the map is a state like the others: what leads there arrives there, in the last column
    return -> arrives[:, -1] = 0.0; return
each robot has moved on its own: one may stand still while another moves
    return belief * -> return belief.copy() if (motion == 0).any() else belief *
what arrives is the sum over all states that lead there, not the greatest of them
    (belief * leave) @ onward -> ((belief * leave)[:, :, None] * onward).max(axis=1)
motion / length, not length / motion: the further it went, the more leaves
    motion[:, None] / lengths -> lengths / motion[:, None]
1 - exp(-motion / length), with a minus in the power
    np.exp(-motion -> np.exp(motion
the share that leaves is 1 - exp(-motion / length), not motion / length
    1.0 - np.exp(-motion[:, None] / lengths) -> np.minimum(motion[:, None] / lengths, 1.0)
the share that leaves is 1 - exp(-motion / length); motion / length may be more than 1
    1.0 - np.exp(-motion[:, None] / lengths) -> motion[:, None] / lengths
exp(-motion / length) is the share that stays; 1 minus that leaves
    leave = 1.0 - -> leave =
only a share of the belief leaves each vertex; in yours all of it does
    leave = 1.0 - -> leave = 1.0 - 0.0 *
the lengths differ: divide by that of each vertex, not by their mean
    / lengths -> / lengths.mean()
motion / length, not motion times length: a long edge is left later
    / lengths -> * lengths
each robot has moved on its own; yours moves all as the first one
    motion[:, None] -> motion[:1, None]
row v of onward tells where v leads: (belief * leave) @ onward, not its transpose
    @ onward -> @ onward.T
the share that leaves is that of the vertex it comes from: belief * leave first, then @ onward
    (belief * leave) @ onward -> (belief @ onward) * leave
only what leaves arrives elsewhere, not the whole belief
    (belief * leave) @ -> belief @
what does not leave stays: add belief * (1 - leave)
    return belief * (1.0 - leave) + arrives -> return arrives
what leaves a vertex is no longer there: take it away
    belief * (1.0 - leave) -> belief
small motions count as well: many of them make a large one
    motion[:, None] -> np.where(motion < 0.05, 0.0, motion)[:, None]
each robot has moved on its own; yours moves all by their mean
    motion[:, None] -> motion.mean()
a robot may have moved far: do not cut its motion off
    motion[:, None] -> np.minimum(motion, 1.0)[:, None]
the share that stays is exp(-motion / length), to base e
    -motion[:, None] -> -np.log(2.0) * motion[:, None]
the share that leaves depends on the motion, not on the length alone
    motion[:, None] -> 1.0
what leaves arrives over one edge, however far the robot has moved
    return -> far = motion[:, None] > 2 * lengths.mean(); return
    + arrives -> + np.where(far, arrives @ onward, arrives)
from off the map a robot comes back: onward has a row for it as well
    (belief * leave) @ onward -> (belief * leave)[:, :-1] @ onward[:-1]
what leaves must arrive somewhere: (belief * leave) @ onward is missing
    (1.0 - leave) + arrives -> (1.0 - leave)
"""


def _broken(got: Array, want: Array, belief: Array, motion: Array, *_: Array) -> str:
    """Which part of the rule is broken."""
    still = (motion > 0) & np.isclose(got, belief, rtol=0, atol=1e-12).all(axis=1)
    if still.any() and motion[still].max() < _SMALL:
        return "small motions count as well: many of them make a large one"
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
    return f"robot {row}, {name}: {mine}, but {right} is right"


_SMALL = 0.3  # metres
_SHAPES = "motion[:, None] / lengths has the shape (N, V + 1) of belief"
check_predict = exercise(
    predict,
    CASES,
    MISTAKES,
    about="One robot and several, near and far, at rest and not.",
    example=_case(4, 60, 6, 1.0),
    calls=300,
    invoke=calling({ValueError: _SHAPES, IndexError: _SHAPES}),
    form=lambda what, got, belief, *_: numbers(what, got, belief.shape),
    same=partial(close, tolerance=1e-9),
    difference=_why,
    broken=_broken,
)
