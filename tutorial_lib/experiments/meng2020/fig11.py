"""Fig. 11 of Meng 2020: a way that nobody drove, put together from several trajectories."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation import (
    K,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, building, trials
from tutorial_lib.learning.estimators import use_threads
from tutorial_lib.learning.views import VIEWS

SHARE = 0.4
"""Of the trajectories that are learned."""
_TRIALS = 40


def run(options: Options) -> Report:
    """Find a trial whose own trajectory was not learned, and whose way leads over several others.

    Of those that succeed, the one whose way changes between trajectories most evenly is shown.
    """
    begun = time.perf_counter()
    worlds = options.worlds[:1] or WORLDS[:1]
    use_threads(2)
    house = building(worlds[0], options.seed, PLACES)
    rng = np.random.default_rng([options.seed, worlds[0], 7])
    kept = np.sort(rng.permutation(len(house.pairs))[: round(SHARE * len(house.pairs))])
    asked, agent = trials(house, _TRIALS, rng), agents.meng()
    agent.learn(list(experiences(house, kept.tolist())))
    journey = agent.start(goals_of(asked, VIEWS["camera16"], K))
    outcome = navigate(house, asked, lambda _: journey)
    known = {tuple(pair) for pair in house.pairs[kept].tolist()}
    best, most = -1, 0
    for trial in np.flatnonzero(outcome.success):
        if tuple(asked.pairs[trial].tolist()) in known or len(journey.history[trial]) > 1:
            continue
        found = agent.topomap.trajectory[list(journey.history[trial][0].vertices)]
        second = sorted(np.bincount(found))[-2:][0] if len(set(found.tolist())) > 1 else 0
        if second > most:
            best, most = int(trial), int(second)
    if best < 0:
        raise InputError("meng_fig11: no new way was found in this world; give another one")
    plan, poses = journey.history[best][0], vertex_poses(house, agent.topomap)
    first, last = asked.pairs[best].tolist()
    rows: list[dict[str, Any]] = [
        {
            "from_place": first,
            "to_place": last,
            "step": step,
            "vertex": int(vertex),
            "trajectory": int(kept[agent.topomap.trajectory[vertex]]),
            "x": float(poses[vertex, 0]),
            "y": float(poses[vertex, 1]),
            "heading": float(poses[vertex, 2]),
            "probability": plan.probabilities[step],
        }
        for step, vertex in enumerate(plan.vertices)
    ]
    note = (
        f"from place {first} to {last} with {plan.probability:.1%}; reached after "
        f"{outcome.seconds[best]:.0f} s; {len(kept)} of {len(house.pairs)} trajectories known"
    )
    took = time.perf_counter() - begun
    return Report("meng_fig11", options.seed, worlds, options.quick, took, rows, (note,))
