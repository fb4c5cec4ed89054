"""Measures the speed of a part of the library."""

import argparse

from tutorial_lib.commands.experiment import add_common, run
from tutorial_lib.experiments.registry import BENCHMARKS

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the benchmarks and their options."""
    add_common(parser, BENCHMARKS)
