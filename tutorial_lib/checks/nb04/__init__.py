"""Checks of notebook 04: sparsification and following."""

from tutorial_lib.checks.nb04.choose_anchors import BY_HAND, check_choose_anchors
from tutorial_lib.checks.nb04.follow_step import check_follow_step
from tutorial_lib.checks.nb04.frames_to_keep import check_frames_to_keep
from tutorial_lib.checks.nb04.move_on import check_move_on
from tutorial_lib.checks.nb04.toy_corridor import Memory
from tutorial_lib.checks.nb04.transition import check_transition

__all__ = [
    "BY_HAND",
    "Memory",
    "check_choose_anchors",
    "check_follow_step",
    "check_frames_to_keep",
    "check_move_on",
    "check_transition",
]
