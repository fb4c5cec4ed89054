"""Checks of notebook 04: sparsification and following."""

from tutorial_lib.checks.nb04.choose_anchors import BY_HAND, check_choose_anchors
from tutorial_lib.checks.nb04.frames_to_keep import check_frames_to_keep
from tutorial_lib.checks.nb04.move_on import check_move_on
from tutorial_lib.checks.nb04.tracked_waypoint import check_tracked_waypoint
from tutorial_lib.checks.nb04.transition import check_transition

__all__ = [
    "BY_HAND",
    "check_choose_anchors",
    "check_frames_to_keep",
    "check_move_on",
    "check_tracked_waypoint",
    "check_transition",
]
