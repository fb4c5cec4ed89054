"""Experiments: reproduced tables and figures, robustness, benchmarks and demos."""

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.results import load_result
from tutorial_lib.experiments.protocols.following import UNDER_WAY, Guide
from tutorial_lib.experiments.protocols.navigation import (
    WORMHOLE,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    building,
    facing,
    spread_places,
    trials,
)

__all__ = [
    "UNDER_WAY",
    "WORMHOLE",
    "Building",
    "Guide",
    "Trials",
    "agents",
    "building",
    "experiences",
    "facing",
    "goals_of",
    "load_result",
    "navigate",
    "spread_places",
    "trials",
    "vertex_poses",
]
