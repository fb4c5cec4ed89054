"""LTVN's map at other thresholds: what do fewer vertices and fewer edges cost?

Images nearer than D_m to a vertex are left out, and vertices nearer than D_c are joined (LTVN,
Algorithm 1). In each building all maps are sampled from the same images, get the same queries, and
stay as they are.
"""

from dataclasses import dataclass, replace

import numpy as np

from tutorial_lib.agents.ltvn import TURNS
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Notes, Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.ltvn.lifelong import (
    FROZEN,
    NETWORK,
    WORLDS,
    Lived,
    families,
    prepared_agent,
)
from tutorial_lib.experiments.protocols.drives import TOUR, part_of
from tutorial_lib.experiments.protocols.lifelong import image_poses, run_queries
from tutorial_lib.experiments.protocols.navigation import sizes_of
from tutorial_lib.experiments.protocols.navigation_tasks import draw_trials, make_building
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.sampling_map import build


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        merge: D_m, metres.
        connect: D_c, metres; each is above all of `merge`.
        queries: of each map.
    """

    merge: tuple[float, ...] = (0.4, 0.7, 1.0)
    connect: tuple[float, ...] = (1.5, 2.0, 2.5, 3.0)
    queries: int = 50


def run(options: Options, settings: Settings) -> tuple[Rows, Notes]:
    """Run the same queries on every map of every building."""
    found = for_each(run_world, options.worlds, options.seed, settings, label="ltvn_size")
    by_world = dict(zip(options.worlds, found, strict=True))
    rows: Rows = []
    for family, worlds in families(options.worlds).items():
        for merge, connect in by_world[worlds[0]]:
            parts = [by_world[world][merge, connect] for world in worlds]
            values = np.concatenate([part.success for part in parts])
            success, low, high = over_worlds(values, np.repeat(worlds, settings.queries))
            sizes = np.array([part.sizes for part in parts], dtype=float)
            vertices, edges, wormholes = sizes.mean(axis=(0, 1)).tolist()
            row = {"merge": merge, "connect": connect, "family": family, "worlds": len(worlds)}
            row |= {"queries": len(values), "success": success, "low": low, "high": high}
            rows.append(row | {"vertices": vertices, "edges": edges, "wormholes": wormholes})
    return rows, ()


def run_world(world: int, seed: int, settings: Settings) -> dict[tuple[float, float], Lived]:
    """Success and size of each map of one building, by D_m and D_c."""
    whole = make_building(world, seed)
    building = part_of(whole, TOUR, seed)
    trials = draw_trials(whole, settings.queries, np.random.default_rng([seed, world, 1]))
    agent = prepared_agent(building, FROZEN, NETWORK)
    pool, rules = agent.sampled.pool, agent.sampled.rules
    found = {}
    for merge in settings.merge:
        for connect in settings.connect:
            thresholds = replace(rules, merge=merge, connect=connect)
            sampled = build(pool, thresholds, np.random.default_rng(agent.seed))
            sampled.join_by_turning(TURNS)
            agent.use(sampled)
            outcome, _ = run_queries(building, trials, agent)
            size = sizes_of(building, agent.sampled.graph, image_poses(building, agent))
            found[merge, connect] = Lived(outcome.success.astype(float), [size])
    return found


EXPERIMENT = Experiment(
    "ltvn_size",
    run,
    WORLDS,
    WORLDS[:2],
    settings=Settings(),
    quick_settings=Settings(merge=(0.7, 1.0), connect=(2.5,), queries=20),
    canary=Settings(merge=(0.7,), connect=(2.5,), queries=2),
)
