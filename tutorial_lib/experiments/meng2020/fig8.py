"""Fig. 8 of Meng 2020: whole maps, to be drawn with a colour for each trajectory."""

from __future__ import annotations

import time
from typing import Any

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation import experiences, vertex_poses
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, building
from tutorial_lib.parallel import for_each


def run(options: Options) -> Report:
    """Build the maps of the first three worlds; where each vertex was seen is in the JSON."""
    begun = time.perf_counter()
    worlds = options.worlds or WORLDS[:3]
    rows = for_each(run_world, worlds, options.seed, label="meng_fig8")
    took = time.perf_counter() - begun
    return Report("meng_fig8", options.seed, worlds, options.quick, took, rows)


def run_world(world: int, seed: int) -> dict[str, Any]:
    """The row of one world: poses (V, 3) and trajectory (V,) of its vertices, and its edges."""
    house, agent = building(world, seed, PLACES), agents.meng()
    agent.learn(list(experiences(house)))
    topomap = agent.topomap
    return {
        "world": world,
        "family": house.scene.plan.family,
        "area": round(house.scene.plan.area),
        "images": len(house.recorded.poses),
        "vertices": len(topomap),
        "edges": topomap.graph.number_of_edges(),
        "poses": vertex_poses(house, topomap).round(3).tolist(),
        "trajectories": topomap.trajectory.tolist(),
        "pairs": [[int(s), int(t)] for s, t in topomap.graph.edges],
    }
