"""The same work on many worlds, on all cores."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from typing import Any

from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, whole

MOST_JOBS = 1_024
"""Processes; more are a mistake."""


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
    """
    if not callable(work):
        raise InputError(f"work: {work!r}; give a function of a module")
    if not isinstance(items, Iterable) or isinstance(items, str):
        raise InputError(f"items: {items!r}; give a list")
    instance("label", label, str)
    jobs, items = whole("jobs", jobs, least=-MOST_JOBS, most=MOST_JOBS), list(items)
    if not jobs:
        raise InputError("jobs: 0; give the number of processes, or -1 for as many as cores")
    run_all = Parallel(n_jobs=jobs, return_as="generator")
    with warnings.catch_warnings():
        # That is intended, and the piece of work that waits is given to the next worker. One that
        # is killed is no warning but an error.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        found = run_all(delayed(work)(item, *arguments) for item in items)
        return list(tqdm(found, total=len(items), desc=label, disable=None))
