"""Writes the page of results from its JSON files."""

from __future__ import annotations

import argparse

from tutorial_lib.commands.constants import PROJECT
from tutorial_lib.experiments.results_page.page import write_results


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """There are no options."""


def run(options: argparse.Namespace) -> int:
    """Write the page and what the README quotes."""
    del options
    for path in write_results(PROJECT / "README.md"):
        print(f"wrote {path.relative_to(PROJECT)}")
    return 0
