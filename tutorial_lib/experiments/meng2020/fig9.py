"""Fig. 9 of Meng 2020: is the probability of a path how often it is driven to its end?"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import wilson
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation import K, experiences, goals_of, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    building,
    trials_from_anywhere,
)
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import fit_isotonic, logit, reliability
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.planner import DijkstraPlanner

VALIDATION = tuple(range(10_000, 10_005))
"""Worlds on which the probability is recalibrated."""
TRIALS, QUICK_TRIALS = 220, 50
BINS = 5
ANY_WAY = DijkstraPlanner(least=0.0, p_query=0.02, p_goal=0.02)
"""Plans whatever the chances are."""
_KNOTS = 10
_LEAST, _MOST = 1e-6, 1 - 1e-6


def run(options: Options) -> Report:
    """Start anywhere, plan, follow the plan without planning anew; first on validation worlds."""
    begun = time.perf_counter()
    worlds = options.worlds or WORLDS
    every = [*VALIDATION, *worlds]
    parts = for_each(run_world, every, options, label="meng_fig9")
    first, second = np.hstack(parts[: len(VALIDATION)]), np.hstack(parts[len(VALIDATION) :])
    mend = fit_isotonic(_logits(first[0]), first[1], _KNOTS)
    rows, notes = [], []
    for calibrated, told in ((False, second[0]), (True, mend(_logits(second[0])))):
        rows += _rows(calibrated, told, second[1])
        found = reliability(told, second[1], BINS)
        rank = spearmanr(found.predicted, found.measured).statistic
        ece = reliability(told, second[1]).ece
        which = "recalibrated" if calibrated else "product of RE"
        notes.append(f"{which}: ECE {ece:.3f}, Spearman over {BINS} bins {rank:.2f}")
    took = time.perf_counter() - begun
    return Report("meng_fig9", options.seed, worlds, options.quick, took, rows, tuple(notes))


def run_world(world: int, options: Options) -> Array:
    """In one world, (2, N): the probabilities of plans, and whether they were driven to the end."""
    house = building(world, options.seed, PLACES)
    agent = agents.meng(planner=ANY_WAY, replans=0)
    agent.learn(list(experiences(house)))
    count = QUICK_TRIALS if options.quick else TRIALS
    rng = np.random.default_rng([options.seed, world, 4])
    asked = trials_from_anywhere(house, count, rng)
    journey = agent.start(goals_of(asked, VIEWS["camera16"], K))
    outcome = navigate(house, asked, lambda _: journey)
    told = np.array([plans[0].probability for plans in journey.history])
    return np.stack([told, outcome.success.astype(float)])


def _logits(told: Array) -> Array:
    return logit(np.clip(told, _LEAST, _MOST))


def _rows(calibrated: bool, told: Array, success: Array) -> list[dict[str, Any]]:
    """A row for each bin of equal mass."""
    order = np.argsort(told, kind="stable")
    rows = []
    for number, part in enumerate(np.array_split(order, BINS)):
        share, low, high = wilson(success[part])
        rows.append(
            {
                "calibrated": calibrated,
                "bin": number,
                "trials": len(part),
                "probability": float(told[part].mean()),
                "least": float(told[part].min()),
                "most": float(told[part].max()),
                "success": share,
                "low": low,
                "high": high,
            }
        )
    return rows
