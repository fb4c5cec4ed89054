"""Fig. 8 of Meng 2020: whole maps, to be drawn with a colour for each trajectory."""

from dataclasses import dataclass
from typing import Any

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.navigation import experiences, vertex_poses
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, WORLDS, make_building
from tutorial_lib.parallel import for_each


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 8.

    Attributes:
        places: of a building.
    """

    places: int = PLACES


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Build the map of each world; the JSON holds the pose at which each vertex was observed."""
    return for_each(run_world, options.worlds, options, settings, label="meng_fig8"), []


def run_world(world: int, options: Options, settings: Settings) -> dict[str, Any]:
    """The row of one world: poses (V, 3) and trajectories (V,) of the vertices, and the edges."""
    building = make_building(world, options.seed, settings.places, drifts=options.drifts)
    agent = agents.meng()
    agent.learn(list(experiences(building)))
    topomap = agent.topomap
    return {
        "world": world,
        "family": building.scene.plan.family,
        "area": round(building.scene.plan.area),
        "images": len(building.recorded.poses),
        "vertices": len(topomap),
        "edges": topomap.graph.number_of_edges(),
        "poses": vertex_poses(building, topomap).round(3).tolist(),
        "trajectories": topomap.trajectory.tolist(),
        "pairs": [[int(s), int(t)] for s, t in topomap.graph.edges],
    }


EXPERIMENT = Experiment(
    "meng_fig8",
    run,
    WORLDS[:3],
    settings=Settings(),
    canary=Settings(places=5),
    accepts=frozenset({"odometry"}),
)
