"""Table II of Meng 2020: how often a robot finds from place to place, and with how large a map."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import difference, in_points, over_worlds, wilson
from tutorial_lib.experiments.meng2020 import table2_thresholds
from tutorial_lib.experiments.protocols.navigation import (
    ENDINGS,
    Result,
    attempt,
    navigate,
)
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, building, trials
from tutorial_lib.interfaces import Agent
from tutorial_lib.parallel import for_each

WORLDS = tuple(range(20_000, 20_005))
TRIALS, QUICK_PLACES, QUICK_TRIALS = 200, 6, 40
PAPER = {"meng": (0.846, 0.957), "sptm": (0.402, 0.513)}
"""Success in the least and the most successful of the paper's five worlds."""


def run(options: Options) -> Report:
    """Let every method learn every world, and send it on the same trials."""
    if options.ablation:
        return table2_thresholds.run(options)
    begun = time.perf_counter()
    worlds = options.worlds or (WORLDS[:3] if options.quick else WORLDS)
    places: list[Any] = list(worlds)
    if options.map is not None:
        worlds, places = (), [options.map]
    if options.agent:  # before anything is driven
        agents.custom(options.agent)
    parts = for_each(run_world, places, options, label="meng_table2")
    rows = [
        _row(place, house, method, found)
        for place, (house, results) in zip(places, parts, strict=True)
        for method, found in results.items()
    ]
    took = time.perf_counter() - begun
    where = "" if options.map is None else options.map.name
    notes = _notes([results for _, results in parts])
    return Report("meng_table2", options.seed, worlds, options.quick, took, rows, notes, where)


def run_world(place: Any, options: Options) -> tuple[dict[str, Any], dict[str, Result]]:  # noqa: ANN401
    """All methods in one world: what the world is like, and their results.

    Args:
        place: seed of a large generated world, or a map's file.
        options: what was asked for.
    """
    count = QUICK_PLACES if options.quick else PLACES
    house = building(place, options.seed, count, options.palette)
    seeds = [options.seed, place if isinstance(place, int) else 0, 1]
    asked = trials(house, QUICK_TRIALS if options.quick else TRIALS, np.random.default_rng(seeds))
    entries: dict[str, Agent] = {
        "meng": agents.meng(),
        "sptm": agents.sptm(),
        "random": agents.random_agent(np.random.default_rng(seeds)),
    }
    found = {name: attempt(house, asked, agent) for name, agent in entries.items()}
    found["oracle"] = Result(
        navigate(house, asked, lambda sim: OracleNavigation(sim, house.paths, asked.goal_poses))
    )
    if options.agent:
        own = agents.custom(options.agent)
        found["custom"] = agents.guarded(options.agent, attempt, house, asked, own)
    plan = house.scene.plan
    world = {
        "family": plan.family,
        "area": round(plan.area),
        "images": len(house.recorded.poses),
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
    where = np.repeat(np.arange(len(parts)), [len(part["meng"].outcome.success) for part in parts])
    success = {
        name: np.concatenate([part[name].outcome.success for part in parts]).astype(float)
        for name in parts[0]
    }
    notes = []
    for name, values in success.items():
        share, low, high = over_worlds(values, where)
        notes.append(f"{name}, all worlds: {share:.1%} ({low:.1%} to {high:.1%})")
    for name in [other for other in success if other != "meng"]:
        found = difference(success["meng"], success[name], where)
        notes.append(f"meng - {name}: {in_points(found)}")
    for name in ("meng", "sptm"):
        edges, holes = (
            sum(getattr(part[name], what) for part in parts) for what in ("edges", "wormholes")
        )
        notes.append(f"{name}: {1 - holes / max(edges, 1):.2%} of {edges} edges are no wormholes")
    return tuple(notes)
