"""Fig. 4 of Meng 2020: a map of two trajectories, dense, after pruning, and after reuse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.navigation import experiences
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    Building,
    make_building,
)
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.topology.mapping.edge_rules import MapSettings

STAGES = {
    "dense": MapSettings(p_edge=0.0, p_reuse=1.0, sequence=0, candidates=1_000_000),
    "pruned": MapSettings(p_reuse=1.0),
    "reused": MapSettings(),
}
"""Settings of the map at each stage."""


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 4.

    Attributes:
        places: of the building.
        beside: metres to a frame of the other trajectory within which the two run side by side.
    """

    places: int = PLACES
    beside: float = 0.5


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Map the two trajectories that run side by side the farthest."""
    use_threads(2)
    building = make_building(options.worlds[0], options.seed, settings.places)
    pair = most_in_common(building, settings.beside)
    rows: Rows = []
    for stage, map_settings in STAGES.items():
        agent = agents.meng(settings=map_settings)
        agent.learn(list(experiences(building, pair)))
        graph = agent.topomap.graph
        rows.append(
            {"stage": stage, "vertices": len(graph), "edges": graph.number_of_edges()}
            | {"frames": sum(len(building.recorded.frames_of(i)) for i in pair)}
        )
    return rows, []


def most_in_common(building: Building, beside: float = Settings.beside) -> list[int]:
    """Indices of the two trajectories that run side by side the farthest.

    They have neither their start nor their goal in common.
    """
    recorded = building.recorded
    poses = [recorded.poses[recorded.frames_of(i)] for i in range(len(building.pairs))]
    best, most = [0, 1], -1
    for first, one in enumerate(poses):
        for second in range(first + 1, len(poses)):
            if (building.pairs[first] == building.pairs[second]).any():
                continue
            gap = np.linalg.norm(one[::5, None, :2] - poses[second][None, ::5, :2], axis=-1)
            turn = one[::5, None, 2] - poses[second][None, ::5, 2]
            common = int(((gap < beside) & (np.cos(turn) > 0.5)).any(axis=1).sum())
            if common > most:
                best, most = [first, second], common
    return best


EXPERIMENT = Experiment("meng_fig4", run, WORLDS[:1], settings=Settings())
