"""Limits while a student's function is judged: time, memory and output."""

import ctypes
import io
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from types import FrameType
from typing import Any, TextIO

with suppress(ImportError):
    import resource  # not on Windows

SECONDS = 6.0
"""Of the processor's time that a check may take; every check needs about one."""
WAITING = 9.0
"""Seconds by the clock, for a function that sleeps and takes none of the processor's time."""
RESTING = 0.1
"""Share of the processor's time below which it sleeps; on a crowded machine it gets more."""
MEMORY = 1.5e9
"""Bytes that a check may take."""
WAITED_FOR = ("llvmlite", "matplotlib", "numba")
"""Packages that no error may interrupt; the next ring, `_AGAIN` later, finds them done."""
PRINTED = 5_000
"""Characters that are shown of what a function prints."""
_AGAIN = 0.2  # seconds until a function that caught the error gets the next one

Function = Callable[..., Any]


class TimeUp(BaseException):
    """The time is up. No `Exception`, so that a student's ``except Exception`` lets it pass."""

    def __str__(self) -> str:
        return f"not done after {SECONDS:g} seconds; does a loop never end?"


def limited(judge: Callable[[Any], Any], student: Any) -> Any:  # noqa: ANN401
    """What a judge says of a student's function, or file, within `SECONDS`, `WAITING` and `MEMORY`.

    Long output is cut. On Linux the memory is limited, elsewhere only the time.

    Raises:
        TimeUp: when the time is up.
        MemoryError: when the memory is used up.
    """
    main = threading.current_thread() is threading.main_thread()
    clock = _alarm(student) if main and hasattr(signal, "setitimer") else _watchdog()
    with _output(), _memory(), clock, warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # numpy's, of a wrong answer's numbers
        return judge(student)


@contextmanager
def _alarm(student: Any) -> Iterator[None]:  # noqa: ANN401
    """A signal reaches functions that wait, too, as in ``time.sleep``."""
    called = student if hasattr(student, "__code__") else vars(type(student)).get("__call__")
    code = getattr(called, "__code__", None)
    file = str(student) if isinstance(student, Path) else getattr(code, "co_filename", None)
    rung, rests = False, _rests()

    def ring(number: int, frame: FrameType | None) -> None:
        nonlocal rung
        if _waits(frame) or (number == signal.SIGALRM and not (rung or rests())):
            return
        if rung:  # the function caught the first error: now its next line raises one
            own = [f for f in _under_way(frame) if f.f_code.co_filename == file]
            if not own:  # it did not: the first one is on its way
                return
            sys.settrace(lambda *_: None)
            for caught in own:
                caught.f_trace = raise_it
        rung = True
        raise TimeUp

    def raise_it(frame: FrameType, event: str, argument: object) -> Callable[..., Any]:
        if event == "line":  # the first one is that of the handler, whose own errors pass
            raise TimeUp
        return raise_it

    timers = (
        (signal.ITIMER_PROF, signal.SIGPROF, SECONDS),
        (signal.ITIMER_REAL, signal.SIGALRM, WAITING),
    )
    tracing, before = sys.gettrace(), [signal.signal(number, ring) for _, number, _ in timers]
    for timer, _, seconds in timers:
        signal.setitimer(timer, seconds, _AGAIN)
    try:
        yield
    finally:
        for timer, _, _ in timers:
            signal.setitimer(timer, 0)
        for (_, number, _), handler in zip(timers, before, strict=True):
            signal.signal(number, handler)
        sys.settrace(tracing)


def _rests() -> Callable[[], bool]:
    """A function that says whether the process has rested since it was asked, a second ago or more.

    A check on a crowded machine takes long by the clock as well, and is not to be ended for that.
    """
    clock, used = time.monotonic(), time.process_time()

    def rests() -> bool:
        nonlocal clock, used
        now, spent = time.monotonic(), time.process_time()
        if now - clock < min(1.0, WAITING):
            return False
        resting = spent - used < RESTING * (now - clock)
        clock, used = now, spent
        return resting

    return rests


def _waits(frame: FrameType | None) -> bool:
    """Whether a kernel is compiled, or a package imported, that would be broken if it stopped now.

    Half a kernel ends Python, and with half of matplotlib no later check has a picture.
    """
    names = (f.f_globals.get("__name__", "") for f in _under_way(frame))
    return any(name.partition(".")[0] in WAITED_FOR for name in names)


def _under_way(frame: FrameType | None) -> Iterator[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back


@contextmanager
def _watchdog() -> Iterator[None]:
    """Where there is no such signal (Windows, other threads), a thread raises the error here."""
    here, done = ctypes.c_ulong(threading.get_ident()), threading.Event()
    error = ctypes.py_object(TimeUp)

    def watch() -> None:
        begun, rests, wait, over = time.process_time(), _rests(), WAITING, False
        while not done.wait(wait):
            over = over or time.process_time() - begun > SECONDS or rests()
            if over:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(here, error)
            wait = _AGAIN

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        done.set()


@contextmanager
def _memory() -> Iterator[None]:
    """A loop that fills the memory gets an error before the machine suffers."""
    before = limit_memory()
    try:
        yield
    finally:
        if before is not None:
            resource.setrlimit(resource.RLIMIT_AS, before)


def limit_memory() -> tuple[int, int] | None:
    """Limit the memory of this process; the limits before, or None where that is impossible."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        before = resource.getrlimit(resource.RLIMIT_AS)
        limit = int(pages * resource.getpagesize() + MEMORY)
        resource.setrlimit(resource.RLIMIT_AS, (limit, before[1]))
    except (NameError, OSError, ValueError):
        return None
    return before


class _Short(io.TextIOBase):
    """Passes on what is printed, up to a number of characters."""

    def __init__(self, shown: TextIO) -> None:
        self.shown, self.left = shown, PRINTED

    def write(self, text: str) -> int:
        if self.left > 0:
            self.shown.write(text[: self.left])
            self.left -= len(text)
            if self.left <= 0:
                self.shown.write(f"\n... only the first {PRINTED:,} characters are shown\n")
        return len(text)

    def flush(self) -> None:
        self.shown.flush()


@contextmanager
def _output() -> Iterator[None]:
    with redirect_stdout(_Short(sys.stdout)), redirect_stderr(_Short(sys.stderr)):
        yield
