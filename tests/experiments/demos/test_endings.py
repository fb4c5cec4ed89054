"""What is said of the end of a drive."""

import numpy as np
import pytest

from tutorial_lib.experiments.demos.navigation_demo import drive_ending
from tutorial_lib.experiments.protocols.navigation import Outcome
from tutorial_lib.interfaces import Plan

PLAN, NONE = Plan((1, 2), 0, (0.9, 1.0, 0.999)), Plan(refusal="no path leads from here")
REFUSED = Plan((1, 2), 0, (0.3, 0.3, 1.0), refusal="the best path has probability 0.090, below 0.2")


@pytest.mark.parametrize(
    ("ending", "gap", "plans", "words"),
    [
        ("arrived", 0.21, [PLAN], "reached the goal, 0.21 m from it"),
        ("arrived", 21.04, [NONE, PLAN], "stopped 21.0 m from the goal, believing 89.9%"),
        ("arrived", 21.04, [], "stopped 21.0 m from the goal"),
        ("stuck", 3.0, [PLAN], "collided: touched something for 2 s, 3.0 m from the goal"),
        ("late", 3.0, [PLAN], "out of time, 3.0 m from the goal"),
        ("gave_up", 9.0, [REFUSED], f"refused: {REFUSED.refusal}"),
        (
            "gave_up",
            9.0,
            [PLAN, NONE],
            "gave up, 9.0 m from the goal: no path leads from here",
        ),
        ("gave_up", 9.0, [NONE, PLAN], "gave up, 9.0 m from the goal"),
    ],
)
def test_every_ending_is_said(ending, gap, plans, words):
    found = Outcome(
        *(np.array([False]), np.array([ending]), np.array([240.2]), np.array([gap])),
        np.zeros((1, 1, 3)),
    )
    assert drive_ending(found, plans) == words
