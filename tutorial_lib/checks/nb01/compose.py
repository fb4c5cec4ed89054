"""The check of composing poses, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.se2 import Array, compose, to_world, wrap

Rule = Callable[[Array, Array], Array]


def _place(place: Callable[[Array, Array], Array]) -> Rule:
    """The right heading with another rule for the place."""
    return lambda first, second: np.array([*place(first, second), compose(first, second)[2]])


def _heading(heading: Callable[[float, float], float]) -> Rule:
    """The right place with another rule for the heading."""
    return lambda first, second: np.array(
        [*compose(first, second)[:2], heading(first[2], second[2])]
    )


def _moved(heading: float, first: Array, second: Array) -> Array:
    return to_world(np.array([*first[:2], heading]), second[:2])


_FAULTS = {
    "the second pose is seen from the first: turn its step by the first heading": _place(
        lambda first, second: (first + second)[:2]
    ),
    "the order is reversed: the first pose comes first": lambda first, second: compose(
        second, first
    ),
    "the first pose stays where it is; it is the second step that is turned": _place(
        lambda first, second: _moved(first[2], second, first)
    ),
    "the step is turned the wrong way; from the robot to the world it is R itself": _place(
        lambda first, second: _moved(-first[2], first, second)
    ),
    "turn the step by the first heading alone; the second comes after it": _place(
        lambda first, second: _moved(first[2] + second[2], first, second)
    ),
    "the step is turned by the second heading; it is the first that counts": _place(
        lambda first, second: _moved(second[2], first, second)
    ),
    "headings are in radians; do not convert them from degrees": _place(
        lambda first, second: _moved(np.deg2rad(first[2]), first, second)
    ),
    "a step sideways is lost: the second pose's y counts too": _place(
        lambda first, second: _moved(first[2], first, second * [1, 0, 1])
    ),
    "the second pose's x and y are both needed, with their signs, not only its distance": _place(
        lambda first, second: _moved(
            first[2], first, np.array([np.hypot(second[0], second[1]), 0.0, 0.0])
        )
    ),
    "the step comes before the turn that the second heading makes; do not turn it by half": _place(
        lambda first, second: _moved(first[2] + second[2] / 2, first, second)
    ),
    "x and y of the turned step are exchanged": _place(
        lambda first, second: first[:2] + (_moved(first[2], 0 * first, second))[::-1]
    ),
    "the headings add up; do not take their mean": _heading(
        lambda first, second: (first + second) / 2
    ),
    "wrap the heading into -pi to pi": _heading(lambda first, second: first + second),
    "wrap the heading into -pi to pi, not 0 to 2 pi": _heading(
        lambda first, second: (first + second) % (2 * np.pi)
    ),
    "headings above pi are wrapped, those below -pi are not": _heading(
        lambda first, second: first + second - 2 * np.pi * (first + second > np.pi)
    ),
    "headings below -pi are wrapped, those above pi are not": _heading(
        lambda first, second: first + second + 2 * np.pi * (first + second < -np.pi)
    ),
    "the heading is cut at -pi and pi; wrap it: 3.2 becomes 3.2 - 2 pi": _heading(
        lambda first, second: np.clip(first + second, -np.pi, np.pi)
    ),
    "the heading is wrapped by half a turn; a whole turn is 2 pi": _heading(
        lambda first, second: (first + second + np.pi / 2) % np.pi - np.pi / 2
    ),
    "arcsin knows headings up to a quarter turn only; np.arctan2(sine, cosine) knows all": _heading(
        lambda first, second: np.arcsin(np.sin(first + second))
    ),
    "only the heading is wrapped; x and y are metres": lambda first, second: wrap(
        np.array([*_moved(first[2], first, second), first[2] + second[2]])
    ),
    "the headings are subtracted; they add up": _heading(
        lambda first, second: wrap(first - second)
    ),
    "headings add up: the second is measured from the first": _heading(
        lambda first, second: second
    ),
    "headings add up: the second motion turns the robot too": _heading(lambda first, second: first),
}


def _topics() -> list[Topic]:
    rng = np.random.default_rng(2)
    pairs = rng.uniform([-4, -4, -np.pi], [4, 4, np.pi], (30, 2, 3))

    def case(first: list[float], second: list[float]) -> tuple[Array, Array]:
        return np.array(first), np.array(second)

    return [
        Topic(
            "heading 0, then a step",
            "without a first heading the two motions simply add up",
            [case([1.0, 2.0, 0.0], [0.5, 0.2, 0.3])],
        ),
        Topic(
            "a quarter turn to the left at the origin, then 1 m ahead",
            "the step runs along +y, so the robot is at (0, 1)",
            [case([0.0, 0.0, np.pi / 2], [1.0, 0.0, 0.0])],
        ),
        Topic(
            "a quarter turn to the left at the origin, then 1 m to the left",
            "the robot's left is now -x, so the robot is at (-1, 0)",
            [case([0.0, 0.0, np.pi / 2], [0.0, 1.0, 0.0])],
        ),
        Topic(
            "any two motions whose headings need no wrapping",
            "turn the second step by the first heading, add the first place; the headings add up",
            [case([1.0, 2.0, 0.4], [0.5, 0.2, 0.3]), case([0.0, 1.0, -2.0], [1.5, -0.5, 1.0])],
        ),
        Topic(
            "headings 2.8 and 1.4, whose sum is above pi",
            "wrap the heading into -pi to pi: take 2 pi off",
            [case([2.0, 0.0, 2.8], [1.0, 0.0, 1.4])],
        ),
        Topic(
            "headings -2.8 and -1.4, whose sum is below -pi",
            "wrap the heading into -pi to pi: add 2 pi",
            [case([2.0, 0.0, -2.8], [1.0, 0.0, -1.4])],
        ),
        Topic(
            "no motion, a step of 2 cm and a turn of 0.03",
            "a track is made of many small motions: leave none of them out",
            [
                case([1.0, 2.0, 0.4], [0.0, 0.0, 0.0]),
                case([1.0, 2.0, 0.4], [0.02, 0.01, 0.03]),
                case([1.0, 2.0, 0.02], [1.0, 0.0, 0.01]),
            ],
        ),
        Topic(
            "30 random pairs",
            "the simple cases are right; does a part of your formula hold for some headings only?",
            [tuple(pair) for pair in pairs],
        ),
    ]


@check(geometry.compose, (np.array([1.0, 2.0, 0.5]), np.array([0.1, 0.0, 0.2])))
def check_compose(student: Callable[..., Array]) -> None:
    """A pose, and a second one in its frame."""
    judge_topics("compose", student, _topics(), compose, _FAULTS, form=_form, same=_same)


def _form(what: str, answer: object, first: Array, second: Array) -> Array:
    return numbers(what, answer, (3,))


def _same(got: Array, want: Array, first: Array, second: Array) -> bool:
    """Whether two poses agree; -pi is as good as pi."""
    ends = abs(abs(got[2]) - np.pi) < 1e-6 and abs(abs(want[2]) - np.pi) < 1e-6
    return close(got[:2], want[:2]) and (ends or close(got[2], want[2]))
