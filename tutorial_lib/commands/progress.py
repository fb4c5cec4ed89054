"""Lists which exercises are done, in every notebook."""

import argparse

from tutorial_lib.checks.progress import progress, report
from tutorial_lib.course import course_folder


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """There are no options."""


def run(options: argparse.Namespace) -> int:
    """Print the list."""
    del options
    print(report(progress(course_folder() / "notebooks")))
    return 0
