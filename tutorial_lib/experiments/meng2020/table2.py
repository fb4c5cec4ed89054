"""Table II of Meng 2020: success of navigation from place to place, and size of the maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import OPTIONAL, Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import difference, in_points, over_worlds, wilson
from tutorial_lib.experiments.meng2020 import table2_thresholds
from tutorial_lib.experiments.protocols.navigation import (
    ENDINGS,
    Result,
    attempt,
    navigate,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    draw_trials,
    make_building,
)
from tutorial_lib.interfaces import Agent
from tutorial_lib.parallel import for_each

PAPER = {"meng": (0.846, 0.957), "sptm": (0.402, 0.513)}
"""Success in the least and the most successful of the paper's five worlds."""


@dataclass(frozen=True)
class Settings:
    """Settings of Table II.

    Attributes:
        places: of a building; each ordered pair is joined by a recorded trajectory.
        trials: in each building.
    """

    places: int = PLACES
    trials: int = 200


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Let every agent learn every world, and run the same trials with each."""
    places: list[Any] = [*options.worlds] if options.map is None else [options.map]
    if options.agent:  # a faulty one is refused before any rollout
        agents.custom(options.agent)
    parts = for_each(run_world, places, options, settings, label="meng_table2")
    rows = [
        _row(place, world, method, found)
        for place, (world, results) in zip(places, parts, strict=True)
        for method, found in results.items()
    ]
    return rows, _notes([results for _, results in parts])


def run_world(
    place: Any,  # noqa: ANN401
    options: Options,
    settings: Settings,
) -> tuple[dict[str, Any], dict[str, Result]]:
    """All agents in one world: the columns that describe the world, and their results.

    Args:
        place: seed of a large generated world, or a map's file.
        options: of the run.
        settings: of the run.
    """
    building = make_building(
        place,
        options.seed,
        settings.places,
        options.palette,
        drifts=options.drifts,
        family=options.family,
    )
    seeds = [options.seed, place if isinstance(place, int) else 0, 1]
    trials = draw_trials(building, settings.trials, np.random.default_rng(seeds))
    entries: dict[str, Agent] = {
        "meng": agents.meng(),
        "sptm": agents.sptm(),
        "random": agents.random_agent(np.random.default_rng(seeds)),
    }
    if options.remedies:
        entries["meng"] = agents.remedied(options.remedies)
    found = {name: attempt(building, trials, agent) for name, agent in entries.items()}
    found["oracle"] = Result(
        navigate(
            building, trials, lambda sim: OracleNavigation(sim, building.paths, trials.goal_poses)
        )
    )
    if options.agent:
        own = agents.custom(options.agent)
        found["custom"] = agents.guarded(options.agent, attempt, building, trials, own)
    plan = building.scene.plan
    world = {
        "family": plan.family,
        "area": round(plan.area),
        "images": len(building.recorded.poses),
    }
    return world, found


def _row(place: Any, world: dict[str, Any], method: str, found: Result) -> dict[str, Any]:  # noqa: ANN401
    outcome = found.outcome
    success, low, high = wilson(outcome.success.astype(float))
    row: dict[str, Any] = {
        "world": place if isinstance(place, int) else place.name,
        **world,
        "method": method,
        "vertices": found.vertices,
        "edges": found.edges,
        "wormholes": found.wormholes,
        "trials": len(outcome.success),
        "success": success,
        "low": low,
        "high": high,
        "wrong_place": float(outcome.wrong.mean()),
    }
    return row | {name: float((outcome.ending == name).mean()) for name in ENDINGS[1:]}


def _notes(parts: list[dict[str, Result]]) -> tuple[str, ...]:
    """Success in all worlds together, and paired differences."""
    world = np.repeat(np.arange(len(parts)), [len(part["meng"].outcome.success) for part in parts])
    success = {
        name: np.concatenate([part[name].outcome.success for part in parts]).astype(float)
        for name in parts[0]
    }
    notes = []
    for name, values in success.items():
        share, low, high = over_worlds(values, world)
        notes.append(f"{name}, all worlds: {share:.1%} ({low:.1%} to {high:.1%})")
    for name in [other for other in success if other != "meng"]:
        found = difference(success["meng"], success[name], world)
        notes.append(f"meng - {name}: {in_points(found)}")
    for name in ("meng", "sptm"):
        edges, holes = (
            sum(getattr(part[name], what) for part in parts) for what in ("edges", "wormholes")
        )
        notes.append(f"{name}: {1 - holes / max(edges, 1):.2%} of {edges} edges are no wormholes")
    return tuple(notes)


EXPERIMENT = Experiment(
    "meng_table2",
    run,
    WORLDS,
    WORLDS[:3],
    Settings(),
    quick_settings=Settings(places=6, trials=40),
    accepts=frozenset(OPTIONAL),
    ablations={"thresholds": table2_thresholds.EXPERIMENT},
)
