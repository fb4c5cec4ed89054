"""Fig. 4 of Meng 2020: a map of two trajectories, dense, after pruning, and after reuse.

Beside it the map of all their frames, in which nothing is sparsified: a sparse one is to have less
than 1/10 of its vertices and 1/100 of its edges (III-E).
"""

from dataclasses import dataclass, replace

import numpy as np

from tutorial_lib.agents.meng import MengAgent
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
from tutorial_lib.observation import Experience
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.sparsify import contextified

EVERY = 1_000_000
"""So many candidates are all vertices."""
STAGES = {
    "dense": MapSettings(p_edge=0.0, p_reuse=1.0, sequence=0, candidates=EVERY),
    "pruned": MapSettings(p_reuse=1.0),
    "reused": MapSettings(),
}
"""Settings of the map of anchors at each stage."""
FRAMES = "every frame"
"""The stage whose vertices are all frames; its edges are pruned as those of the anchors are."""


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
    seen = list(experiences(building, pair))
    dense = agents.meng(settings=replace(STAGES["pruned"], candidates=EVERY), turns=None)
    for one in seen:
        dense.insert(every_frame(dense, one))
    maps = {FRAMES: dense.topomap.graph}
    for stage, map_settings in STAGES.items():
        agent = agents.meng(settings=map_settings)
        agent.learn(seen)
        maps[stage] = agent.topomap.graph
    frames = sum(len(one.observations) for one in seen)
    return [
        {"stage": stage, "vertices": len(graph), "edges": graph.number_of_edges(), "frames": frames}
        for stage, graph in maps.items()
    ], []


def every_frame(agent: MengAgent, experience: Experience) -> Anchors:
    """A trajectory of which each frame is an anchor."""
    seen = experience.observations
    contexts = contextified(agent.predictor.view.of(seen), agent.predictor.k)
    return Anchors(seen, contexts, experience.timestamps)


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
