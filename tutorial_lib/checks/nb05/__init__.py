"""Checks of notebook 05: map building."""

from tutorial_lib.checks.nb05.ahead_of import check_ahead_of
from tutorial_lib.checks.nb05.ask_next import check_ask_next
from tutorial_lib.checks.nb05.edge_weights import BY_HAND, DRIVEN, check_edge_weights
from tutorial_lib.checks.nb05.insert import check_insert
from tutorial_lib.checks.nb05.reusable import check_reusable
from tutorial_lib.checks.nb05.small_map import SmallMap
from tutorial_lib.checks.nb05.weakest_aligned import check_weakest_aligned

__all__ = [
    "BY_HAND",
    "DRIVEN",
    "SmallMap",
    "check_ahead_of",
    "check_ask_next",
    "check_edge_weights",
    "check_insert",
    "check_reusable",
    "check_weakest_aligned",
]
