"""Checks the answers that students handed in."""

from __future__ import annotations

import argparse
from pathlib import Path

from tutorial_lib.checks.marking import mark


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the folders."""
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="my_answers")


def run(options: argparse.Namespace) -> int:
    """Print every result."""
    for folder in options.folders:
        results = list(mark(folder))
        passed = sum(result.status == "passed" for result in results)
        print(f"{folder}: {passed} of {len(results)} pass")
        for result in results:
            print(f"  {result}")
    return 0
