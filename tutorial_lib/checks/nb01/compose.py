"""The check of composing poses, in notebook 01."""

import numpy as np

from tutorial_lib.checks.engine import case, close, exercise, hint, numbers, topics
from tutorial_lib.se2 import Array, compose


def _poses(first: list[float], second: list[float]) -> tuple[Array, Array]:
    return np.array(first), np.array(second)


TOPICS = {
    "heading 0, then a step": hint(
        "without a first heading the two motions simply add up",
        _poses([1.0, 2.0, 0.0], [0.5, 0.2, 0.3]),
    ),
    "a quarter turn to the left at the origin, then 1 m ahead": hint(
        "the step runs along +y, so the robot is at (0, 1)",
        _poses([0.0, 0.0, np.pi / 2], [1.0, 0.0, 0.0]),
    ),
    "a quarter turn to the left at the origin, then 1 m to the left": hint(
        "the robot's left is now -x, so the robot is at (-1, 0)",
        _poses([0.0, 0.0, np.pi / 2], [0.0, 1.0, 0.0]),
    ),
    "two motions whose headings add up to between -pi and pi": hint(
        "turn the second step by the first heading, add the first place; the headings add up",
        _poses([1.0, 2.0, 0.4], [0.5, 0.2, 0.3]),
        _poses([0.0, 1.0, -2.0], [1.5, -0.5, 1.0]),
    ),
    "headings 2.8 and 1.4, whose sum is above pi": hint(
        "wrap the heading into -pi to pi: take 2 pi off", _poses([2.0, 0.0, 2.8], [1.0, 0.0, 1.4])
    ),
    "headings -2.8 and -1.4, whose sum is below -pi": hint(
        "wrap the heading into -pi to pi: add 2 pi", _poses([2.0, 0.0, -2.8], [1.0, 0.0, -1.4])
    ),
    "no motion, a turn where the robot stands, a step of 2 cm and a turn of 0.03": hint(
        "a track is made of many small motions: leave none of them out",
        _poses([1.0, 2.0, 0.4], [0.0, 0.0, 0.0]),
        _poses([1.0, 2.0, 0.5], [0.0, 0.0, 0.5]),
        _poses([1.0, 2.0, 0.4], [0.02, 0.01, 0.03]),
        _poses([1.0, 2.0, 0.02], [1.0, 0.0, 0.01]),
    ),
    "30 random pairs": hint(
        "the simple cases are right; does a part of your formula hold for some headings only?",
        *np.random.default_rng(2).uniform([-4, -4, -np.pi], [4, 4, np.pi], (30, 2, 3)),
    ),
}
MISTAKES = """
the second pose is seen from the first: turn its step by the first heading
    to_world(first, second[..., :2]) -> (first + second)[..., :2]
the order is reversed: the first pose comes first
    first, second = -> second, first =
the first pose stays where it is; it is the second step that is turned
    to_world(first, second[..., :2]) -> to_world([*second[:2], first[2]], first[:2])
the step is turned the wrong way; from the robot to the world it is R itself
    to_world(first, -> to_world(first * [1, 1, -1],
turn the step by the first heading alone; the second comes after it
    to_world(first, -> to_world(first + second * [0, 0, 1],
the step is turned by the second heading; it is the first that counts
    to_world(first, -> to_world([*first[:2], second[2]],
headings are in radians; do not convert them from degrees
    to_world(first, -> to_world(first * [1, 1, np.pi / 180],
a step sideways is lost: the second pose's y counts too
    second[..., :2] -> second[..., :2] * [1, 0]
the second pose's x and y are both needed, with their signs, not only its distance
    second[..., :2] -> [np.hypot(second[0], second[1]), 0]
the step comes before the turn that the second heading makes; do not turn it by half
    to_world(first, -> to_world(first + second * [0, 0, 0.5],
x and y of the turned step are exchanged
    to_world(first, second[..., :2]) -> first[:2] + to_world(first * [0, 0, 1], second[:2])[::-1]
the headings add up; do not take their mean
    wrap(first[..., 2] + second[..., 2]) -> (first[2] + second[2]) / 2
wrap the heading into -pi to pi
    wrap(first[..., 2] + second[..., 2]) -> first[2] + second[2]
wrap the heading into -pi to pi, not 0 to 2 pi
    wrap(first[..., 2] + second[..., 2]) -> (first[2] + second[2]) % (2 * np.pi)
headings above pi are wrapped, those below -pi are not
    return -> heading = wrap(heading) if heading > -np.pi else heading; return
    wrap(first[..., 2] + second[..., 2]) -> first[2] + second[2]
headings below -pi are wrapped, those above pi are not
    return -> heading = wrap(heading) if heading < np.pi else heading; return
    wrap(first[..., 2] + second[..., 2]) -> first[2] + second[2]
the heading is cut at -pi and pi; wrap it: 3.2 becomes 3.2 - 2 pi
    wrap(first[..., 2] + second[..., 2]) -> np.clip(first[2] + second[2], -np.pi, np.pi)
the heading is wrapped by half a turn; a whole turn is 2 pi
    wrap(first[..., 2] + second[..., 2]) -> wrap(2 * (first[2] + second[2])) / 2
arcsin knows headings up to a quarter turn only; np.arctan2(sine, cosine) knows all
    wrap(first[..., 2] + second[..., 2]) -> np.arcsin(np.sin(first[2] + second[2]))
only the heading is wrapped; x and y are metres
    position = to_world(first, second[..., :2]) -> position = wrap(to_world(first, second[:2]))
the headings are subtracted; they add up
    first[..., 2] + second[..., 2] -> first[..., 2] - second[..., 2]
headings add up: the second is measured from the first
    wrap(first[..., 2] + second[..., 2]) -> second[..., 2]
headings add up: the second motion turns the robot too
    wrap(first[..., 2] + second[..., 2]) -> first[..., 2]
"""


def _same(got: Array, want: Array, *_: Array) -> bool:
    """Whether two poses agree; -pi is as good as pi."""
    ends = abs(abs(got[2]) - np.pi) < 1e-6 and abs(abs(want[2]) - np.pi) < 1e-6
    return close(got[:2], want[:2]) and (ends or close(got[2], want[2]))


check_compose = exercise(
    compose,
    topics(TOPICS),
    MISTAKES,
    about="A pose, and a second one in its frame.",
    example=case(np.array([1.0, 2.0, 0.5]), np.array([0.1, 0.0, 0.2])),
    form=lambda what, answer, *_: numbers(what, answer, (3,)),
    same=_same,
)
