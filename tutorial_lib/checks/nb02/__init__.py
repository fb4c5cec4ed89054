"""Checks of notebook 02: local control."""

from tutorial_lib.checks.nb02.goal_policy import check_goal_policy
from tutorial_lib.checks.nb02.obstacle_policy import check_obstacle_policy
from tutorial_lib.checks.nb02.resolve import check_resolve
from tutorial_lib.checks.nb02.train_network import check_train_network
from tutorial_lib.checks.nb02.waypoint_label import check_waypoint_label, clear_sight

__all__ = [
    "check_goal_policy",
    "check_obstacle_policy",
    "check_resolve",
    "check_train_network",
    "check_waypoint_label",
    "clear_sight",
]
