"""The check of the pull to a goal, in notebook 02."""

import numpy as np

from tutorial_lib.checks.engine import case, exercise, hint, topics
from tutorial_lib.checks.nb02.policy_parts import differing, policies_of, same_policies
from tutorial_lib.driving.control.rmp_arithmetic import goal_policy

_RNG = np.random.default_rng(6)
_STILL, _MANY = np.zeros(2), _RNG.uniform(-3, 3, (4, 2))
_USUAL = (2.4, 3.0, 0.35)
_SHAPES = [(2,), (5, 2), (1, 2), (2, 3, 2)]
_RANDOM = [
    (
        _RNG.uniform(-2, 2, _SHAPES[i % 4]),
        _RNG.uniform(-1, 1, _SHAPES[i % 4]),
        *(float(g) for g in _RNG.uniform([0.5, 0.5, 0.1], [4.0, 5.0, 1.5])),
    )
    for i in range(24)
]
TOPICS = {
    "one point at rest, far from its goal": hint(
        "the offset divided by its length, times the gain; the metric is the 2 x 2 identity. "
        "One point has the shape (2,): use axis=-1",
        (np.array([3.0, 0.0]), _STILL, *_USUAL),
        (np.array([0.3, -1.2]), _STILL, *_USUAL),
    ),
    "one point that moves": hint(
        "subtract the damping times the velocity, component by component",
        (np.array([0.3, -1.2]), np.array([0.2, 0.1]), *_USUAL),
    ),
    "several points at once": hint(
        "each row has a length and a metric of its own: axis=-1 and keepdims=True",
        (_MANY, _RNG.uniform(-1, 1, (4, 2)), *_USUAL),
        (np.array([[3.0, 4.0], [0.0, 1.0]]), np.zeros((2, 2)), *_USUAL),
    ),
    "points within `near` of their goals": hint(
        "nearer than `near`, divide by `near`: the pull fades evenly, and is nothing at 0 only",
        (np.array([[0.05, 0.1], [-0.2, 0.0], [0.0, 0.34]]), np.zeros((3, 2)), *_USUAL),
        (np.array([[0.02, 0.01], [0.0, -0.004]]), np.zeros((2, 2)), *_USUAL),
    ),
    "a point at its goal": hint(
        "there the offset is 0: dividing by the larger of length and `near` gives no pull",
        (np.zeros(2), np.array([0.1, 0.2]), *_USUAL),
    ),
    "another gain": hint(
        "the gain is an argument; use it, and no number in its place",
        *((_MANY, 0.1 * _MANY, gain, 3.0, 0.35) for gain in (0.6, 1.0, 3.6)),
    ),
    "another damping": hint(
        "the damping is an argument; use it, and no number in its place",
        *(
            (_MANY * scale, 0.1 * _MANY, 2.4, damping, 0.35)
            for scale in (1.0, 0.02)
            for damping in (0.5, 1.0, 5.0)
        ),
    ),
    "another `near`": hint(
        "`near` is an argument; use it, and no number in its place",
        *((_MANY, 0.1 * _MANY, 2.4, 3.0, near) for near in (1.5, 2.5, 0.01)),
    ),
    "24 random groups of points, also a grid (2, 3, 2)": hint(
        "the simple cases are right; work on the last axis, whatever comes before it", *_RANDOM
    ),
}
MISTAKES = """
the pull is as strong from far away as from nearby: divide the offset by its length
    gain * offsets / np.maximum(distance, near) -> gain * offsets
damping works against the velocity: it needs a minus
    - damping -> + damping
the gain multiplies the pull, the damping the velocity; yours exchanges them
    gain * offsets -> damping * offsets
    damping * velocities -> gain * velocities
only the pull is divided by the length; the velocity is damped as it is
    gain * offsets / -> (gain * offsets - damping * velocities) /
    near) - damping * velocities -> near)
the damping works against the velocity with its sign, not against its size
    damping * velocities -> damping * np.abs(velocities)
the damping is missing: subtract damping * velocity
    damping * velocities -> 0
only the pull is multiplied by the gain, only the velocity by the damping
    damping * velocities -> velocities
    gain * offsets -> (gain - damping) * offsets
the damping does not belong inside the pull: the gain multiplies the pull alone
    damping * velocities -> gain * damping * velocities
the velocity is multiplied by the damping, not divided by it
    damping * velocities -> velocities / damping
the damping grows with the velocity itself, not with its square
    * velocities -> * velocities * np.linalg.norm(velocities, axis=-1, keepdims=True)
divide by the larger of length and `near`; far away `near` must not matter
    np.maximum(distance, near) -> np.sqrt(distance**2 + near**2)
the damping acts everywhere, not only within `near`
    * velocities -> * velocities * (distance < near)
the damping acts everywhere, not only farther away than `near`
    * velocities -> * velocities * (distance >= near)
the damping works against the whole velocity, not only along the way to the goal
    - damping * velocities -> - 0
    gain * -> (gain - damping * np.linalg.norm(velocities, axis=-1, keepdims=True)) *
compare the length of the offset with `near`, not its square
    np.maximum(distance, near) -> np.where(distance**2 > near, distance, near)
within `near` the pull is gain * offset / near; it is not divided by `near`
    np.maximum(distance, near) -> np.where(distance < near, 1, distance)
the damping works against the whole velocity, also sideways, not only along the offset
    * velocities -> * (velocities * pull).sum(axis=-1, keepdims=True) * pull
    accelerations = -> pull = offsets / np.maximum(distance, near); accelerations =
the velocity is damped component by component, not its length
    * velocities -> * np.linalg.norm(velocities, axis=-1, keepdims=True)
it pushes away from the goal: the offset runs from the point to its goal, so it has a plus
    gain * offsets -> -gain * offsets
within `near` the pull fades: divide by the distance or by `near`, whichever is larger
    np.maximum(distance, near) -> np.maximum(distance, 1e-300)
divide by the larger of distance and `near`, not by the smaller
    np.maximum -> np.minimum
within `near` the pull fades evenly; it does not stop at once
    np.maximum(distance, near) -> np.where(distance < near, np.inf, distance)
far away the pull is a whole gain; it fades only within `near`
    np.maximum(distance, near) -> (distance + near)
each offset has its own length: np.linalg.norm(offsets, axis=-1, keepdims=True)
    np.linalg.norm(offsets, axis=-1, keepdims=True) -> np.linalg.norm(offsets)
divide by the length of the offset, not by the sum of its components
    np.maximum(distance, -> np.maximum(np.abs(offsets).sum(axis=-1, keepdims=True),
divide by the length of the offset, not by its square
    np.maximum(distance, -> np.maximum(distance**2,
divide by the larger of the length and `near` itself, not by the square of that
    np.maximum(distance, near) -> np.maximum(distance, near) ** 2
divide by the length of the offset, not by the larger of its two components
    np.maximum(distance, -> np.maximum(np.abs(offsets).max(axis=-1, keepdims=True),
x and y share one length; do not divide each by its own size
    np.maximum(distance, -> np.maximum(np.abs(offsets),
the metric weighs all directions equally: the identity, not zeros
    np.eye(2) -> np.zeros((2, 2))
the metric is the identity itself; the gain does not belong in it
    np.eye(2) -> gain * np.eye(2)
the metric is the identity itself; the damping does not belong in it
    np.eye(2) -> damping * np.eye(2)
the metric weighs all directions equally, not only the one to the goal
    np.broadcast_to(np.eye(2), (*offsets.shape, 2)) -> unit[..., None] * unit[..., None, :]
    return -> unit = offsets / np.maximum(distance, 1e-300); return
the metric is the identity: ones on the diagonal only
    np.eye(2) -> np.ones((2, 2))
"""


check_goal_policy = exercise(
    goal_policy,
    topics(TOPICS),
    MISTAKES,
    about="The pull to a goal, with damping, far and near, of one point and of many.",
    example=case(np.ones((100, 2)), np.zeros((100, 2)), 2.4, 3.0, 0.35),
    form=lambda what, got, offsets, *_: policies_of(what, got, offsets.shape, (*offsets.shape, 2)),
    same=same_policies,
    difference=differing,
)
