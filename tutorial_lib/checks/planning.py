"""Checks of notebook 06."""

from tutorial_lib.checks.deciding import check_decide
from tutorial_lib.checks.graphs import BY_HAND
from tutorial_lib.checks.joining import GOAL, HERE, check_join_ends
from tutorial_lib.checks.replanning import check_travel
from tutorial_lib.checks.tallying import check_tally, with_false_edge
from tutorial_lib.checks.ways import check_most_probable_way

__all__ = [
    "BY_HAND",
    "GOAL",
    "HERE",
    "check_decide",
    "check_join_ends",
    "check_most_probable_way",
    "check_tally",
    "check_travel",
    "with_false_edge",
]
