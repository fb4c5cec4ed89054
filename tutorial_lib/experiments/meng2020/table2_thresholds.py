"""How much success depends on the threshold of RE, a probability, and of SPTM's similarity.

With `--drives` for agents that learned a part of the drives: what is best depends on how much.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.drives import part_of
from tutorial_lib.experiments.protocols.navigation import Result, attempt, measured
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, draw_trials, make_building
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.edge_rules import MapSettings

WORLDS = tuple(range(10_000, 10_003))
"""For validation: SPTM's threshold is chosen here."""
BEST = {"meng": 0.99, "sptm": agents.S_SHORTCUT}

Key = tuple[str, float, bool]
"""Method, threshold, and whether it replans."""


@dataclass(frozen=True)
class Settings:
    """Settings of the ablation.

    Attributes:
        places: of a building.
        trials: in each building.
        re: thresholds of RE.
        similarity: thresholds of SPTM's similarity, in ascending order.
    """

    places: int = PLACES
    trials: int = 40
    re: tuple[float, ...] = (0.9, 0.95, 0.97, 0.99)
    similarity: tuple[float, ...] = (0.9, 0.97, 0.99, 0.995, 0.999)


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Table II with other thresholds, and without replanning."""
    parts = for_each(run_world, options.worlds, options, settings, label="thresholds")
    return [_row(key, [part[key] for part in parts]) for key in parts[0]], []


def run_world(world: int, options: Options, settings: Settings) -> dict[Key, Result]:
    """All variants in one world, on the same trials."""
    whole = make_building(world, options.seed, settings.places, drifts=options.drifts)
    rng = np.random.default_rng([options.seed, world, 1])
    trials = draw_trials(whole, settings.trials, rng)
    building = part_of(whole, options.drives, options.seed)
    found: dict[Key, Result] = {}
    for least in settings.re:
        map_settings = MapSettings(p_edge=least, p_reuse=least)
        agent = agents.meng(settings=map_settings, p_sparsify=least)
        found["meng", least, True] = attempt(building, trials, agent)
        if least == BEST["meng"]:
            found["meng", least, False] = measured(building, trials, without_replanning(agent))
    first, *others = settings.similarity
    sptm = agents.sptm(s_shortcut=first)
    found["sptm", first, True] = attempt(building, trials, sptm)
    for least in others:
        sptm.join(least)
        found["sptm", least, True] = measured(building, trials, sptm)
        if least == BEST["sptm"]:
            found["sptm", least, False] = measured(building, trials, without_replanning(sptm))
    return found


def without_replanning(agent: Any) -> Any:  # noqa: ANN401 - Meng's or SPTM's
    """The same agent with the same map that never replans."""
    other = replace(agent, replan_time=0.0)
    other.topomap = agent.topomap
    return other


def _row(key: Key, parts: list[Result]) -> dict[str, Any]:
    method, threshold, replans = key
    world = np.repeat(np.arange(len(parts)), [len(part.outcome.success) for part in parts])
    success = np.concatenate([part.outcome.success for part in parts]).astype(float)
    share, low, high = over_worlds(success, world)
    sizes = {
        name: sum(getattr(part, name) for part in parts)
        for name in ("vertices", "edges", "wormholes")
    }
    row: dict[str, Any] = {"method": method, "threshold": threshold, "replans": replans, **sizes}
    return row | {"trials": len(success), "success": share, "low": low, "high": high}


EXPERIMENT = Experiment(
    "meng_table2_thresholds",
    run,
    WORLDS,
    settings=Settings(),
    quick_settings=Settings(trials=10),
    accepts=frozenset({"odometry", "drives"}),
)
