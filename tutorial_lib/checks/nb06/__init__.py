"""Checks of notebook 06: probabilistic planning."""

from tutorial_lib.checks.nb06.decide import check_decide
from tutorial_lib.checks.nb06.graphs import BY_HAND, GOAL, HERE
from tutorial_lib.checks.nb06.join_ends import check_join_ends
from tutorial_lib.checks.nb06.most_probable_path import check_most_probable_path
from tutorial_lib.checks.nb06.navigate import check_navigate, without
from tutorial_lib.checks.nb06.navigation_stories import Limits
from tutorial_lib.checks.nb06.tally import check_tally, with_false_edge
from tutorial_lib.checks.nb06.travel import check_travel

__all__ = [
    "BY_HAND",
    "GOAL",
    "HERE",
    "Limits",
    "check_decide",
    "check_join_ends",
    "check_most_probable_path",
    "check_navigate",
    "check_tally",
    "check_travel",
    "with_false_edge",
    "without",
]
