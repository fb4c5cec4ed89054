"""What templates may say of the library's settings: its modules, by the names they have there."""

from __future__ import annotations

from typing import Any

from tutorial_lib.agents import remedy_navigation
from tutorial_lib.driving import metrics
from tutorial_lib.driving.data import perturbation, reachability_pairs, recorded_world
from tutorial_lib.experiments.ltvn import model, spurious
from tutorial_lib.experiments.meng2020 import fig4, fig12_localization
from tutorial_lib.experiments.protocols import (
    local_control,
    navigation,
    navigation_tasks,
    reachability,
)
from tutorial_lib.experiments.robustness import disturbances, faults, plans
from tutorial_lib.learning import exploration_training
from tutorial_lib.topology import planner
from tutorial_lib.topology.following import transitions as follower
from tutorial_lib.topology.mapping import edge_rules, turn_edges

LIBRARY: dict[str, Any] = {
    "disturbances": disturbances,
    "edge_rules": edge_rules,
    "exploration_training": exploration_training,
    "faults": faults,
    "fig4": fig4,
    "fig12_localization": fig12_localization,
    "follower": follower,
    "local_control": local_control,
    "metrics": metrics,
    "model": model,
    "navigation": navigation,
    "navigation_tasks": navigation_tasks,
    "perturbation": perturbation,
    "plans": plans,
    "planner": planner,
    "reachability": reachability,
    "reachability_pairs": reachability_pairs,
    "recorded_world": recorded_world,
    "remedy_navigation": remedy_navigation,
    "spurious": spurious,
    "turn_edges": turn_edges,
}
