"""The same work on many worlds, on all cores; what is done survives when the rest is killed."""

import shutil
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from pickle import PicklingError
from typing import Any

import joblib
from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path, make_folder
from tutorial_lib.validation import instance, listed, whole

LINE_INTERVAL = 10.0
"""Seconds from one line of progress in a log file to the next, at least."""
MOST_JOBS = 1_024
"""Processes; more are a mistake."""
_folder: ContextVar[Path | None] = ContextVar("folder", default=None)
"""Where finished pieces of work are kept, see `resumable`."""


@contextmanager
def resumable(folder: Path) -> Iterator[None]:
    """Keep each finished piece of work of `for_each` in a folder until all of it is done.

    Where the block was killed or failed, the same block finds again what was finished. The folder's
    name must tell what the pieces depend on besides their items and arguments. Where it cannot be
    made, nothing is kept.
    """
    try:
        make_folder(folder)
    except OSError:
        yield
        return
    token = _folder.set(folder)
    try:
        yield
    finally:
        _folder.reset(token)
    shutil.rmtree(folder, ignore_errors=True)


def _kept_at(
    folder: Path, work: Callable[..., Any], item: object, arguments: tuple[object, ...]
) -> Path | None:
    """Where the result of `work(item, *arguments)` is kept; nowhere if something has no name."""
    try:
        return folder / f"{joblib.hash((work, item, arguments))}.pkl"
    except PicklingError:  # as of a lambda
        return None


def _keep(path: Path, result: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)  # the same run may have ended beside this one
    with atomic_path(path) as temporary:
        joblib.dump(result, temporary)


def _numbered(
    number: int, work: Callable[..., Any], item: object, *arguments: object
) -> tuple[int, Any]:
    return number, work(item, *arguments)


def for_each(
    work: Callable[..., Any],
    items: Iterable[Any],
    *arguments: object,
    label: str,
    jobs: int = -1,
) -> list[Any]:
    """What `work(item, *arguments)` returns for each item, in their order.

    Workers share the cores: where as many processes run as there are cores, numpy and torch use one
    thread in each. `joblib.parallel_config` moves the work to another backend, as
    `experiments.common.cluster` does to Dask's.

    A worker whose memory has grown by 300 MB is replaced between two pieces of work, where psutil
    is there to measure it: an experiment in large worlds takes no more memory the longer it runs.

    Args:
        work: a function of a module; its arguments and results can be pickled.
        items: worlds, files, or tuples of what one piece of work needs.
        arguments: the same for all.
        label: of the progress bar.
        jobs: processes; -1 for as many as there are cores.

    Raises:
        InputError: when the system ends a worker, as it does where memory runs out.
    """
    if not callable(work):
        raise InputError(f"work: {work!r}; give a function of a module")
    instance("label", label, str)
    jobs = whole("jobs", jobs, least=-MOST_JOBS, most=MOST_JOBS)
    items = listed("items", items, "a list")
    if not jobs:
        raise InputError("jobs: 0; give the number of processes, or -1 for as many as cores")
    folder = _folder.get()
    paths = [folder and _kept_at(folder, work, item, arguments) for item in items]
    found = {i: joblib.load(path) for i, path in enumerate(paths) if path and path.exists()}
    pieces = [
        delayed(_numbered)(number, work, item, *arguments)
        for number, item in enumerate(items)
        if number not in found
    ]
    if found:
        print(f"{label}: {len(found)} of {len(items)} were finished before", file=sys.stderr)
    run_all = Parallel(n_jobs=jobs, return_as="generator_unordered")
    with warnings.catch_warnings():
        # That is intended, and the piece of work that waits is given to the next worker. One that
        # is killed is no warning but an error.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        try:  # the first pieces start at once, so a worker may be lost before a result is asked for
            for number, result in progress(run_all(pieces), len(pieces), label):
                found[number] = result
                if path := paths[number]:
                    _keep(path, result)
        except BrokenProcessPool as error:
            raise InputError(
                f"{label}: a worker process was ended from outside, most likely since memory ran "
                "out; close other programs, or let fewer work at once: LOKY_MAX_CPU_COUNT=1"
            ) from error
    return [found[number] for number in range(len(items))]


def progress(found: Iterable[Any], total: int, label: str) -> Iterable[Any]:
    """Pass results on as they come, and show on stderr how many there are.

    On a terminal that is a bar; in a log file it is a line now and then.
    """
    if sys.stderr.isatty():
        return tqdm(found, total=total, desc=label)
    return lines_of_progress(found, total, label)


def lines_of_progress(found: Iterable[Any], total: int, label: str) -> Iterator[Any]:
    """The same as lines, at least `LINE_INTERVAL` apart; none if all is done sooner."""
    begun = said = time.monotonic()
    for count, one in enumerate(found, 1):
        now = time.monotonic()
        if now - said >= LINE_INTERVAL and count < total:
            said = now
            print(f"{label}: {count} of {total}, {now - begun:.0f} s", file=sys.stderr, flush=True)
        yield one
