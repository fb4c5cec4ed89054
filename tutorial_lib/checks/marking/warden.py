"""Starts a process for each answer, and ends it with all that it has started.

On Linux a server forks them, which has everything imported that answers commonly use, and nothing
of the checks. Between it and the answer stands a warden, which lives as long as the answer does.
"""

import gc
import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from importlib import import_module
from multiprocessing.connection import Connection, Listener, Pipe, wait
from pathlib import Path
from typing import IO, Any

from tutorial_lib.checks.framework import guard
from tutorial_lib.checks.marking.answering import serve
from tutorial_lib.checks.marking.limits import Isolation, adopt, end_with_parent, limit_process

USUAL = (  # of other people
    *("numpy", "networkx", "scipy.spatial", "cv2", "numba", "torch", "matplotlib.pyplot"),
    *("joblib", "tqdm.auto", "torch._dynamo"),
)
LIBRARY = ("tutorial_lib.topology", "tutorial_lib.world", "tutorial_lib.learning.training_probe")
"""What answers import. An answer finds nothing of the library in its process that it, or an
argument of its function, has no need of: there are the right answers."""
LONGEST = 2 * guard.WAITING + 4.0
"""Seconds by the clock that an answer lives at most."""
_KEPT = 4 * guard.PRINTED  # bytes of what an answer prints

_GRACE = 0.3  # seconds
_FIRST_USER = 2_000_000_000
"""Under root each answer has a user of its own, whose number this is and that of a process."""

Report = dict[str, Any]
"""How an answer's process ended ("status", as `subprocess` has it; None where it was ended by its
check) and what it printed ("printed", bytes)."""
Start = Callable[[], AbstractContextManager[tuple[Connection, Report]]]
"""Starts a process: a context that gives the connection to it and a list for its report."""


def pipes(process: subprocess.Popen[bytes]) -> tuple[IO[bytes], IO[bytes]]:
    """The standard input and output of a process that was started with both."""
    if process.stdin is None or process.stdout is None:
        raise ValueError("start it with stdin=PIPE and stdout=PIPE")
    return process.stdin, process.stdout


def imported(names: Sequence[str]) -> None:
    """Import modules, so far as they are installed."""
    for name in names:
        with suppress(ImportError):
            import_module(name)


class Server:
    """A fork of this process that starts answers, one at each call, until it is closed.

    Attributes:
        missing: what it cannot keep answers from; empty if nothing.
    """

    def __init__(self, folder: Path, hidden: Sequence[Path]) -> None:
        """Of answers that may write into `folder`, and to which the folders `hidden` look empty."""
        self._requests, theirs = socket.socketpair()
        if os.fork() == 0:
            self._requests.close()
            try:
                _serve(theirs, folder, hidden)
            finally:
                os._exit(0)
        theirs.close()
        self.missing = self._requests.recv(4096).decode().strip()

    @contextmanager
    def __call__(self) -> Iterator[tuple[Connection, Report]]:
        """Start an answer; see `Start`."""
        connection, other = Pipe()
        control, far = Pipe()
        socket.send_fds(self._requests, [b"!"], [other.fileno(), far.fileno()])
        other.close()
        far.close()
        report: Report = {}
        try:
            yield connection, report
        finally:
            connection.close()
            with suppress(OSError, EOFError):
                control.send_bytes(b"end")
                status, printed = control.recv_bytes(), control.recv_bytes()
                report.update(status=int(status) if status else None, printed=printed)
            control.close()

    def close(self) -> None:
        """Start no more."""
        self._requests.close()


def _serve(requests: socket.socket, folder: Path, hidden: Sequence[Path]) -> None:
    """Start a warden for each request."""
    end_with_parent()
    os.setsid()
    gc.freeze()  # or collecting in an answer would copy all that it shares with this process
    isolation = Isolation(folder, hidden)
    requests.send(f"{isolation.missing}\n".encode())
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        message, handles, _, _ = socket.recv_fds(requests, 1, 2)
        if not message:
            return
        if os.fork() == 0:
            requests.close()
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            connection, control = handles
            _watch(connection, control, folder, isolation)
            os._exit(0)
        for handle in handles:
            os.close(handle)


def _watch(connection: int, control: int, folder: Path, isolation: Isolation) -> None:
    """Start an answer, end it and all that it started, and report on it."""
    adopt()
    isolation.separate()
    place = Path(tempfile.mkdtemp(dir=folder))
    place.chmod(0o777)
    output, written = os.pipe()
    number = os.getpid()
    answer = os.fork()
    if answer == 0:
        try:
            _become_answer(connection, written, place, isolation, number)
        finally:
            os._exit(1)
    os.close(connection)
    os.close(written)
    above = Connection(control)
    handle, printed = os.pidfd_open(answer), bytearray()
    by_itself = _until_end(above, handle, output, printed)
    status = _end_children(answer)
    _drain(output, printed)
    shutil.rmtree(place, ignore_errors=True)
    with suppress(OSError):
        above.send_bytes(str(os.waitstatus_to_exitcode(status)).encode() if by_itself else b"")
        above.send_bytes(bytes(printed))


def _become_answer(
    connection: int, output: int, place: Path, isolation: Isolation, number: int
) -> None:
    """Leave all that is not the answer's, and answer."""
    os.setsid()
    empty = os.open(os.devnull, os.O_RDONLY)
    for handle, target in ((empty, 0), (output, 1), (output, 2), (connection, 3)):
        os.dup2(handle, target)
    os.closerange(4, os.sysconf("SC_OPEN_MAX"))
    os.chdir(place)
    os.environ.update(HOME=str(place), TMPDIR=str(place), MPLCONFIGDIR=str(place))
    tempfile.tempdir = None
    isolation.close(_FIRST_USER + number)
    limit_process()
    sys.stdout = open(1, "w", buffering=1, errors="backslashreplace", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stdout
    serve(Connection(3))


def _until_end(above: Connection, answer: int, output: int, printed: bytearray) -> bool:
    """Keep what an answer prints until it ends or has to; whether it has ended by itself."""
    latest, open_ones = time.monotonic() + LONGEST, [above, answer, output]
    while (left := latest - time.monotonic()) > 0:
        ready = wait(open_ones, left)
        if answer in ready:
            return True
        if above in ready:  # the way to the check is closed, upon which answers end
            return bool(wait([answer], _GRACE))
        if output in ready and not _read(output, printed):
            open_ones.remove(output)
    return False


def _read(output: int, printed: bytearray) -> bool:
    """Keep the first of what was printed; whether there was any."""
    data = os.read(output, 1 << 16)
    printed += data[: _KEPT - len(printed)]
    return bool(data)


def _drain(output: int, printed: bytearray) -> None:
    """Keep what an ended answer has printed."""
    os.set_blocking(output, False)
    with suppress(BlockingIOError):
        while len(printed) < _KEPT and _read(output, printed):
            pass
    os.close(output)


def _end_children(answer: int) -> int:
    """Kill all children until none is left, those that were left behind too; one's status."""
    status = 0
    os.kill(answer, signal.SIGKILL)  # it is not waited for yet, so the number is still its own
    while True:
        for process in _children():
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        try:
            ended, code = os.waitpid(-1, 0)
        except ChildProcessError:
            return status
        status = code if ended == answer else status


def _children() -> list[int]:
    """The children of this process."""
    own = os.getpid()
    with suppress(OSError):  # not every kernel has the list
        return [int(n) for n in Path(f"/proc/{own}/task/{own}/children").read_text().split()]
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            parent = stat.read_text(errors="replace").rpartition(")")[2].split()[1]
            if int(parent) == own:
                found.append(int(stat.parent.name))
    return found


def spawning(folder: Path) -> tuple[Start, str]:
    """How to start answers where a process with libraries cannot be forked.

    They may write into `folder`. Returned, too, is what they are not kept from.
    """

    @contextmanager
    def start() -> Iterator[tuple[Connection, Report]]:
        key, report = secrets.token_bytes(16), {}
        place = Path(tempfile.mkdtemp(dir=folder))
        with Listener(authkey=key) as listener:
            process = subprocess.Popen(
                [sys.executable, "-m", "tutorial_lib.checks.marking.answering"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            words = f"{listener.address}\n{key.hex()}\n{place}\n".encode()
            given, said = pipes(process)
            given.write(words)
            given.close()
            connection = listener.accept()
        printed = bytearray()
        reader = threading.Thread(target=_keep, args=(said, printed), daemon=True)
        reader.start()
        try:
            yield connection, report
        finally:
            connection.close()
            status = process.poll()
            with suppress(OSError, AttributeError):  # Windows has no groups
                os.killpg(process.pid, signal.SIGKILL)
            process.kill()
            process.wait()
            reader.join(1.0)
            shutil.rmtree(place, ignore_errors=True)
            report.update(status=status, printed=bytes(printed))

    words = "this system gives answers no network and files of their own, and each starts anew"
    return start, f"{words}: they can reach both, and marking is slower"


def _keep(output: IO[bytes], printed: bytearray) -> None:
    """Keep the first of what a process prints, and read the rest."""
    while data := os.read(output.fileno(), 1 << 16):
        printed += data[: _KEPT - len(printed)]
