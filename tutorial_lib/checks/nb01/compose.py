"""The check of composing poses, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array


@check(geometry.compose, (np.array([1.0, 2.0, 0.5]), np.array([0.1, 0.0, 0.2])))
def check_compose(student: Callable[..., Array]) -> None:
    """A pose, and a second one in its frame."""
    cases = (
        ([1.0, 2.0, 0.4], [0.5, 0.2, 0.3]),
        ([0.0, 1.0, -2.0], [1.5, -0.5, 1.0]),
        ([2.0, 0.0, 2.8], [1.0, 0.0, 1.4]),
    )
    for first, second in cases:
        first, second = np.array(first), np.array(second)
        want = geometry.compose(first, second)
        plain = np.array([*(first + second)[:2], want[2]])
        mistakes = {
            "the second pose is seen from the first: turn its step by the first heading": plain,
            "the order is reversed: the first pose comes first": geometry.compose(second, first),
            "wrap the heading into -pi to pi": [*want[:2], first[2] + second[2]],
            "headings add up: the second is measured from the first": [*want[:2], second[2]],
            "the step is turned the wrong way; from the robot to the world it is R itself": [
                *geometry.compose([*first[:2], -first[2]], second)[:2],
                want[2],
            ],
            "turn the step by the first heading alone; the second comes after it": [
                *geometry.to_world([*first[:2], first[2] + second[2]], second[:2]),
                want[2],
            ],
            "wrap the heading into -pi to pi, not 0 to 2 pi": [*want[:2], want[2] % (2 * np.pi)],
        }
        what = f"compose of {first.tolist()} and {second.tolist()}"
        expect_close(what, call(student, first, second), want, 1e-6, mistakes)
