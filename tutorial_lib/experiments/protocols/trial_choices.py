"""Which trials are run: between the places, from anywhere, to goals seen from another heading."""

from dataclasses import replace

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    trials_from_anywhere,
)
from tutorial_lib.se2 import wrap

STARTS = BETWEEN, ANYWHERE = ("places", "anywhere")
"""Where trials start: at a place, looking along the way, or anywhere on a drive, looking aside."""
GOALS = AHEAD, TURNED = ("ahead", "turned")
"""How a goal is seen: as on arrival from the start, or as on arrival from elsewhere."""


def chosen_trials(
    building: Building, count: int, rng: np.random.Generator, starts: str, goals: str
) -> Trials:
    """At most `count` trials in a building, with all of its drives.

    Args:
        building: with all drives.
        count: trials.
        rng: draws them.
        starts: one of `STARTS`.
        goals: one of `GOALS`.
    """
    draw = trials_from_anywhere if starts == ANYWHERE else draw_trials
    trials = draw(building, count, rng)
    return with_turned_goals(trials) if goals == TURNED else trials


def with_turned_goals(trials: Trials) -> Trials:
    """The same trials to the same places, with goal images that were taken on other arrivals.

    Of all images of its place a trial gets the one whose heading differs most from its own.

    Raises:
        InputError: when there is no trial.
    """
    if not len(trials):
        raise InputError("trials: none; give more")
    heading, place = trials.goal_poses[:, 2], trials.pairs[:, 1]
    gap = np.abs(wrap(heading[:, None] - heading))
    other = np.where(place[:, None] == place, gap, -1.0).argmax(axis=1)
    return replace(trials, goals=trials.goals[other])
