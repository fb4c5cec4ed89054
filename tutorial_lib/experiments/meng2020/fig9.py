"""Fig. 9 of Meng 2020: is the probability of a path the share of such paths that succeed?"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import NUMBER, Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import wilson
from tutorial_lib.experiments.protocols.navigation import ONE, K, experiences, goals_of, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    make_building,
    trials_from_anywhere,
)
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import fit_isotonic, logit, reliability
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.planner import DijkstraPlanner

VALIDATION = tuple(range(10_000, 10_005))
"""Worlds on which the probability is recalibrated."""
BINS = 5
PERMISSIVE = DijkstraPlanner(least=0.0, p_query=0.02, p_goal=0.02)
"""Plans however small the probability is."""
_KNOTS = 10
_LEAST, _MOST = 1e-6, 1 - 1e-6


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 9.

    Attributes:
        places: of a building.
        trials: in each world.
    """

    places: int = PLACES
    trials: int = 220


def run(options: Options, settings: Settings) -> tuple[Rows, list[Finding]]:
    """Start anywhere, plan, and follow the plan without replanning; first in validation worlds."""
    every = [*VALIDATION, *options.worlds]
    parts = for_each(run_world, every, options, settings, label="meng_fig9")
    known, unseen = np.hstack(parts[: len(VALIDATION)]), np.hstack(parts[len(VALIDATION) :])
    recalibrate = fit_isotonic(_logits(known[0]), known[1], _KNOTS)
    rows, findings = [], []
    predictions = {False: unseen[0], True: recalibrate(_logits(unseen[0]))}
    for calibrated, probability in predictions.items():
        rows += _rows(calibrated, probability, unseen[1])
        found = reliability(probability, unseen[1], BINS)
        rank = spearmanr(found.predicted, found.measured).statistic
        ece = reliability(probability, unseen[1]).ece
        which = "recalibrated" if calibrated else "product of RE"
        findings.append(Finding(f"{which}, ECE", float(ece), form=NUMBER))
        findings.append(Finding(f"{which}, Spearman over {BINS} bins", float(rank), form=NUMBER))
    return rows, findings


def run_world(world: int, options: Options, settings: Settings) -> Array:
    """In one world, (2, N): the probability of each plan, and whether the rollout succeeded."""
    building = make_building(world, options.seed, settings.places, drifts=options.drifts)
    agent = agents.meng(planner=PERMISSIVE, replan_time=0.0)
    agent.learn(list(experiences(building)))
    rng = np.random.default_rng([options.seed, world, 4])
    trials = trials_from_anywhere(building, settings.trials, rng)
    navigation = agent.start(goals_of(trials, VIEWS["camera16"], K))
    outcome = navigate(building, trials, lambda _: navigation)
    probability = np.array([plans[0].probability for plans in navigation.history])
    return np.stack([probability, outcome.success.astype(float)])


def _logits(probability: Array) -> Array:
    return logit(np.clip(probability, _LEAST, _MOST))


def _rows(calibrated: bool, probability: Array, success: Array) -> Rows:
    """A row for each bin of equal mass."""
    order = np.argsort(probability, kind="stable")
    rows = []
    for index, part in enumerate(np.array_split(order, BINS)):
        share, low, high = wilson(success[part])
        rows.append(
            {
                "goal_images": ONE,
                "calibrated": calibrated,
                "bin": index,
                "trials": len(part),
                "probability": float(probability[part].mean()),
                "least": float(probability[part].min()),
                "most": float(probability[part].max()),
                "success": share,
                "low": low,
                "high": high,
            }
        )
    return rows


EXPERIMENT = Experiment(
    "meng_fig9",
    run,
    WORLDS,
    settings=Settings(),
    quick_settings=Settings(trials=50),
    canary=Settings(places=5, trials=12),
    accepts=frozenset({"odometry"}),
)
