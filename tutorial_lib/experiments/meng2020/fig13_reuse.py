"""Fig. 13 by the rule of reuse: how much maps grow, and what that costs in navigation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.navigation import ONE, K, goals_of, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, draw_trials, make_building
from tutorial_lib.experiments.protocols.repeated_drives import repeated_drives
from tutorial_lib.geometry import Array
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.edge_rules import MapSettings

WORLDS = tuple(range(10_000, 10_003))
"""For validation: the rule is chosen here."""
RULES = (
    *((0.95, 1.0), (0.94, 1.0), (0.92, 1.0), (0.9, 1.0), (0.8, 1.0), (0.7, 1.0)),
    *((0.95, 0.95), (0.94, 0.94), (0.92, 0.92), (0.9, 0.9), (0.8, 0.9)),
)
"""`p_reuse` and `p_between`: vertices alone, then edges, too."""

Rule = tuple[float, float]


@dataclass(frozen=True)
class Settings:
    """Settings of the ablation.

    Attributes:
        places: of a building.
        frames: observed in each world; growth is that over the second half.
        at_once: trajectories recorded at a time.
        trials: in each world, with the maps of all frames.
    """

    places: int = PLACES
    frames: int = 100_000
    at_once: int = 45
    trials: int = 40


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Build a map by each rule from the same trajectories, and drive the same trials on it."""
    parts = for_each(run_world, options.worlds, options, settings, label="reuse")
    return [_row(rule, [part[rule] for part in parts]) for rule in RULES], []


def run_world(world: int, options: Options, settings: Settings) -> dict[Rule, dict[str, Array]]:
    """One world: for each rule the sizes of the map, and the outcome of each trial."""
    building = make_building(world, options.seed, settings.places, drifts=options.drifts)
    trials = draw_trials(building, settings.trials, np.random.default_rng([options.seed, world, 1]))
    usual = agents.meng()
    grown = {
        rule: replace(usual, settings=MapSettings(p_reuse=rule[0], p_between=rule[1]))
        for rule in RULES
    }
    rng = np.random.default_rng([options.seed, world, 5])
    half: dict[Rule, int] = {}
    for experience, frames in repeated_drives(building, settings.frames, settings.at_once, rng):
        anchors = usual.sparsified(experience)
        for rule, agent in grown.items():
            agent.insert(anchors)
            if frames >= settings.frames / 2:
                half.setdefault(rule, len(agent.topomap))
    goals, found = goals_of(trials, VIEWS["camera16"], K), {}
    for rule, agent in grown.items():
        outcome = navigate(building, trials, lambda _, agent=agent: agent.start(goals))
        found[rule] = {
            "half": np.array(half[rule]),
            "vertices": np.array(len(agent.topomap)),
            "edges": np.array(agent.topomap.graph.number_of_edges()),
            "success": outcome.success,
        }
    return found


def _row(rule: Rule, parts: list[dict[str, Array]]) -> dict[str, Any]:
    world = np.repeat(np.arange(len(parts)), [len(part["success"]) for part in parts])
    success = np.concatenate([part["success"] for part in parts]).astype(float)
    share, low, high = over_worlds(success, world)
    half, vertices, edges = (
        np.array([part[name] for part in parts]) for name in ("half", "vertices", "edges")
    )
    return {
        "goal_images": ONE,
        "p_reuse": rule[0],
        "p_between": rule[1],
        "vertices": float(vertices.mean()),
        "edges": float(edges.mean()),
        "growth": float((vertices / half - 1).mean()),
        "trials": len(success),
        "success": share,
        "low": low,
        "high": high,
    }


EXPERIMENT = Experiment(
    "meng_fig13_reuse",
    run,
    WORLDS,
    settings=Settings(),
    quick_settings=Settings(frames=10_000, trials=20),
    canary=Settings(places=5, frames=3_000, trials=4),
    accepts=frozenset({"odometry"}),
)
