"""Work on many machines: `parallel.for_each` gives its pieces to workers of a Dask scheduler."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import joblib

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import library_hash

PATIENCE = 10.0
"""Seconds within which a scheduler and its first worker must answer."""


@contextmanager
def on_cluster(address: str) -> Iterator[None]:
    """Let the workers of a scheduler do what `for_each` gives out in this block.

    The rows are the same as on one machine: what is random depends on the piece of work alone. The
    pieces of a worker that dies go to others.

    Args:
        address: of the scheduler, as tcp://HOST:PORT; this machine does the work if it is empty.

    Raises:
        InputError: when Dask is not installed, nothing answers there, or a worker has another
            version of the library.
    """
    if not address:
        yield
        return
    try:
        from distributed import Client, KilledWorker
        from distributed.comm.addressing import parse_address, parse_host_port
    except ImportError as error:
        raise InputError("--scheduler: needs Dask; pip install 'dask[distributed]'") from error
    try:
        parse_host_port(parse_address(address)[1])  # a client that fails at this complains for 20 s
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no scheduler answers there ({error}); start one with: "
            "dask scheduler"
        ) from error
    with client:
        _check_workers(client, address)
        try:
            with joblib.parallel_config(backend="dask", client=client):
                yield
        except KilledWorker as error:
            raise InputError(
                f"--scheduler {address}: one piece of work ended several workers ({error}); give "
                "them more memory"
            ) from error


def _check_workers(client: Any, address: str) -> None:  # noqa: ANN401 - Dask's, where it is installed
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise InputError(
            f"--scheduler {address}: has no worker; start some with: "
            f"dask worker {address} --nworkers -1 --nthreads 1"
        ) from error
    workers = list(client.scheduler_info()["workers"])
    asked = [client.submit(library_hash, workers=[worker], pure=False) for worker in workers]
    for worker, found in zip(workers, client.gather(asked), strict=True):
        if found != library_hash():
            raise InputError(
                f"--scheduler {address}: the worker at {worker} has another version of the "
                "library; install this one there"
            )
