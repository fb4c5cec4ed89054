"""Doors of experiments: statistics, tasks and how they are run."""

import numpy as np

from tests.doors.arguments import (
    a,
    choice,
    flag,
    floats,
    function,
    integers,
    path,
    whole,
)
from tests.doors.driving import paths, recorded
from tests.doors.topology import topomap
from tests.doors.walk import anything, call
from tests.doors.world import GRID, beside, rng, scene
from tutorial_lib import experiments
from tutorial_lib.experiments.common import results, statistics
from tutorial_lib.learning.views import VIEWS

SHARE = {"least": 0, "most": 1}
WORLDS = np.array(["a", "a", "b"])


def worlds():
    """The world of each of three episodes."""
    return a(WORLDS)


def three(values, **more):
    return floats(values, ("N",), empty=False, **more)


PLACES = np.array([[1.5, 1.5], [8.0, 8.0]])
PAIRS = np.array([[0, 1], [1, 0]])


def building():
    """Two places with a drive from each to the other."""
    return experiments.Building("box", scene(), paths(), PLACES, recorded(), PAIRS)


def trials():
    last = np.unique(recorded().last)
    starts = recorded().poses[recorded().first_frames]
    return experiments.Trials(PAIRS, starts, recorded(), last, np.array([9.0, 9.0]))


class Still:
    """A navigation whose robots give up at once."""

    arrived, given_up = np.zeros(2, dtype=bool), np.ones(2, dtype=bool)

    def act(self, observations, robots):
        return np.zeros((len(observations), 2))


DOORS = {
    "Trials.subset": lambda: call(
        trials().subset, anything, indices=integers([1], ("M",), least=0, most=1)
    ),
    "draw_trials": lambda: call(
        experiments.draw_trials,
        anything,
        building=a(building()),
        count=whole(1, least=1, most=10_000, refuses="huge"),
        rng=a(rng()),
        among=integers([0, 1], ("M",), least=0, most=1, empty=False, optional=True),
    ),
    "trials_from_anywhere": lambda: call(
        experiments.trials_from_anywhere,
        anything,
        building=a(building()),
        count=whole(1, least=1, most=10_000, refuses="huge"),
        rng=a(rng()),
    ),
    "edge_lengths": lambda: call(
        experiments.edge_lengths, building=a(building()), topomap=a(topomap())
    ),
    "vertex_poses": lambda: call(
        experiments.vertex_poses, building=a(building()), topomap=a(topomap())
    ),
    "experiences": lambda: call(
        experiments.experiences,
        anything,
        building=a(building()),
        indices=integers([0], ("N",), least=0, most=1, optional=True),
    ),
    "facing": lambda: call(
        experiments.facing,
        scene=a(scene()),
        paths=a(paths()),
        places=floats(PLACES, ("P", 2), refuses="huge, negative, shorter P, empty"),
        pairs=integers(PAIRS, ("D", 2), least=0, most=1),
    ),
    "goals_of": lambda: call(
        experiments.goals_of,
        anything,
        trials=a(trials()),
        view=a(VIEWS["camera16"]),
        k=whole(2, least=0, refuses="huge"),
    ),
    "load_result": lambda: call(
        experiments.load_result,
        anything,
        name=choice("meng_table2"),
        folder=path(results.FOLDER),
    ),
    "navigate": lambda: call(
        experiments.navigate,
        anything,
        building=a(building()),
        trials=a(trials()),
        start=function(lambda simulation: Still()),
        people=(),
        record=function(lambda *given: None, optional=True),
    ),
    "part_of": lambda: call(
        experiments.part_of,
        anything,
        building=a(building()),
        drives=choice("0.5", takes="empty"),
        seed=whole(0, least=0),
    ),
    "driven_trials": lambda: call(
        experiments.driven_trials,
        whole=a(building()),
        trials=a(trials()),
        drives=choice("0.5", takes="empty"),
        seed=whole(0, least=0),
    ),
    "make_building": lambda: call(
        lambda **given: beside(GRID, lambda path, **rest: experiments.make_building(path, **rest))(
            "map.yaml", **given
        ),
        anything,
        seed=whole(0, least=0),
        count=whole(2, least=2, refuses="huge"),
        drifts=flag(False),
    ),
    "spread_places": lambda: call(
        experiments.spread_places,
        paths=a(paths()),
        count=whole(2, least=1, refuses="huge"),
        rng=a(rng()),
    ),
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
    "wilson": lambda: call(statistics.wilson, values=three([1.0, 0.0, 1.0], **SHARE)),
}

RUN = "runs whole tasks, whose parts check what they are given"
WITHOUT = dict.fromkeys(
    (
        *("Building", "CalledRobot", "Guide", "Office", "Recorder", "Trials", "watch"),
        *("draw_ambiguous_trials", "draw_return", "explored"),
        *("learned_from", "make_office", "navigate_once"),
        *("deep_experiences", "image_poses", "run_fleet", "run_queries"),
        *("MapScore", "TamperedMap", "score_map"),
        *("Settings", "draw_lives", "live"),
        "place_people",
    ),
    RUN,
) | {"pictures": "it draws the rows of a stored run; `load_result` checks the file"}
