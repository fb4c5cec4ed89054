"""The same work on many worlds, on all cores; what is done survives when the rest is killed."""

from __future__ import annotations

import shutil
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from pickle import PicklingError
from typing import Any

import joblib
from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path, make_folder
from tutorial_lib.validation import instance, whole

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


def _kept(folder: Path, work: Callable[..., Any], item: object, *arguments: object) -> Any:  # noqa: ANN401
    """What `work(item, *arguments)` returns, from the folder if it was finished before."""
    try:
        path = folder / f"{joblib.hash((work, item, arguments))}.pkl"
    except PicklingError:  # of what has no name, as a lambda, nothing is kept
        return work(item, *arguments)
    if path.exists():
        return joblib.load(path)
    found = work(item, *arguments)
    folder.mkdir(parents=True, exist_ok=True)  # the same run may have ended beside this one
    with atomic_path(path) as temporary:
        joblib.dump(found, temporary)
    return found


def for_each(
    work: Callable[..., Any],
    items: Iterable[Any],
    *arguments: object,
    label: str,
    jobs: int = -1,
) -> list[Any]:
    """What `work(item, *arguments)` returns for each item, in their order.

    Workers share the cores: where as many processes run as there are cores, numpy and torch use one
    thread in each. `joblib.parallel_config` moves the work to another backend, such as Dask.

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
    if not isinstance(items, Iterable) or isinstance(items, str):
        raise InputError(f"items: {items!r}; give a list")
    instance("label", label, str)
    jobs, items = whole("jobs", jobs, least=-MOST_JOBS, most=MOST_JOBS), list(items)
    if not jobs:
        raise InputError("jobs: 0; give the number of processes, or -1 for as many as cores")
    folder = _folder.get()
    if folder is not None:
        work = partial(_kept, folder, work)
    run_all = Parallel(n_jobs=jobs, return_as="generator")
    with warnings.catch_warnings():
        # That is intended, and the piece of work that waits is given to the next worker. One that
        # is killed is no warning but an error.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        try:  # the first pieces start at once, so a worker may be lost before a result is asked for
            found = run_all(delayed(work)(item, *arguments) for item in items)
            return list(progress(found, len(items), label))
        except BrokenProcessPool as error:
            raise InputError(
                f"{label}: a worker process was ended from outside, most likely since memory ran "
                "out; close other programs, or let fewer work at once: LOKY_MAX_CPU_COUNT=1"
            ) from error


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
