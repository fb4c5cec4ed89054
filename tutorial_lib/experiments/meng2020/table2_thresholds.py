"""How much hangs on a threshold: of RE, which is a probability, and of SPTM's similarity."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.navigation import Result, attempt, measured
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, building, trials
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.edge_rules import MapSettings

WORLDS = tuple(range(10_000, 10_003))
"""For validation: SPTM's threshold is chosen here."""
TRIALS, QUICK_TRIALS = 40, 10
RE, SIMILARITY = (0.9, 0.95, 0.97, 0.99), (0.9, 0.97, 0.99, 0.995, 0.999)
BEST = {"meng": 0.99, "sptm": agents.S_SHORTCUT}

Key = tuple[str, float, int]
"""Method, threshold, and how often who is lost plans anew."""


def run(options: Options) -> Report:
    """Table II with other thresholds, and without planning anew."""
    begun = time.perf_counter()
    worlds = options.worlds or WORLDS
    parts = for_each(run_world, worlds, options, label="thresholds")
    rows = [_row(key, [part[key] for part in parts]) for key in parts[0]]
    took = time.perf_counter() - begun
    return Report("meng_table2_thresholds", options.seed, worlds, options.quick, took, rows)


def run_world(world: int, options: Options) -> dict[Key, Result]:
    """All variants in one world, on the same trials."""
    house = building(world, options.seed, PLACES)
    count = QUICK_TRIALS if options.quick else TRIALS
    asked = trials(house, count, np.random.default_rng([options.seed, world, 1]))
    found: dict[Key, Result] = {}
    for least in RE:
        settings = MapSettings(p_edge=least, p_reuse=least)
        agent = agents.meng(settings=settings, p_sparsify=least)
        found["meng", least, agent.replans] = attempt(house, asked, agent)
        if least == BEST["meng"]:
            found["meng", least, 0] = measured(house, asked, replace_replans(agent))
    sptm = agents.sptm(s_shortcut=SIMILARITY[0])
    found["sptm", SIMILARITY[0], sptm.replans] = attempt(house, asked, sptm)
    for least in SIMILARITY[1:]:
        sptm.join(least)
        found["sptm", least, sptm.replans] = measured(house, asked, sptm)
        if least == BEST["sptm"]:
            found["sptm", least, 0] = measured(house, asked, replace_replans(sptm))
    return found


def replace_replans(agent: Any) -> Any:  # noqa: ANN401 - Meng's or SPTM's
    """The same agent, with the same map, that never plans anew."""
    other = replace(agent, replans=0)
    other.topomap = agent.topomap
    return other


def _row(key: Key, parts: list[Result]) -> dict[str, Any]:
    method, threshold, replans = key
    where = np.repeat(np.arange(len(parts)), [len(part.outcome.success) for part in parts])
    success = np.concatenate([part.outcome.success for part in parts]).astype(float)
    share, low, high = over_worlds(success, where)
    sizes = {
        name: sum(getattr(part, name) for part in parts)
        for name in ("vertices", "edges", "wormholes")
    }
    row: dict[str, Any] = {"method": method, "threshold": threshold, "replans": replans, **sizes}
    return row | {"trials": len(success), "success": share, "low": low, "high": high}
