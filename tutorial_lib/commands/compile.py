"""Compiles the numerical kernels, which otherwise the first drive has to wait for."""

from __future__ import annotations

import argparse

from tutorial_lib.experiments.demos.task import choose_task
from tutorial_lib.world.generators import generate
from tutorial_lib.world.scene import Scene

_PLACES = 3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """There are no options."""


def run(options: argparse.Namespace) -> int:
    """Prepare a demo: what is compiled for that is kept beside the library's files."""
    del options
    task = choose_task(Scene(generate("apartment", 0)), 0, _PLACES)
    task.trial.recorded.observe(task.trial.goals)
    return 0
