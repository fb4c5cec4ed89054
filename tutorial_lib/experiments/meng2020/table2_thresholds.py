"""How much success depends on the threshold of RE, a probability, and of SPTM's similarity.

With `--drives` for agents that learned a part of the drives: what is best depends on how much. The
best ones of each share are entered in `protocols.thresholds.CHOSEN`, which Table II takes.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.drives import driven_trials, part_of
from tutorial_lib.experiments.protocols.navigation import (
    Result,
    attempt,
    experiences,
    measured,
    total_size,
)
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, draw_trials, make_building
from tutorial_lib.experiments.protocols.thresholds import Thresholds
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.edge_rules import MapSettings

WORLDS = tuple(range(10_000, 10_002))
"""For validation: SPTM's threshold is chosen here."""
BEST = {"meng": 0.99, "sptm": agents.S_SHORTCUT}


Key = tuple[str, float, bool]
"""Method, threshold, and whether it replans."""
InWorld = tuple[dict[Key, Result], NDArray[np.bool_]]
"""Of one world the results of every variant, and (N,) which trials a learned drive covers."""


@dataclass(frozen=True)
class Settings:
    """Settings of the ablation.

    Attributes:
        places: of a building.
        trials: in each building.
        re: p_edge of Meng's map, in ascending order.
        similarity: thresholds of SPTM's similarity, in ascending order.
    """

    places: int = PLACES
    trials: int = 40
    re: tuple[float, ...] = (0.9, 0.97, 0.99)
    similarity: tuple[float, ...] = (0.8, 0.9, 0.95, 0.97, 0.99, 0.999)


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Table II with other thresholds; with all drives also without replanning."""
    parts = for_each(run_world, options.worlds, options, settings, label="thresholds")
    rows = [_row(key, parts, options.drives) for key in parts[0][0]]
    if not options.drives:
        return rows, []
    if not rows[0]["trials_composed"]:
        raise InputError(f"--drives {options.drives}: no trial must be composed; give fewer drives")
    best = best_of(rows, "success_composed")
    found = f"p_edge {best.p_edge:g}, s_shortcut {best.s_shortcut:g}"
    return rows, [f"best with --drives {options.drives}: {found} (composed trials)"]


def best_of(rows: Rows, by: str) -> Thresholds:
    """The thresholds with the most success, in the column `by`; of equals the strictest."""
    best = [
        max(
            (row for row in rows if row["method"] == method and row["replans"]),
            key=lambda row: (row[by], row["threshold"]),
        )
        for method in ("meng", "sptm")
    ]
    return Thresholds(*(row["threshold"] for row in best))


def run_world(world: int, options: Options, settings: Settings) -> InWorld:
    """All variants in one world, on the same trials."""
    whole = make_building(world, options.seed, settings.places, drifts=options.drifts)
    rng = np.random.default_rng([options.seed, world, 1])
    trials = draw_trials(whole, settings.trials, rng)
    building = part_of(whole, options.drives, options.seed)
    found: dict[Key, Result] = {}
    usual = agents.meng()
    trajectories = [usual.sparsified(experience) for experience in experiences(building)]
    for least in settings.re:
        agent = replace(usual, settings=MapSettings(p_edge=least))
        for anchors in trajectories:
            agent.insert(anchors)
        found["meng", least, True] = measured(building, trials, agent)
        if least == BEST["meng"] and not options.drives:
            found["meng", least, False] = measured(building, trials, without_replanning(agent))
    first, *others = settings.similarity
    sptm = agents.sptm(s_shortcut=first)
    found["sptm", first, True] = attempt(building, trials, sptm)
    for least in others:
        sptm.join(least)
        found["sptm", least, True] = measured(building, trials, sptm)
        if least == BEST["sptm"] and not options.drives:
            found["sptm", least, False] = measured(building, trials, without_replanning(sptm))
    return found, driven_trials(whole, trials, options.drives, options.seed)


def without_replanning(agent: Any) -> Any:  # noqa: ANN401 - Meng's or SPTM's
    """The same agent with the same map that never replans."""
    other = replace(agent, replan_time=0.0)
    other.topomap = agent.topomap
    return other


def _row(key: Key, parts: list[InWorld], drives: str) -> dict[str, Any]:
    method, threshold, replans = key
    results = [found[key] for found, _ in parts]
    world = np.repeat(np.arange(len(parts)), [len(driven) for _, driven in parts])
    success = np.concatenate([part.outcome.success for part in results]).astype(float)
    share, low, high = over_worlds(success, world)
    row: dict[str, Any] = {"method": method, "threshold": threshold, "replans": replans}
    row |= dict(zip(("vertices", "edges", "wormholes"), total_size(results), strict=True))
    row |= {"trials": len(success), "success": share, "low": low, "high": high}
    if not drives:
        return row
    composed = ~np.concatenate([driven for _, driven in parts])
    found = float(success[composed].mean()) if composed.any() else None
    return row | {"trials_composed": int(composed.sum()), "success_composed": found}


EXPERIMENT = Experiment(
    "meng_table2_thresholds",
    run,
    WORLDS,
    settings=Settings(),
    quick_settings=Settings(trials=10),
    canary=Settings(places=5, trials=4, re=(0.99,), similarity=(0.97,)),
    accepts=frozenset({"odometry", "drives"}),
)
