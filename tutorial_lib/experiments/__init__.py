"""Experiments: reproduced tables and figures, robustness, benchmarks and demos."""

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.results import load_result
from tutorial_lib.experiments.protocols.drives import driven_trials, part_of
from tutorial_lib.experiments.protocols.following import UNDER_WAY, Guide
from tutorial_lib.experiments.protocols.lifelong import (
    deep_experiences,
    image_poses,
    run_fleet,
    run_queries,
    score_map,
)
from tutorial_lib.experiments.protocols.lookalikes import (
    Office,
    draw_ambiguous_trials,
    make_office,
)
from tutorial_lib.experiments.protocols.navigation import (
    WORMHOLE,
    edge_lengths,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    explored,
    facing,
    make_building,
    spread_places,
    trials_from_anywhere,
)

__all__ = [
    "UNDER_WAY",
    "WORMHOLE",
    "Building",
    "Guide",
    "Office",
    "Trials",
    "agents",
    "deep_experiences",
    "draw_ambiguous_trials",
    "draw_trials",
    "driven_trials",
    "edge_lengths",
    "experiences",
    "explored",
    "facing",
    "goals_of",
    "image_poses",
    "load_result",
    "make_building",
    "make_office",
    "navigate",
    "part_of",
    "run_fleet",
    "run_queries",
    "score_map",
    "spread_places",
    "trials_from_anywhere",
    "vertex_poses",
]
