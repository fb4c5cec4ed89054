"""The same work on many worlds, on all cores."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.errors import InputError


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
    items = list(items)
    run_all = Parallel(n_jobs=jobs, return_as="generator")
    with warnings.catch_warnings():
        # That is intended, and the piece of work that waits is given to the next worker. One that
        # is killed is no warning but an error.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        found = run_all(delayed(work)(item, *arguments) for item in items)
        try:
            return list(tqdm(found, total=len(items), desc=label, disable=None))
        except BrokenProcessPool as error:
            raise InputError(
                f"{label}: a worker process was ended from outside, most likely since memory ran "
                "out; close other programs, or let fewer work at once: LOKY_MAX_CPU_COUNT=1"
            ) from error
