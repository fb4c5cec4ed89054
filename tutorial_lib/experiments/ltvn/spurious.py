"""A map with spurious edges, and without as many true ones: does it find back to what it was?

Before the first query a share of the edges is taken out, and as many are added between vertices far
apart, with the attributes of edges that were there. `ltvn_lifelong` has clean maps of the
same buildings.
"""

from dataclasses import dataclass
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.ltvn.lifelong import (
    FROZEN,
    MENDING,
    NETWORK,
    ORACLE,
    WORLDS,
    drawn,
    families,
    prepared_agent,
)
from tutorial_lib.experiments.protocols.lifelong import image_poses, run_queries
from tutorial_lib.experiments.protocols.navigation import WORMHOLE
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each

UPDATES = {"on": MENDING, "off": FROZEN}
TRIED = 4
"""Traversals after which an injected edge is expected to be gone."""
Edge = tuple[int, int]


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        shares: of the edges that are taken out, and added elsewhere.
        perceptions: see `ltvn_lifelong`.
        queries: in each building.
        block: queries of one row.
        fleet: robots that set off together.
    """

    shares: tuple[float, ...] = (0.2,)
    perceptions: tuple[str, ...] = (NETWORK,)
    queries: int = 200
    block: int = 50
    fleet: int = 25


@dataclass(frozen=True, eq=False)
class Block:
    """What happened in one block of queries.

    Attributes:
        success: (B,) of each query.
        gone: of the injected edges that were tried `TRIED` times or more, the share that is gone.
        pruned: of the true edges, the share that is pruned now.
    """

    success: Array
    gone: float
    pruned: float


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Spoil maps by each share, with updates and without."""
    keys = [
        (share, updates, perception)
        for share in settings.shares
        for updates in UPDATES
        for perception in settings.perceptions
    ]
    items = [(world, *key) for world in options.worlds for key in keys]
    found = for_each(spoilt, items, options.seed, settings, label="ltvn_spurious")
    by = dict(zip(items, found, strict=True))
    rows: Rows = []
    for family, worlds in families(options.worlds).items():
        for share, updates, perception in keys:
            parts = [by[world, share, updates, perception] for world in worlds]
            key = {"share": share, "updates": updates, "perception": perception, "family": family}
            rows += [
                _row(key | {"block": number}, worlds, blocks)
                for number, blocks in enumerate(zip(*parts, strict=True))
            ]
    return rows, [
        f"injected_gone: of the injected edges that were tried {TRIED} times or more",
        "true_pruned: of all edges that were there before, now",
    ]


def _row(key: dict[str, Any], worlds: list[int], blocks: tuple[Block, ...]) -> dict[str, Any]:
    values = np.concatenate([block.success for block in blocks])
    units = np.repeat(worlds, [len(block.success) for block in blocks])
    success, low, high = over_worlds(values, units)
    gone = np.array([block.gone for block in blocks])
    row = key | {"worlds": len(worlds), "queries": len(values)}
    row |= {"success": success, "low": low, "high": high}
    known = gone[np.isfinite(gone)]
    row["injected_gone"] = float(known.mean()) if known.size else None
    row["true_pruned"] = float(np.mean([block.pruned for block in blocks]))
    return row


def spoilt(item: tuple[int, float, str, str], seed: int, settings: Settings) -> list[Block]:
    """One building, one share, with or without updates."""
    world, share, updates, perception = item
    _, building, trials = drawn(world, seed, settings.queries)
    agent = prepared_agent(building, UPDATES[updates], perception)
    rng = np.random.default_rng([seed, world, 7])
    injected = spoil(building, agent, share, rng)
    true = set(agent.sampled.graph.edges) - injected
    blocks, tried = [], dict.fromkeys(injected, 0)
    for first in range(0, len(trials), settings.block):
        some = trials.subset(np.arange(first, min(first + settings.block, len(trials))))
        outcome, navigations = run_queries(building, some, agent, settings.fleet, first)
        for navigation in navigations:
            for traversal in navigation.traversals:
                if traversal.edge in tried:
                    tried[traversal.edge] += 1
        graph = agent.sampled.graph
        often = [edge for edge, times in tried.items() if times >= TRIED]
        gone = np.mean([not graph.has_edge(*edge) for edge in often]) if often else np.nan
        pruned = np.mean([not graph.has_edge(*edge) for edge in true])
        blocks.append(Block(outcome.success.astype(float), float(gone), float(pruned)))
    return blocks


def spoil(
    building: Building, agent: LTVNAgent, share: float, rng: np.random.Generator
) -> set[Edge]:
    """Take out a share of a map's edges, add as many between vertices far apart, return these."""
    graph: nx.DiGraph = agent.sampled.graph
    edges = sorted(graph.edges)
    count = round(share * len(edges))
    poses = image_poses(building, agent)
    attributes = [dict(graph.edges[edges[i]]) for i in rng.choice(len(edges), count)]
    graph.remove_edges_from(edges[i] for i in rng.choice(len(edges), count, replace=False))
    vertices, injected = agent.sampled.vertices, set[Edge]()
    while len(injected) < count:
        source, target = (int(v) for v in rng.choice(vertices, 2, replace=False))
        if np.hypot(*(poses[source] - poses[target])[:2]) > WORMHOLE:
            injected.add((source, target))
    # In a fixed order, so that the same seed spoils the same map.
    for edge, given in zip(sorted(injected), attributes, strict=True):
        graph.add_edge(*edge, **given)
    return injected


EXPERIMENT = Experiment(
    "ltvn_spurious",
    run,
    WORLDS,
    WORLDS[:2],
    settings=Settings(),
    quick_settings=Settings(
        shares=(0.2,), perceptions=(NETWORK, ORACLE), queries=100, block=20, fleet=20
    ),
    canary=Settings(shares=(0.2,), queries=4, block=2, fleet=2),
)
