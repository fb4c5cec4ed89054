"""One case: a loader, a file of it that is altered, and what the loader does about it."""

import resource
import shutil
import signal
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tests.fuzz import changes, corpus
from tests.fuzz.outcome import (
    ALTERED,
    FOREIGN,
    GIGABYTE,
    HANG,
    LOADED,
    MEMORY,
    REFUSED,
    SECONDS,
    WAIT,
    WRONG,
    Outcome,
    Target,
)
from tests.fuzz.plain import same
from tests.fuzz.sources import agent_sources
from tutorial_lib.errors import MAX_MESSAGE, InputError

KNOWN = 5
"""Every fifth case puts in place of a file what did harm once."""
STRIDE = 7_919
"""From one of these to the next, a prime: all have their turn before any has a second one."""


class Hung(BaseException):
    """The time of a case is up."""


class Bench:
    """Loaders with the files that they read, each in a folder of its own."""

    def __init__(self, targets: list[Target], folder: Path) -> None:
        self.targets, self.folder = targets, folder / "case"
        self.files: dict[str, dict[str, bytes]] = {}
        self.wanted: dict[str, Any] = {}
        for target in targets:
            made = folder / target.name
            made.mkdir()
            target.make(made)
            self.files[target.name] = {f.name: f.read_bytes() for f in sorted(made.iterdir())}
            self.wanted[target.name] = target.load(made)
        self.known = self._known_cases()

    def _known_cases(self) -> list[tuple[Target, str, Any]]:
        """What did harm once: loaders, the file's name, and what is put in its place."""
        found: list[tuple[Target, str, Any]] = []
        for suffix, items in corpus.BY_SUFFIX.items():
            places = [
                (target, name)
                for target in self.targets
                for name in self.files[target.name]
                if name.endswith(suffix)
            ]
            found += [(*place, item) for place in places for item in items]
        own = [target for target in self.targets if target.name == "agent"]
        sources = [source.encode("utf-8", "surrogatepass") for source in agent_sources()]
        return found + [(target, "agent.py", source) for target in own for source in sources]

    def fresh(self, target: Target) -> list[Path]:
        """The files of a loader as they were saved."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir()
        for name, data in self.files[target.name].items():
            (self.folder / name).write_bytes(data)
        return sorted(self.folder.iterdir())

    def random_case(self, seed: int, number: int) -> Outcome:
        """A case by its number: every loader in turn, its files altered at random."""
        rng = np.random.default_rng([seed, number])
        target = self.targets[number % len(self.targets)]
        paths = self.fresh(target)
        path = paths[int(rng.integers(len(paths)))]
        if number < len(self.targets):
            return self.run(target, "nothing", sealed=True)
        if number % KNOWN == 0 and self.known:
            return self.known_case(seed + number // KNOWN * STRIDE)
        change, kind = changes.alter(path, rng)
        if target.name == "agent" and change != "special":
            self.fresh(target)  # nobody knows what altered code does
        return self.run(target, f"{change} in {path.suffix}", self._is_sealed(target, path, kind))

    def known_case(self, number: int) -> Outcome:
        """A case of what did harm once."""
        target, name, item = self.known[number % len(self.known)]
        data = item() if callable(item) else item
        self.fresh(target)
        (self.folder / name).write_bytes(data)
        return self.run(target, f"{name} of {data[-40:]!r}", sealed=False)

    def made_up_case(self, target: Target, file: int, seed: int, value: Any) -> Outcome:
        """A case with a value from elsewhere: bytes, an array, or anything that JSON can hold."""
        rng = np.random.default_rng(seed)
        paths = self.fresh(target)
        path, kind = paths[file % len(paths)], changes.BYTES
        if isinstance(value, bytes):
            data = path.read_bytes()
            at = int(rng.integers(len(data)))
            path.write_bytes(data[:at] + value + data[at + len(value) :])
        elif isinstance(value, np.ndarray) and path.suffix == ".npz":
            kind = changes.alter_arrays(path, rng, value)
        elif path.suffix in (".json", ".ipynb") and not isinstance(value, np.ndarray):
            kind = changes.alter_json(path, rng, value)
        change = f"made up {type(value).__name__} in {path.suffix}"
        return self.run(target, change, self._is_sealed(target, path, kind))

    def _is_sealed(self, target: Target, path: Path, kind: str) -> bool:
        return kind == changes.BYTES and path.name.endswith(target.sealed)

    def run(self, target: Target, change: str, sealed: bool) -> Outcome:
        """Load the files as they now are."""
        verdict, words, began = LOADED, "", time.process_time()
        with _measured() as growth, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                with _limited():
                    value = target.load(self.folder)
                if value is None:
                    verdict = REFUSED
                elif not same(value, self.wanted[target.name]):
                    verdict = WRONG if sealed else ALTERED
            except Hung:
                verdict = HANG
            except BaseException as error:
                verdict, words = _judged(error)
        seconds, megabytes = time.process_time() - began, growth[0] / 1e6
        if seconds > SECONDS:
            verdict = HANG
        elif growth[0] > GIGABYTE:
            verdict = MEMORY
        return Outcome(target.name, change, verdict, words, seconds, megabytes)


def _judged(error: BaseException) -> tuple[str, str]:
    """Whether an error is as it should be, and its words."""
    message = str(error)
    words = f"{type(error).__name__}: {message[:300]}"
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, MemoryError):
            return MEMORY, words
        cause = cause.__cause__ or cause.__context__
    good = type(error) is InputError and message.isprintable() and 0 < len(message) <= MAX_MESSAGE
    return (REFUSED if good else FOREIGN), words


@contextmanager
def _limited() -> Iterator[None]:
    """Stop what takes too long, if it is Python that does."""
    began = time.process_time()

    def stop(*_: object) -> None:
        raise Hung

    def stop_waiting(*_: object) -> None:
        if time.process_time() - began < 0.1:
            raise Hung
        signal.setitimer(signal.ITIMER_REAL, WAIT)  # it computes, on a busy machine

    signal.signal(signal.SIGPROF, stop)
    signal.signal(signal.SIGALRM, stop_waiting)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    signal.setitimer(signal.ITIMER_REAL, WAIT)
    try:
        yield
    finally:
        for timer in (signal.ITIMER_PROF, signal.ITIMER_REAL):
            signal.setitimer(timer, 0.0)


@contextmanager
def _measured() -> Iterator[list[float]]:
    """Bytes by which the process grows meanwhile, at most; filled in at the end."""
    growth = [0.0]
    before = _resident("VmRSS")
    _forget_peak()
    yield growth
    growth[0] = max(_resident("VmHWM") - before, 0)


def _forget_peak() -> None:
    """Have the system measure the peak of memory from now on."""
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:  # then the peak is that of all cases so far
        return


def _resident(name: str) -> int:
    """Bytes that the system says of this process."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(name):
            return int(line.split()[1]) * 1024
    return 0


def limit_memory() -> None:
    """Let this process grow by a gigabyte, and no more."""
    most = _resident("VmSize") + GIGABYTE
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
