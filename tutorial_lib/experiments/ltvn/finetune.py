"""LTVN's model before and after training on a robot's own drives in the target building.

The buildings look as no training world did: in colours, gamma and noise that no network has seen,
or with the floor plans of real buildings. Each robot learns the first drives of its tour, with
odometry for labels. What the model then makes of images from other drives is compared with the
usual look of the same seeds.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import STANDARD, Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.ltvn.lifelong import WORLDS
from tutorial_lib.experiments.ltvn.model import Scored, row_of, scores_of, threshold
from tutorial_lib.experiments.protocols.drives import TOUR, part_of
from tutorial_lib.experiments.protocols.lifelong import deep_experiences, run_queries
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    draw_trials,
    make_building,
)
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import RelativeNetwork
from tutorial_lib.learning.fine_tuning import TUNED, fine_tuned
from tutorial_lib.learning.settings import Settings as Training
from tutorial_lib.parallel import for_each

USUAL, SHIFTED, SCANNED = LOOKS = ("usual", "shifted", "scanned")
GATE, NETWORK = "context", "relative_5"
CONDITIONS = ((USUAL, False), (SHIFTED, False), (SHIFTED, True), (SCANNED, False), (SCANNED, True))
"""How a building looks, and whether the model is tuned to it."""
_OTHER = 5  # of the drives that are not learned, each so-many-th is judged


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        conditions: see `CONDITIONS`; the first is what the others are compared with.
        queries: in each building, on a map that does not change.
        minutes: of driving at most that the model learns; the map is of the whole tour.
        training: of the fine-tuning.
    """

    conditions: tuple[tuple[str, bool], ...] = CONDITIONS
    queries: int = 25
    minutes: float = 10.0
    training: Training = TUNED


@dataclass(frozen=True, eq=False)
class Judged:
    """One model in one building.

    Attributes:
        scored: all pairs of images of drives that it has not learned.
        success: (Q,) of queries on its map.
        vertices: of that map.
        minutes: of driving that the model learned; 0 where it was not tuned.
    """

    scored: Scored
    success: Array
    vertices: int
    minutes: float


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Judge the model in every building, before and after it was tuned to it."""
    items = [(world, *condition) for condition in settings.conditions for world in options.worlds]
    found = for_each(judged, items, options.seed, settings, label="ltvn_finetune")
    by = dict(zip(items, found, strict=True))
    rows: Rows = []
    usual = 0.0
    for look, tuned in settings.conditions:
        parts = [by[world, look, tuned] for world in options.worlds]
        scored = [part.scored for part in parts]
        limit = threshold(scored, GATE)
        usual = usual or limit
        units = np.repeat(options.worlds, [len(part.success) for part in parts])
        success, low, high = over_worlds(np.concatenate([part.success for part in parts]), units)
        rows.append(
            {"look": look, "tuned": tuned}
            | _kept(row_of(GATE, look, usual, scored))
            | {"recall_at": row_of(GATE, look, limit, scored)["recall"]}
            | {"queries": len(units), "success": success, "low": low, "high": high}
            | {"vertices": float(np.mean([part.vertices for part in parts]))}
            | {"minutes": float(np.mean([part.minutes for part in parts]))}
        )
    notes = [
        "recall, far_rate: at the threshold that accepts 0.03% of the far pairs of the first row",
        "recall_at: at the threshold that accepts 0.03% of those of the same row",
    ]
    return rows, notes


def _kept(row: dict[str, Any]) -> dict[str, Any]:
    kept = ("worlds", "pairs", "threshold", "far_rate", "recall", "waypoint_error", "yaw_error")
    return {name: row[name] for name in kept}


def judged(item: tuple[int, str, bool], seed: int, settings: Settings) -> Judged:
    """One condition in one building."""
    world, look, tuned = item
    palette = SHIFTED if look == SHIFTED else STANDARD
    whole = make_building(world, seed, palette=palette, family=SCANNED if look == SCANNED else "")
    building = part_of(whole, TOUR, seed)
    experiences = deep_experiences(building)
    spent = np.cumsum([np.ptp(experience.timestamps) / 60.0 for experience in experiences])
    learned = int(np.sum(spent <= settings.minutes)) if tuned else 0
    model = RelativeNetwork(NETWORK)
    if tuned:
        model = fine_tuned(model, experiences[:learned], settings.training)
    agent = agents.ltvn(model=model, maintenance=None)
    agent.learn(experiences)
    trials = draw_trials(whole, settings.queries, np.random.default_rng([seed, world, 1]))
    outcome, _ = run_queries(building, trials, agent)
    scored = scores_of(_others(whole, building), {NETWORK: model}, (GATE,))
    minutes = float(spent[learned - 1]) if learned else 0.0
    return Judged(scored, outcome.success.astype(float), len(agent.sampled.graph), minutes)


def _others(whole: Building, learned: Building) -> RecordedWorld:
    """Some of the drives that were not learned."""
    known = set(map(tuple, learned.pairs.tolist()))
    others = [
        trajectory
        for trajectory, pair in zip(whole.recorded.trajectories, whole.pairs.tolist(), strict=True)
        if tuple(pair) not in known
    ]
    return RecordedWorld(whole.scene, others[::_OTHER])


BRIEF = replace(TUNED, max_steps=40, eval_interval=20)
EXPERIMENT = Experiment(
    "ltvn_finetune",
    run,
    WORLDS,
    WORLDS[:2],
    settings=Settings(),
    quick_settings=Settings(CONDITIONS[:3]),
    canary=Settings(((SHIFTED, True),), queries=1, training=BRIEF),
)
