"""Writes the notebooks, their guides, and the sheet of their first pictures."""

import argparse
from pathlib import Path

from tutorial_lib.commands.constants import PROJECT
from tutorial_lib.course import is_checkout
from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the names and options."""
    parser.add_argument("names", nargs="*", help="as in 01_world_and_car; all unless given")
    parser.add_argument(
        "--students", action="store_true", help="only what students get; runs nothing"
    )
    parser.add_argument(
        "--slides",
        metavar="DIR",
        type=Path,
        help="write slides there instead, an HTML file each; runs every notebook",
    )


def run(options: argparse.Namespace) -> int:
    """Write the guides, the notebooks, and the sheet of their first pictures."""
    if not is_checkout():
        raise InputError("build: only in the course's checkout, which has the sources")
    try:
        from tutorial_lib.builder import build, write_contact_sheet, write_guides, write_slides
    except ImportError as error:
        advice = '.venv/bin/python -m pip install -e ".[test]"'
        raise InputError(f"build: {error}; install what it needs: {advice}") from error
    known = {source.stem: source for source in sorted(PROJECT.glob("solutions/*.py"))}
    for name in options.names:
        if name not in known:
            raise InputError(f"build: no solutions/{name}.py; there are {', '.join(known)}")
    if options.students and options.slides is not None:
        raise InputError("build: --students writes no slides; give --slides DIR alone")
    names = options.names or known
    if options.slides is not None:
        make_folder(options.slides)
        for name in names:
            print(f"wrote {write_slides(known[name], options.slides)}")
        return 0
    print(*(f"wrote {file.relative_to(PROJECT)}" for file in write_guides(PROJECT)), sep="\n")
    for name in names:
        for file in build(known[name], PROJECT, students_only=options.students):
            print(f"wrote {file.relative_to(PROJECT)}")
    if not options.students:
        print(f"wrote {write_contact_sheet(PROJECT).relative_to(PROJECT)}")
    return 0
