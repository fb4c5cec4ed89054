"""A process that judges answers, one after the other, for the command `mark`.

It talks with the command by its standard input and output, and runs no student's code. Each answer
is judged in a fork of it, so that no answer finds the checks otherwise than the first one did.
"""

import gc
import os
import pickle
import signal
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from multiprocessing.connection import Pipe
from pathlib import Path
from typing import BinaryIO

from tutorial_lib.checks.framework import guard
from tutorial_lib.checks.framework.check import ENDLESS, Check, Result
from tutorial_lib.checks.marking.limits import end_with_parent
from tutorial_lib.checks.marking.stand_in import Ended, StandIn
from tutorial_lib.checks.marking.warden import (
    LIBRARY,
    LONGEST,
    USUAL,
    Report,
    Server,
    Start,
    imported,
    spawning,
)
from tutorial_lib.errors import InputError

_LATE = 2 * LONGEST  # seconds by the clock for a judgement
_GONE = "The check itself ended at this answer; look at the answer"


def all_checks() -> list[Check]:
    """Every check of the course, by notebook."""
    folder = Path(__file__).resolve().parents[1]
    found = []
    for package in sorted(folder.glob("nb[0-9][0-9]")):
        module = import_module(f"tutorial_lib.checks.{package.name}")
        found += [value for value in vars(module).values() if isinstance(value, Check)]
    return found


def judge(check: Check, file: str, text: bytes, start: Start) -> tuple[Result, str]:
    """The result of an answer, and what it printed.

    Args:
        check: of its exercise.
        file: its name.
        text: what is in it.
        start: see `warden`.
    """
    with start() as (connection, report):
        answer = StandIn(connection)
        try:
            answer.load(file, text, check.name)
        except guard.TimeUp:
            words = f"{file} has not ended after {guard.SECONDS:g} seconds; it may only define"
            result = Result(check.name, "failed", f"{words} functions. Does a loop never end?")
        except (InputError, Ended) as error:
            result = Result(check.name, "failed", str(error))
        else:
            result = check(answer)
    if answer.ended:
        result = Result(check.name, "failed", _how_it_ended(check, report))
    return result, report.get("printed", b"").decode("utf-8", "replace")


def _how_it_ended(check: Check, report: Report) -> str:
    """What to say of an answer whose process ended by itself."""
    status = report.get("status")
    if status is not None and -status in (9, 24):  # killed, or told that its time is up
        words = "its process was ended: it took too much time or memory"
        return f"{(check.endless or ENDLESS).format(seconds=guard.SECONDS)} ({words})"
    how = f" (by signal {-status})" if status and status < 0 else ""
    return f"Your code ends its process{how} before it is judged; return the answer instead."


class _Forked:
    """Judges in forks of this process, and starts answers from servers.

    There is a server for answers that do not import the library, one for those that do, and one for
    those that import something of the checks, as notebooks give it. The last one begins anew when
    something was compiled since, which its answers then have.
    """

    def __init__(self, folder: Path, hidden: Sequence[Path]) -> None:
        self.places = folder, hidden
        imported(USUAL)
        self.plain = Server(*self.places)
        self.missing = self.plain.missing
        imported(LIBRARY)
        self.library = Server(*self.places)
        self.checks: Server | None = None
        self._begun = set[str]()

    def judge(self, check: Check, file: str, text: bytes) -> tuple[Result, str]:
        """See `judge`."""
        if check.name not in self._begun:
            self._begun.add(check.name)
            check(check.reference)  # compiles and caches what later judgements need
            if self.checks and self.checks is not self.library:
                self.checks.close()
            self.checks = None
        return _judged_apart(check, file, text, self._start(check, text))

    def _start(self, check: Check, text: bytes) -> Start:
        if b"tutorial_lib.checks" in text:
            if self.checks is None:
                server = Server(*self.places)
                if server.missing != self.missing:
                    server.close()
                    server = self.library
                self.checks = server
            return self.checks
        given = any(type(value).__module__.startswith("tutorial_lib") for value in check.example)
        return self.library if given or b"tutorial_lib" in text else self.plain


class _Spawned:
    """Judges in this process, and starts each answer anew."""

    def __init__(self, folder: Path, hidden: Sequence[Path]) -> None:
        del hidden
        self.start, self.missing = spawning(folder)

    def judge(self, check: Check, file: str, text: bytes) -> tuple[Result, str]:
        """See `judge`."""
        return judge(check, file, text, self.start)


def main() -> None:
    """Judge what the command sends, until it sends nothing more."""
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)  # what a library prints
    with suppress(EOFError, BrokenPipeError):  # the command is gone
        forks, folder, hidden = pickle.load(requests)
        judges = (_Forked if forks else _Spawned)(folder, hidden)
        checks = {f"{check.notebook}_{check.name}": check for check in all_checks()}
        _send(answers, (list(checks), judges.missing))
        while True:
            exercise, text = pickle.load(requests)
            _send(answers, judges.judge(checks[exercise], f"{exercise}.py", text))
    os._exit(0)


def _send(answers: BinaryIO, message: object) -> None:
    pickle.dump(message, answers)
    answers.flush()


def _judged_apart(check: Check, file: str, text: bytes, start: Start) -> tuple[Result, str]:
    """A judgement in a process of its own; see `judge`."""
    result, sent = Pipe(duplex=False)
    gc.freeze()  # or collecting in the fork would copy all that it shares with this process
    child = os.fork()
    if child == 0:
        try:
            end_with_parent()
            sent.send(judge(check, file, text, start))
        finally:
            os._exit(0)
    sent.close()
    try:
        if result.poll(_LATE):
            return result.recv()
    except (EOFError, OSError):
        pass
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        result.close()
    return Result(check.name, "failed", _GONE), ""


if __name__ == "__main__":
    main()
