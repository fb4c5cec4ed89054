"""Copies the course's pages to where somebody reads them."""

from __future__ import annotations

import argparse
from pathlib import Path

from tutorial_lib.commands.pages import copy_pages


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the folder."""
    parser.add_argument(
        "folder", nargs="?", type=Path, default=Path(), help="the current one unless given"
    )


def run(options: argparse.Namespace) -> int:
    """Copy, and say where to begin."""
    copy_here(options.folder)
    print(f"Begin with {options.folder / 'notebooks' / '00_start_here.ipynb'}")
    return 0


def copy_here(folder: Path) -> None:
    """Copy the pages into a folder, and say which are there in an older version of one's own."""
    for name in copy_pages(folder):
        print(f"kept your {name}; for the one that is newer rename yours, and copy again")
    print(f"The course is in {folder.resolve()}")
