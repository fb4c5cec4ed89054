"""Fig. 4 of Meng 2020: a map of two trajectories, dense, after pruning, and after reuse."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation import experiences
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, Building, building
from tutorial_lib.learning.estimators import use_threads
from tutorial_lib.topology.mapping.edge_rules import MapSettings

STAGES = {
    "dense": MapSettings(p_edge=0.0, p_reuse=1.0, sequence=0, candidates=1_000_000),
    "pruned": MapSettings(p_reuse=1.0),
    "reused": MapSettings(),
}
"""Settings of the map, stage by stage."""
_BESIDE = 0.5  # metres from a frame of the other trajectory within which both run together


def run(options: Options) -> Report:
    """Join the two trajectories that have most of their way in common, in the first world."""
    begun = time.perf_counter()
    worlds = options.worlds[:1] or WORLDS[:1]
    use_threads(2)
    house = building(worlds[0], options.seed, PLACES)
    pair = most_in_common(house)
    rows: list[dict[str, Any]] = []
    for stage, settings in STAGES.items():
        agent = agents.meng(settings=settings)
        agent.learn(list(experiences(house, pair)))
        graph = agent.topomap.graph
        rows.append(
            {"stage": stage, "vertices": len(graph), "edges": graph.number_of_edges()}
            | {"frames": sum(len(house.recorded.frames_of(number)) for number in pair)}
        )
    took = time.perf_counter() - begun
    return Report("meng_fig4", options.seed, worlds, options.quick, took, rows)


def most_in_common(house: Building) -> list[int]:
    """Numbers of two drives, to different places, that run together farthest."""
    drives = [house.recorded.poses[house.recorded.frames_of(n)] for n in range(len(house.pairs))]
    best, most = [0, 1], -1
    for first, one in enumerate(drives):
        for second in range(first + 1, len(drives)):
            if (house.pairs[first] == house.pairs[second]).any():
                continue
            gap = np.linalg.norm(one[::5, None, :2] - drives[second][None, ::5, :2], axis=-1)
            turn = one[::5, None, 2] - drives[second][None, ::5, 2]
            common = int(((gap < _BESIDE) & (np.cos(turn) > 0.5)).any(axis=1).sum())
            if common > most:
                best, most = [first, second], common
    return best
