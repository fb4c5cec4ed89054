"""Checks of notebook 10: closing loops by walls, over a life of ten visits."""

from tutorial_lib.checks.nb10.accept import check_accept
from tutorial_lib.checks.nb10.correct import check_correct
from tutorial_lib.checks.nb10.fits import fit
from tutorial_lib.checks.nb10.match import check_match

__all__ = ["check_accept", "check_correct", "check_match", "fit"]
