"""The check of the push off obstacles, in notebook 02."""

import numpy as np

from tutorial_lib.checks.engine import case, exercise, hint, topics
from tutorial_lib.checks.nb02.policy_parts import differing, policies_of, same_policies
from tutorial_lib.driving.control.rmp_arithmetic import obstacle_policy

_RNG = np.random.default_rng(7)
_USUAL = (0.12, 0.3, 0.4, 0.1)
_DISTANCES = np.array([0.5, 0.2, 0.05])
_CLOSING = np.array([0.4, 0.3, 0.1])


def _random() -> tuple:
    count = int(_RNG.integers(1, 9))
    gains = _RNG.uniform([0.05, 0.05, 0.1, 0.05], [0.6, 0.6, 3.0, 0.5])
    return (_RNG.uniform(-0.05, 1, count), _RNG.uniform(-1, 1, count), *map(float, gains))


def _changed(place: int, *values: float) -> list[tuple]:
    gains = [[*_USUAL[:place], value, *_USUAL[place + 1 :]] for value in values]
    return [(_DISTANCES, _CLOSING, *each) for each in gains]


TOPICS = {
    "obstacles at rest": hint(
        "without closing speed: push / distance, and a metric that falls with the distance",
        (_DISTANCES, np.zeros(3), *_USUAL),
    ),
    "obstacles that come nearer": hint(
        "the brake times the closing speed is added to the push, before the division",
        *((_DISTANCES, scale * _CLOSING, *_USUAL) for scale in (1.0, 0.1, 5.0)),
    ),
    "obstacles that recede": hint(
        "a negative closing speed counts as 0: the push stays, the brake is off",
        (_DISTANCES, -_CLOSING, *_USUAL),
    ),
    "obstacles at 3 mm, at contact and overlapping": hint(
        "first limit the distances from below to 0.01 m; then use them in both formulas",
        (np.array([0.003, 0.0, -0.3]), np.array([0.0, 0.1, 0.2]), *_USUAL),
    ),
    "obstacles at 1.2 cm and at 3 m": hint(
        "only distances below 0.01 m are limited, and no obstacle is left out",
        (np.array([0.012, 3.0, 0.9]), np.array([0.1, 0.1, -0.1]), *_USUAL),
    ),
    "another push": hint(
        "the push is an argument; use it, and no number in its place", *_changed(0, 0.0, 0.5)
    ),
    "another brake": hint(
        "the brake is an argument; use it, and no number in its place", *_changed(1, 0.0, 0.9)
    ),
    "another weight": hint(
        "the weight is an argument; use it, and no number in its place", *_changed(2, 0.0, 3.0)
    ),
    "another fade": hint(
        "the fade is an argument, a length in metres; use it, and no number in its place",
        *_changed(3, 0.03, 0.6),
    ),
    "30 random groups of one to eight obstacles": hint(
        "the simple cases are right; does a part of your rule hold for some obstacles only?",
        *(_random() for _ in range(30)),
    ),
}
MISTAKES = """
the two are exchanged: give the accelerations first
    away, weight * np.exp(-distances / fade) -> weight * np.exp(-distances / fade), away
infinite or negative at contact: nearer than 0.01 m counts as 0.01 m, in both
    np.maximum(distances, 0.01) -> distances
nearer than 0.01 m counts as 0.01 m in the acceleration too, not only in the metric
    distances = np.maximum -> near = np.maximum
    -distances / fade -> -near / fade
nearer than 0.01 m counts as 0.01 m in the metric too, not only in the acceleration
    distances = np.maximum -> near = np.maximum
    / distances -> / near
a negative distance is nearer than 0.01 m too: np.maximum, not the absolute value
    np.maximum(distances, -> np.maximum(np.abs(distances),
0.01 m is the smallest distance; it is not added to every distance
    np.maximum(distances, 0.01) -> distances + 0.01
0.01 m is the smallest distance; it is not added, also not to those above 0
    np.maximum(distances, 0.01) -> np.maximum(distances, 0) + 0.01
the smallest distance is 0.01 m, 1 cm, not 2 cm
    0.01 -> 0.02
the smallest distance is 0.01 m, 1 cm, not 5 cm
    0.01 -> 0.05
a receding obstacle only pushes: its closing speed counts as 0
    np.maximum(closing, 0.0) -> closing
no brake for a receding obstacle: np.maximum(closing, 0), not the absolute value
    np.maximum(closing, 0.0) -> np.abs(closing)
the brake acts while the distance shrinks (closing > 0), not while it grows
    np.maximum(closing, -> np.maximum(-closing,
a receding obstacle still pushes: limit the closing speed from below, not the sum
    (push + brake * np.maximum(closing, 0.0)) -> np.maximum(push + brake * closing, 0)
an obstacle pushes even if it does not come nearer: only the brake depends on closing
    (push + brake * np.maximum(closing, 0.0)) -> np.where(closing > 0, push + brake * closing, 0)
it makes the distance grow: positive
    away = ( -> away = -(
the push and the brake are both divided by the distance
    (push + brake * np.maximum(closing, 0.0)) / distances
        -> push / distances + brake * np.maximum(closing, 0)
divide both terms by the distance, the push as well
    (push + brake * np.maximum(closing, 0.0)) / -> push + brake * np.maximum(closing, 0) /
divide by the distance: near obstacles push harder
    0.0)) / distances -> 0.0))
multiplied by the distance; divide: near obstacles push harder
    / distances -> * distances
divide by the distance itself, not by its square
    / distances -> / distances**2
while closing in, the brake comes on top of the push
    (push + brake * np.maximum(closing, 0.0)) -> push
the brake is missing its own factor: it is brake, not push, that multiplies closing
    brake * np -> push * np
each obstacle has its own distance; do not use the nearest for all
    / distances -> / distances.min()
each obstacle has its own distance; do not use the nearest one's for all
    np.maximum(distances, -> np.maximum(np.full(distances.shape, distances.min()),
`push` and `brake` are exchanged: it is the brake that multiplies closing
    push + brake * -> brake + push *
the brake multiplies the closing speed itself, not its square
    np.maximum(closing, 0.0) -> np.maximum(closing, 0) ** 2
the smallest distance is 0.01 m, 1 cm, not 1 mm
    0.01 -> 0.001
the smallest distance is 0.01 m, 1 cm, not 10 cm
    0.01 -> 0.1
limit the distances from below: np.maximum(distances, 0.01), not np.minimum
    np.maximum(distances -> np.minimum(distances
the acceleration is not weighted with the metric here; `resolve` does that
    return away, -> return away * weight * np.exp(-distances / fade),
each obstacle has its own closing speed; do not use the largest for all
    np.maximum(closing, 0.0) -> max(closing.max(), 0)
every obstacle has its weight, not only the nearest one
    distances = np -> nearest = distances == distances.min(); distances = np
    weight * -> nearest * weight *
the metric fades with distance: exp(-distance / fade)
    np.exp(-distances / fade) -> np.ones(distances.shape)
the metric has to fall with distance: the exponent is negative
    -distances -> distances
`fade` is a length: divide the distance by it
    / fade -> * fade
multiply by `weight`, the metric at contact
    weight * -> 1 *
the exponent is the distance divided by `fade`, not squared
    -distances / fade -> -((distances / fade) ** 2)
`weight` and `fade` are exchanged: weight * exp(-distance / fade)
    weight * np.exp(-distances / fade) -> fade * np.exp(-distances / weight)
the metric falls by the factor e every `fade` metres: np.exp, not powers of 2
    np.exp(-distances / fade) -> 2 ** (-distances / fade)
the metric fades exponentially, np.exp, not along a straight line
    np.exp(-distances / fade) -> np.maximum(0, 1 - distances / fade)
each metric stands alone; do not divide them by their sum
    / fade) -> / fade) / np.exp(-distances / fade).sum()
"""


check_obstacle_policy = exercise(
    obstacle_policy,
    topics(TOPICS),
    MISTAKES,
    about="The push off an obstacle: near and far, closing and receding, and at contact.",
    example=case(np.linspace(0.05, 1, 100), np.zeros(100), 0.12, 0.12, 0.3, 0.08),
    form=lambda what, got, distances, *_: policies_of(what, got, distances.shape, distances.shape),
    same=same_policies,
    difference=differing,
)
