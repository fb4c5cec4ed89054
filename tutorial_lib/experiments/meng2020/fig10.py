"""Fig. 10 of Meng 2020: success with maps of a part of the trajectories."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.drives import share_order
from tutorial_lib.experiments.protocols.navigation import ONE, K, experiences, goals_of, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    draw_trials,
    make_building,
)
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each

SHARES = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Of the trajectories."""


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 10.

    Attributes:
        places: of a building.
        trials: in each world.
    """

    places: int = PLACES
    trials: int = 60


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Learn more and more of the trajectories; the trials are the same.

    `no_generalisation` is the share of trials whose own trajectory was learned: an agent that can
    only repeat trajectories succeeds in these at most.
    """
    parts = for_each(run_world, options.worlds, options, settings, label="meng_fig10")
    rows = [_row(share, [part[share] for part in parts]) for share in SHARES]
    peak = max(row["success"] for row in rows) or 1.0  # where none succeeds
    relative = {row["share"]: row["success"] / peak for row in rows}
    return rows, [f"with 60% of the trajectories {relative[0.6]:.1%} of the peak"]


def run_world(world: int, options: Options, settings: Settings) -> dict[float, dict[str, NDArray]]:
    """One world: the outcome of each trial for each share of the trajectories."""
    building = make_building(world, options.seed, settings.places, drifts=options.drifts)
    rng = np.random.default_rng([options.seed, world, 1])
    trials = draw_trials(building, settings.trials, rng)
    goals = goals_of(trials, VIEWS["camera16"], K)
    order = share_order(building, options.seed)
    found = {}
    for share in SHARES:
        kept = np.sort(order[: round(share * len(order))])
        agent = agents.meng()
        agent.learn(list(experiences(building, kept.tolist())))
        outcome = navigate(building, trials, _starter(agent, goals))
        found[share] = {
            "success": outcome.success,
            "learned": _among(trials.pairs, building.pairs[kept]),
            "vertices": np.full(len(trials), len(agent.topomap)),
        }
    return found


def _starter(agent: Any, goals: list[Any]) -> Any:  # noqa: ANN401
    return lambda _: agent.start(goals)


def _among(pairs: NDArray[np.intp], known: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(N,) which of the pairs (N, 2) are among the known (M, 2)."""
    return (pairs[:, None] == known).all(axis=-1).any(axis=1)


def _row(share: float, parts: list[dict[str, NDArray]]) -> dict[str, Any]:
    world = np.repeat(np.arange(len(parts)), [len(part["success"]) for part in parts])
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    success, low, high = over_worlds(columns["success"].astype(float), world)
    return {
        "method": "meng",
        "goal_images": ONE,
        "share": share,
        "trials": len(world),
        "success": success,
        "low": low,
        "high": high,
        "no_generalisation": float(columns["learned"].mean()),
        "vertices": float(columns["vertices"].mean()),
    }


EXPERIMENT = Experiment(
    "meng_fig10",
    run,
    WORLDS,
    WORLDS[:3],
    Settings(),
    quick_settings=Settings(trials=20),
    canary=Settings(places=5, trials=4),
    accepts=frozenset({"odometry"}),
)
