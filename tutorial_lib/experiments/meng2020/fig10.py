"""Fig. 10 of Meng 2020: success with maps made from a part of the trajectories."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation import K, experiences, goals_of, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, building, trials
from tutorial_lib.geometry import Array
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each

SHARES = (0.2, 0.4, 0.6, 0.8, 1.0)
TRIALS, QUICK_TRIALS = 60, 20


def run(options: Options) -> Report:
    """Learn fewer and fewer trajectories, and send the robot on the same trials.

    `no_generalisation` is the share of trials whose own trajectory was learned: who could only
    repeat a drive would succeed in these at most.
    """
    begun = time.perf_counter()
    worlds = options.worlds or (WORLDS[:3] if options.quick else WORLDS)
    parts = for_each(run_world, worlds, options, label="meng_fig10")
    rows = [_row(share, [part[share] for part in parts]) for share in SHARES]
    peak = max(row["success"] for row in rows)
    found = {row["share"]: row["success"] / peak for row in rows}
    notes = (f"with 60% of the trajectories {found[0.6]:.1%} of the peak",)
    took = time.perf_counter() - begun
    return Report("meng_fig10", options.seed, worlds, options.quick, took, rows, notes)


def run_world(world: int, options: Options) -> dict[float, dict[str, Array]]:
    """One world: what came of each trial with each share of the trajectories."""
    house = building(world, options.seed, PLACES)
    count = QUICK_TRIALS if options.quick else TRIALS
    asked = trials(house, count, np.random.default_rng([options.seed, world, 1]))
    goals = goals_of(asked, VIEWS["camera16"], K)
    order = np.random.default_rng([options.seed, world, 6]).permutation(len(house.pairs))
    found = {}
    for share in SHARES:
        kept = np.sort(order[: round(share * len(order))])
        agent = agents.meng()
        agent.learn(list(experiences(house, kept.tolist())))
        outcome = navigate(house, asked, _sender(agent, goals))
        found[share] = {
            "success": outcome.success,
            "learned": _among(asked.pairs, house.pairs[kept]),
            "vertices": np.full(len(asked), len(agent.topomap)),
        }
    return found


def _sender(agent: Any, goals: list[Any]) -> Any:  # noqa: ANN401
    return lambda _: agent.start(goals)


def _among(pairs: NDArray[np.intp], known: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(N,) which of the pairs (N, 2) are among those known (M, 2)."""
    return (pairs[:, None] == known).all(axis=-1).any(axis=1)


def _row(share: float, parts: list[dict[str, Array]]) -> dict[str, Any]:
    where = np.repeat(np.arange(len(parts)), [len(part["success"]) for part in parts])
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    success, low, high = over_worlds(columns["success"].astype(float), where)
    return {
        "method": "meng",
        "share": share,
        "trials": len(where),
        "success": success,
        "low": low,
        "high": high,
        "no_generalisation": float(columns["learned"].mean()),
        "vertices": float(columns["vertices"].mean()),
    }
