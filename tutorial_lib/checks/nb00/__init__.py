"""Checks of notebook 00: the installation."""

from tutorial_lib.checks.nb00.environment import check_environment

__all__ = [
    "check_environment",
]
