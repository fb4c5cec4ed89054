"""Has all answers of a class judged, on all cores."""

import os
import pickle
import queue
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import joblib
from numpy.typing import NDArray

import tutorial_lib
from tutorial_lib.checks.framework.check import Result, Status
from tutorial_lib.checks.marking.handed_in import Student
from tutorial_lib.checks.marking.warden import pipes
from tutorial_lib.errors import InputError, one_line

_LIBRARY = Path(tutorial_lib.__file__).resolve().parents[1]
_SOLUTIONS = ("solutions", "tests/wrong_answers")
"""Folders of the course in which answers stand."""
_WORKERS = 8
_SETTINGS = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    "NUMBA_NUM_THREADS": "1",
    "MPLBACKEND": "Agg",
    "PYTHONDONTWRITEBYTECODE": "1",
    "TUTORIAL_ANSWERS": "",
}
"""Of workers: a process with several threads could not be forked safely."""


@dataclass(frozen=True)
class Mark:
    """What became of an exercise.

    Attributes:
        exercise: as in ``01_to_local``.
        status: "passed", "failed", "not attempted" or "not handed in".
        message: what the check says; no control characters but line ends.
        printed: by the answer, likewise.
        picture: what is expected and yours, or None.
    """

    exercise: str
    status: Status | Literal["not handed in"]
    message: str = ""
    printed: str = ""
    picture: NDArray | None = None


def printable(text: str) -> str:
    """Text without control characters but line ends, which no terminal obeys."""
    return "\n".join(one_line(line) for line in text.splitlines()).strip()


class Workers:
    """Processes that judge answers.

    Attributes:
        exercises: of the course, as in ``01_to_local``.
        missing: what answers are not kept from on this system; empty if nothing.
    """

    def __init__(self, folder: Path, hidden: Sequence[Path]) -> None:
        """Of processes whose answers may write into `folder`, and do not see what is `hidden`."""
        self._setup = sys.platform == "linux", folder, tuple(hidden)
        self._all: list[subprocess.Popen[bytes]] = []
        self._over = False
        self._idle: queue.SimpleQueue[subprocess.Popen[bytes]] = queue.SimpleQueue()
        self.exercises, self.missing = list[str](), ""

    def start(self, count: int) -> None:
        """Start so many processes, side by side."""
        begun = [self._start() for _ in range(count)]
        for worker in begun:
            self.exercises, self.missing = self._ready(worker)
            self._idle.put(worker)

    def _start(self) -> subprocess.Popen[bytes]:
        worker = subprocess.Popen(
            [sys.executable, "-m", "tutorial_lib.checks.marking.worker"],
            cwd=_LIBRARY,
            env={**os.environ, **_SETTINGS},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        self._all.append(worker)
        return worker

    def _ready(self, worker: subprocess.Popen[bytes]) -> tuple[list[str], str]:
        try:
            return _asked(worker, self._setup)
        except (EOFError, OSError):
            raise InputError("the judging process does not start; try: start.py test") from None

    def judge(self, exercise: str, text: bytes | InputError | None) -> Mark:
        """The mark of an answer; None stands for one that was not handed in."""
        if text is None:
            return Mark(exercise, "not handed in")
        if isinstance(text, InputError):
            return Mark(exercise, "failed", printable(str(text)))
        worker = self._idle.get()
        try:
            result, printed = _asked(worker, (exercise, text))
        except (EOFError, OSError, pickle.UnpicklingError):
            if self._over:
                raise
            worker.kill()
            worker = self._start()
            self._ready(worker)
            result, printed = Result(exercise, "failed", "the judging process was ended"), ""
        finally:
            self._idle.put(worker)
        return Mark(
            exercise, result.status, printable(result.message), printable(printed), result.picture
        )

    def stop(self) -> None:
        """End the processes, and what they have started."""
        self._over = True
        for worker in self._all:
            worker.kill()
            with suppress(OSError):
                pipes(worker)[0].close()
        for worker in self._all:
            worker.wait()
            pipes(worker)[1].close()


def _asked(worker: subprocess.Popen[bytes], message: object) -> Any:  # noqa: ANN401
    given, said = pipes(worker)
    pickle.dump(message, given)
    given.flush()
    return pickle.load(said)


@contextmanager
def judges(folders: Sequence[Path]) -> Iterator[Workers]:
    """Processes that judge, until the end of the block.

    Args:
        folders: that were handed in, which no answer sees.
    """
    hidden = [*folders, *(_LIBRARY / name for name in _SOLUTIONS)]
    hidden = [place.resolve() for place in hidden if place.is_dir() and _may_hide(place.resolve())]
    folder = Path(tempfile.mkdtemp(prefix="mark-")).resolve()
    folder.chmod(0o755)
    found = Workers(folder, hidden)
    try:
        found.start(min(joblib.cpu_count(), _WORKERS))
        yield found
    finally:
        found.stop()
        shutil.rmtree(folder, ignore_errors=True)


def _may_hide(place: Path) -> bool:
    """Whether nothing that answers need lies in a folder."""
    needed = (Path(sys.prefix), Path(sys.base_prefix), _LIBRARY / "tutorial_lib")
    needed = (*needed, Path(tempfile.gettempdir()))
    return not any(path.resolve().is_relative_to(place) for path in needed)


def marks_of(students: Sequence[Student], found: Workers) -> Iterator[tuple[Student, list[Mark]]]:
    """Every student with a mark for each exercise of the course, in order."""
    with ThreadPoolExecutor(found._idle.qsize()) as pool:
        waiting: list[tuple[Student, list[Future[Mark]]]] = [
            (one, [pool.submit(found.judge, name, one.texts.get(name)) for name in found.exercises])
            for one in students
        ]
        try:
            for student, futures in waiting:
                yield student, [future.result() for future in futures]
        except BaseException:  # or the pool would wait for what is under way
            pool.shutdown(wait=False, cancel_futures=True)
            found.stop()
            raise
