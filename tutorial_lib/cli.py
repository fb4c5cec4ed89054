"""The commands: ``python -m tutorial_lib {lab,demo,progress,mark,build,train,...}``.

An installed course has them as ``topological-navigation``, too.
"""

from __future__ import annotations

import argparse
import os
import sys
from importlib import import_module
from pathlib import Path

from tutorial_lib import __version__
from tutorial_lib.commands.constants import INTERRUPTED, WRONG_INPUT
from tutorial_lib.commands.lab import open_lab
from tutorial_lib.course import NAME, cache_folder, is_checkout
from tutorial_lib.errors import InputError

COMMANDS = {
    "lab": "open JupyterLab on the first notebook; arguments go to it",
    "copy": "copy the pages of an installed course to a folder, as lab does before it opens them",
    "demo": "navigate once by sight; leaves demo.webm, demo.png, demo.json",
    "progress": "which exercises are done, in every notebook",
    "compile": "compile the numerical kernels now, which otherwise the first drive waits for",
    "mark": "check the answers that students handed in",
    "build": "write the notebooks from solutions/*.py",
    "train": "train a network from scratch, data included",
    "experiment": "reproduce a table or figure; experiment --help lists them",
    "bench": "measure the speed of a part; bench --help lists them",
    "results": "write the page of results from its JSON files",
}
"""What each command does; all but "lab" are modules of `tutorial_lib.commands`."""


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code; wrong input gets one line on stderr.

    Args:
        arguments: those of this process unless given.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    if not is_checkout():  # nothing is written beside an installed library
        os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder() / "numba"))
    try:
        if arguments[:1] == ["lab"]:  # the remaining arguments are JupyterLab's
            return open_lab(arguments[1:])
        options = parse(arguments)
        return options.run(options)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except OSError as error:
        print(f"error: {error}; check the folder and the disk space", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        print("interrupted; nothing half-written was left", file=sys.stderr)
        return INTERRUPTED


def parse(arguments: list[str]) -> argparse.Namespace:
    """The options of a command line; of the commands only the one it names is imported."""
    prog = NAME if Path(sys.argv[0]).stem == NAME else "python -m tutorial_lib"
    parser = argparse.ArgumentParser(prog=prog, description=__doc__)
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, words in COMMANDS.items():
        command = commands.add_parser(name, help=words)
        if [name] == arguments[:1]:
            module = import_module(f"tutorial_lib.commands.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    return parser.parse_args(arguments)
