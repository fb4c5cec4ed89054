"""Puts a class of one's own beside the library's, by the experiment that judges what it is."""

import argparse
import json
import sys
from collections.abc import Iterable
from hashlib import sha256
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from joblib import parallel_config

from tutorial_lib.checks.framework import guard
from tutorial_lib.commands.constants import WRONG_INPUT
from tutorial_lib.errors import InputError, one_line, words_of
from tutorial_lib.experiments.common.experiment import library_hash
from tutorial_lib.experiments.demos.recorder import FILM_RATE
from tutorial_lib.experiments.failures import Trip, film_of
from tutorial_lib.experiments.leaderboard import (
    CONTESTS,
    LONGEST,
    Entry,
    judged,
    merged,
    page_of,
    ranked,
    read_board,
    text_of,
)
from tutorial_lib.files import check_writable, write_files
from tutorial_lib.reading.limits import MAX_TEXT
from tutorial_lib.reading.regular import read_bytes
from tutorial_lib.viz.figures.film import write_film

FOLDER = Path(__file__).resolve().parents[1] / "templates"
FIRST, QUICK, WHOLE = 120.0, 1_200.0, 14_400.0
"""Seconds of the processor that a class may take for its first try, a quick run, a whole one."""
WAITING, START = 5.0, 600.0
"""How many times as long it may take by the clock of a busy machine, and its process to begin."""
MEMORY = 4e9
"""Bytes that it may take, on Linux."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is put on the board, and where the board is."""
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--agent", default="", metavar="FILE.py:CLASS", help="a class of your own")
    what.add_argument(
        "--merge", nargs="+", type=Path, default=[], metavar="OTHER.json", help="other boards"
    )
    known = sorted(path.stem for path in FOLDER.glob("[a-z]*.py"))
    what.add_argument("--template", choices=known, help="print a class to begin with")
    parser.add_argument("--quick", action="store_true", help="fewer worlds and episodes, same code")
    parser.add_argument("--board", type=Path, default=Path("leaderboard.json"), metavar="FILE")
    parser.add_argument("--page", type=Path, default=Path("leaderboard.html"), metavar="FILE")
    film = Path("leaderboard.webm")
    parser.add_argument(
        "--film", type=Path, default=film, metavar="FILE", help="of its worst failure"
    )


def run(options: argparse.Namespace) -> int:
    """Print a template, or put entries on the board and write its page."""
    if options.template:
        print((FOLDER / f"{options.template}.py").read_text(encoding="utf-8"), end="")
        return 0
    if options.page.resolve() == options.board.resolve():
        raise InputError(f"--page: {options.page} is the board itself; give another file")
    file, colon, _ = options.agent.rpartition(":")
    if options.agent and not (colon and Path(file).is_file()):
        words = f"there is no file {file}; " if colon else ""
        raise InputError(f"--agent {options.agent}: {words}give FILE.py:CLASS")
    if options.film.suffix != ".webm":
        raise InputError(f"--film: {options.film}; a film's name ends in .webm, rename it")
    for path in (options.board, options.page, options.film):
        check_writable(path)
    board = _add(options, [entry for path in options.merge for entry in read_board(path)])
    if not options.agent:
        print(f"{len(board)} entries in {options.board}, shown by {options.page}")
        return 0
    entry, trip = _entered(options, board)
    for (seam, name, *_), entries in ranked(_add(options, [entry])).items():
        if entry in entries:
            print(f"{seam}: {name}, {CONTESTS[name].score[0]}")
            for place, one in enumerate(entries, 1):
                print(f"{place:3}  {one.score:.3f}  {one.name}{'  <- you' if one == entry else ''}")
    if trip is not None:
        name = entry.name.rpartition(":")[2]
        write_film(options.film, film_of(trip, name), FILM_RATE)
        print(f"worst failure: {trip.gap:.1f} m from its goal in {trip.world}, see {options.film}")
    if entry.fault:
        print(f"error: {entry.name}: {entry.fault}", file=sys.stderr)
    return WRONG_INPUT if entry.fault else 0


def _add(options: argparse.Namespace, entries: Iterable[Entry]) -> list[Entry]:
    """Add to the board, and write its page; another run may have added to it meanwhile."""
    board = read_board(options.board) if options.board.exists() else []
    board = merged([*board, *entries])
    texts = {options.board: text_of(board), options.page: page_of(board)}
    write_files({path: text.encode() for path, text in texts.items()})
    return board


def _entered(options: argparse.Namespace, board: list[Entry]) -> tuple[Entry, Trip | None]:
    """Judge a class, after the references that are not on the board; or say how it fails.

    Returns:
        The entry, and its worst failure, if there is one.
    """
    where, quick = options.agent, options.quick
    file, _, name = where.rpartition(":")
    sha = sha256(read_bytes(Path(file), MAX_TEXT)).hexdigest()
    _say(f"{where}: a first try")
    found = apart(FIRST, where, quick, True)
    if "fault" not in found:
        contest = CONTESTS[found["experiment"]]
        have = {(one.experiment, one.name, one.quick, one.sha) for one in board}
        names = contest.references
        if not have.issuperset((contest.name, one, quick, library_hash()) for one in names):
            _say(f"{contest.name}: {', '.join(names)}")
            _add(options, contest.refer(quick=quick))
        _say(f"{contest.name}: {where}")
        found |= apart(QUICK if quick else WHOLE, where, quick, False)
    if "fault" in found:
        fault = one_line(found["fault"].removeprefix(f"--agent {where}: "))
        found = found | {"fault": fault, "worlds": (), "rows": []}
    found["worlds"] = tuple(found["worlds"])
    failure, named = found.pop("failure", None), one_line(f"{Path(file).name}:{name}", LONGEST)
    entry = Entry(name=named, sha=sha, quick=quick, **found)
    return entry, None if failure is None else Trip.read(failure)


def _say(words: str) -> None:
    print(words, file=sys.stderr, flush=True)


def apart(seconds: float, where: str, quick: bool, first: bool) -> dict[str, Any]:
    """`limited` in a process of its own, which is killed if all else fails."""
    ours, theirs = get_context("spawn").Pipe(duplex=False)
    given = theirs, seconds, where, quick, first
    process = get_context("spawn").Process(target=_send, args=given, daemon=True)
    process.start()
    theirs.close()
    try:
        if ours.poll(START + 2 * WAITING * seconds):
            return json.loads(ours.recv_bytes())
        return {"fault": f"does not end after {seconds:g} seconds, whatever is done to end it"}
    except EOFError:
        process.join()
        return {"fault": f"its process ended itself or was killed (exit code {process.exitcode})"}
    finally:
        process.kill()
        process.join()


def _send(to: Connection, seconds: float, where: str, quick: bool, first: bool) -> None:
    to.send_bytes(json.dumps(limited(seconds, where, quick, first)).encode())


def limited(seconds: float, where: str, quick: bool, first: bool) -> dict[str, Any]:
    """What `judged` returns within `seconds` of the processor and `MEMORY`, on one core."""
    guard.SECONDS, guard.WAITING, guard.MEMORY = seconds, WAITING * seconds, MEMORY
    file = Path(where.rpartition(":")[0]).absolute()
    try:
        with parallel_config(backend="sequential"):
            return guard.limited(lambda _: judged(where, quick=quick, first=first), file)
    except BaseException as error:
        return {"fault": str(error) if isinstance(error, InputError) else words_of(error)}
