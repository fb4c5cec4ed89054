"""The command ``python -m tutorial_lib.builder mutants``: does every check reject every mutant?"""

import argparse
import sys
from pathlib import Path

from tutorial_lib.builder.mutants import survivors
from tutorial_lib.builder.page import sources_in
from tutorial_lib.checks.framework import guard
from tutorial_lib.commands.constants import PROJECT
from tutorial_lib.errors import InputError

_PATIENCE = 3.0
"""Seconds of a check that meets a mutant which never ends."""


def main(arguments: list[str]) -> int:
    """Print, for each exercise, its mutants and those that pass; 1 if one passes unexplained."""
    parser = argparse.ArgumentParser(prog="python -m tutorial_lib.builder", description=__doc__)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("mutants", help="mutate every solution and try its check")
    command.add_argument("names", nargs="*", help="of notebooks, as in 01_world_and_car")
    names = parser.parse_args(arguments).names
    sources = [one for one in sources_in(PROJECT / "solutions") if not names or one.stem in names]
    guard.SECONDS = _PATIENCE
    try:
        unexplained = sum(_report(source) for source in sources)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print("no mutant passes unexplained" if not unexplained else f"{unexplained} pass unexplained")
    return 1 if unexplained else 0


def _report(source: Path) -> int:
    """Print what became of the mutants of one notebook; return how many pass unexplained."""
    unexplained = 0
    known = PROJECT / "tests" / "harmless_mutants" / f"{source.stem}.json"
    for exercise, tried, passed in survivors(source, known):
        left = [survivor for survivor in passed if not survivor.reason]
        unexplained += len(left)
        rejected = tried - len(passed)
        words = f"{rejected} rejected, {len(passed) - len(left)} harmless, {len(left)} unexplained"
        print(f"{source.stem} {exercise.name}: {tried} mutants, {words}", flush=True)
        for survivor in left:
            print(f"    {survivor.change}", flush=True)
    return unexplained


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
