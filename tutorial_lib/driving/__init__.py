"""Driving: geodesics, controllers without learning, closed-loop rollouts, and recorded data."""

from tutorial_lib.driving.control.composed import ComposedController, TargetPolicy
from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.control.rmp import RMPController, control_jacobian, point_jacobian
from tutorial_lib.driving.control.rmp_arcs import cover
from tutorial_lib.driving.data.demonstrations import demonstrate, demonstrate_between
from tutorial_lib.driving.data.episodes import draw_episodes
from tutorial_lib.driving.data.export import export_recording
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, perturbed
from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs, reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import covered
from tutorial_lib.driving.rollouts import NavigationEnds, ReachGoals, geodesic_limit, rollout

__all__ = [
    "PAPER_PERTURBATION",
    "ComposedController",
    "GridPaths",
    "NavigationEnds",
    "OraclePolicy",
    "RMPController",
    "ReachGoals",
    "RecordedWorld",
    "TargetPolicy",
    "control_jacobian",
    "cover",
    "covered",
    "demonstrate",
    "demonstrate_between",
    "draw_episodes",
    "draw_reachability_pairs",
    "export_recording",
    "geodesic_limit",
    "perturbed",
    "point_jacobian",
    "reachability_pairs",
    "rollout",
]
