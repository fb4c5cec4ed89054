"""Writes the page of results from its JSON files."""

from __future__ import annotations

import argparse

from tutorial_lib.course import course_folder
from tutorial_lib.experiments.results_page.page import PAGE, write_results


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """There are no options."""


def run(options: argparse.Namespace) -> int:
    """Write the page and what the README quotes."""
    del options
    folder = course_folder()
    for path in write_results(folder / "README.md", folder / PAGE):
        print(f"wrote {path.relative_to(folder)}")
    return 0
