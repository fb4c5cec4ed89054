"""Doors of experiments: statistics, tasks and how they are run."""

import numpy as np

from tests.doors.arguments import a, floats, function
from tests.doors.walk import call
from tutorial_lib.experiments.common import statistics

SHARE = {"least": 0, "most": 1}
WORLDS = np.array(["a", "a", "b"])


def worlds():
    """The world of each of three episodes."""
    return a(WORLDS)


def three(values, **more):
    return floats(values, ("N",), empty=False, **more)


DOORS = {
    "over_worlds": lambda: call(
        statistics.over_worlds,
        values=three([1.0, 0.0, 1.0], **SHARE, refuses="longer N, shorter N"),
        worlds=worlds(),
    ),
    "measured_over_worlds": lambda: call(
        lambda measure, worlds: statistics.measured_over_worlds(measure, worlds, [1.0, 0.0, 1.0]),
        measure=function(np.mean),
        worlds=worlds(),
    ),
    "difference": lambda: call(
        statistics.difference,
        first=three([1.0, 0.0, 1.0]),
        second=three([0.5, 0.0, 1.0]),
        worlds=worlds(),
    ),
    "in_points": lambda: call(statistics.in_points, found=floats([0.1, 0.0, 0.2], (3,))),
    "wilson": lambda: call(statistics.wilson, values=three([1.0, 0.0, 1.0], **SHARE)),
}
RUN = "runs whole tasks, whose parts check what they are given"
WITHOUT = dict.fromkeys(
    (
        *("Building", "CalledRobot", "Guide", "Office", "Recorder", "Trials", "watch"),
        *("choose_places", "draw_ambiguous_trials", "draw_return", "draw_trials"),
        *("driven_trials", "edge_lengths", "experiences", "explored", "facing", "farthest"),
        *("goals_of", "learned_from", "load_result", "make_building", "make_office"),
        *("navigate", "navigate_once", "part_of", "place_people", "spread_places"),
        "vertex_poses",
    ),
    RUN,
)
