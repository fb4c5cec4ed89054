"""The process that loads: one for all cases, replaced when one does not come back."""

import multiprocessing
import tempfile
import time
from collections.abc import Iterator
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import psutil

from tests.fuzz.outcome import FOREIGN, HANG, SECONDS, WAIT, Outcome

PATIENCE = 3 * SECONDS, 10 * WAIT
"""Seconds of computing, and on the clock, after which a worker that says nothing is ended: compiled
code cannot be interrupted."""
MADE_UP = 0.2
"""Share of the cases that hypothesis makes up."""


def outcomes(
    seed: int, cases: int, only: str = "", known: str = "tests.fuzz.targets"
) -> Iterator[Outcome]:
    """Run cases, and say what came of each.

    Args:
        seed: of all of them.
        cases: how many.
        only: loaders whose name has this in it.
        known: the module whose `targets()` they are.
    """
    made_up, done = round(MADE_UP * cases), 0
    while done < cases:
        for outcome in _of_worker(seed, range(done, cases - made_up), made_up, only, known):
            done += 1
            yield outcome
        if done >= cases - made_up:  # hypothesis cannot go on in the middle
            return


def _of_worker(*arguments: Any) -> Iterator[Outcome]:
    """What a worker says, and at last what became of it if it did not come to its end."""
    context = multiprocessing.get_context("spawn")
    mine, theirs = context.Pipe(duplex=False)
    worker = context.Process(target=_work, args=(theirs, *arguments), daemon=True)
    worker.start()
    theirs.close()
    try:
        _wait_until_ready(mine)
        while _says_something(mine, worker.pid):
            said = mine.recv()
            if said is None:
                return
            yield said
        yield Outcome("?", "?", HANG, "the worker said nothing")
    except EOFError:
        worker.join()
        yield Outcome("?", "?", FOREIGN, f"the worker ended with {worker.exitcode}")
    finally:
        worker.kill()
        worker.join()


def _wait_until_ready(pipe: Connection) -> None:
    """Wait for the first word of a worker.

    Raises:
        RuntimeError: when it ends before: so would every other, case after case.
    """
    try:
        pipe.recv()
    except EOFError:
        raise RuntimeError("no worker came to its first case: see its error above") from None


def _says_something(pipe: Connection, worker: int) -> bool:
    """Whether a worker says something before the patience with it ends."""
    began, spent = time.monotonic(), _computed(worker)
    while not pipe.poll(1.0):
        late = _computed(worker) - spent > PATIENCE[0] or time.monotonic() - began > PATIENCE[1]
        if late:
            return False
    return True


def _computed(process: int) -> float:
    """Seconds that a process has computed; 0 if it has ended."""
    try:
        return sum(psutil.Process(process).cpu_times()[:2])
    except psutil.NoSuchProcess:
        return 0.0


def _work(
    pipe: Connection,
    seed: int,
    numbers: range,
    made_up: int,
    only: str,
    known: str,
) -> None:
    """Run cases by their numbers, and some that hypothesis makes up."""
    # Here, so that only this process takes the time to import the library.
    from tests.fuzz.cases import Bench, limit_memory

    with tempfile.TemporaryDirectory() as folder:
        chosen = [one for one in import_module(known).targets() if only in one.name]
        bench = Bench(chosen, Path(folder))
        limit_memory()
        pipe.send("ready")
        for number in numbers:
            pipe.send(bench.random_case(seed, number))
        if made_up:
            _make_up(pipe, bench, seed, made_up)
        pipe.send(None)


def _make_up(pipe: Connection, bench: Any, seed: int, count: int) -> None:
    """Cases of values that hypothesis makes up."""
    import hypothesis
    from hypothesis import strategies as st
    from hypothesis.extra import numpy as arrays

    scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9)
    json = st.recursive(
        scalars,
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
        max_leaves=6,
    )
    kinds = arrays.scalar_dtypes() | arrays.unicode_string_dtypes(max_len=5)
    some = arrays.arrays(kinds, arrays.array_shapes(min_dims=0, min_side=0, max_side=4))

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[hypothesis.Phase.generate],
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(
        st.sampled_from([target for target in bench.targets if target.name != "agent"]),
        st.integers(0, 3),
        st.integers(0, 2**32),
        json | some | st.binary(max_size=12),
    )
    def load(target: Any, file: int, place: int, value: Any) -> None:
        pipe.send(bench.made_up_case(target, file, place, value))

    load()
