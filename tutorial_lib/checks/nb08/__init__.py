"""Checks of notebook 08: maps that mend themselves."""

from tutorial_lib.checks.nb08.beliefs import check_bayes, check_gaussian
from tutorial_lib.checks.nb08.build_map import check_build_map
from tutorial_lib.checks.nb08.expand import check_expand
from tutorial_lib.checks.nb08.length import check_length
from tutorial_lib.checks.nb08.live import check_live

__all__ = [
    "check_bayes",
    "check_build_map",
    "check_expand",
    "check_gaussian",
    "check_length",
    "check_live",
]
