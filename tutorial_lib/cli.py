"""The commands: ``python -m tutorial_lib {lab,demo,progress,mark,build,train,...}``.

An installed course has them as ``topological-navigation``, too.
"""

import argparse
import os
import re
import select
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import TextIO

from tutorial_lib import __version__
from tutorial_lib.commands.constants import CLOSED_PIPE, INTERRUPTED, WRONG_INPUT
from tutorial_lib.commands.lab import open_lab
from tutorial_lib.course import NAME, cache_folder, is_checkout
from tutorial_lib.errors import InputError, Notice, words_of

COMMANDS = {
    "lab": "open JupyterLab on the first notebook; arguments go to it",
    "copy": "copy the pages of an installed course to a folder, as lab does before it opens them",
    "demo": "navigate, explore or live in a building, on film; leaves demo.webm, .png and .json",
    "progress": "which exercises are done, in every notebook",
    "compile": "compile the numerical kernels now, which otherwise the first drive waits for",
    "mark": "check the answers that students handed in",
    "build": "write the notebooks from solutions/*.py",
    "train": "train a network, data included",
    "experiment": "reproduce a table or figure; experiment --help lists them",
    "leaderboard": "put a class of your own beside the library's; prints templates, merges boards",
    "bench": "measure the speed of a part; bench --help lists them",
    "results": "write the results page from its JSON files; --stale: check which still fit",
    "reproduce": "measure stored results again, those that no longer fit or all",
}
"""What each command does; all but "lab" are modules of `tutorial_lib.commands`."""
_COORDINATES = re.compile(r"-[\d.][^,]*(,[^,]*)+")
_NO_ROOM = re.compile(r"(allocate|[Ii]nsufficient|not enough) memory")  # torch and OpenCV say it


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code; wrong input gets one line on stderr.

    Args:
        arguments: those of this process unless given.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    if not is_checkout():  # nothing is written beside an installed library
        os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder() / "numba"))
    with suppress(ValueError):  # not in a thread
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C, workers and all
    try:
        with _notices_as_lines():
            code = _run(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        _discard_output()
        return CLOSED_PIPE
    return code


def _run(arguments: list[str]) -> int:
    """Run a command; what goes wrong is said in one line, unless it is a fault of the library."""
    try:
        if arguments[:1] == ["lab"]:  # the remaining arguments are JupyterLab's
            return open_lab(arguments[1:])
        options = parse(arguments)
        return options.run(options)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except OSError as error:
        if isinstance(error, BrokenPipeError) and _has_lost_its_reader():
            raise
        print(f"error: {error}; check the folder and the disk space", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        print(
            "interrupted; no file is half-written. The same experiment goes on with what was "
            "finished, unless a class, robot or map of your own was given",
            file=sys.stderr,
        )
        return INTERRUPTED
    except Exception as error:
        if not (isinstance(error, MemoryError) or _NO_ROOM.search(str(error))):
            raise
        print(
            f"error: memory ran out ({words_of(error)}); close other programs, or give a smaller "
            "map or fewer worlds",
            file=sys.stderr,
        )
        return WRONG_INPUT
    except SystemExit:
        sys.stdout.flush()  # of --help, which may have lost its reader, too
        raise


def _has_lost_its_reader() -> bool:
    """Whether what reads the output has ended, as `head` does; no other pipe of ours."""
    if not hasattr(select, "poll"):  # Windows
        return True
    outputs = select.poll()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # no file of the system's
            outputs.register(stream.fileno(), 0)
    return any(event & select.POLLERR for _, event in outputs.poll(0))


def _discard_output() -> None:
    """Let nothing be said at the end of the process about what nobody reads."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            with suppress(OSError, ValueError):  # no file of the system's
                os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


@contextmanager
def _notices_as_lines() -> Iterator[None]:
    """Print notices as lines; other warnings as Python does."""
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, Notice):
                print(f"note: {message}", file=sys.stderr)
            else:
                usual(message, category, filename, lineno, file, line)

        warnings.showwarning = show
        yield


def parse(arguments: list[str]) -> argparse.Namespace:
    """The options of a command line; of the commands only the one it names is imported."""
    arguments = _joined(arguments)
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


def _joined(arguments: list[str]) -> list[str]:
    """With coordinates joined to their option: argparse takes -1,2 for another one.

    >>> _joined(["demo", "--region", "-1,2", "--seed", "3"])
    ['demo', '--region=-1,2', '--seed', '3']
    """
    joined: list[str] = []
    for argument in arguments:
        if joined and joined[-1].startswith("--") and _COORDINATES.fullmatch(argument):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined
