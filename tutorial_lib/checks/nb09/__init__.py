"""Checks of notebook 09: exploring a place never seen, with ghost nodes."""

from tutorial_lib.checks.nb09.add_ghosts import check_add_ghosts
from tutorial_lib.checks.nb09.explorable import check_explorable
from tutorial_lib.checks.nb09.explore import check_explore
from tutorial_lib.checks.nb09.global_policy import check_global_policy
from tutorial_lib.checks.nb09.small_maps import CELL, path_lengths
from tutorial_lib.checks.nb09.spl import check_spl

__all__ = [
    "CELL",
    "check_add_ghosts",
    "check_explorable",
    "check_explore",
    "check_global_policy",
    "check_spl",
    "path_lengths",
]
