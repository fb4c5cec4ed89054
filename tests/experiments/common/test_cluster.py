"""A real scheduler and two workers on this machine: the same rows, and a killed worker survived."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import joblib
import pytest

from tutorial_lib.cli import main
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.cluster import on_cluster
from tutorial_lib.parallel import for_each

pytest.importorskip("distributed")


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def dask(*arguments):
    """A process of Dask's, without its dashboard."""
    quiet = {**os.environ, "OMP_NUM_THREADS": "1", "DASK_DISTRIBUTED__WORKER__DAEMON": "false"}
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        env=quiet,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """The address of a scheduler, and its two workers."""
    port, folder = free_port(), tmp_path_factory.mktemp("dask")
    address = f"tcp://127.0.0.1:{port}"
    one = ("--no-dashboard", "--host", "127.0.0.1")
    started = [dask("scheduler", *one, "--port", str(port))]
    started += [
        dask("worker", address, *one, "--nthreads", "1", "--no-nanny", "--local-directory", folder)
        for _ in range(2)
    ]
    yield address, started[1:]
    for process in started:
        process.kill()
        process.wait()


def slow_square(number, offset):
    time.sleep(0.3)
    return number * number + offset


@pytest.mark.parametrize("bad", ["tcp://127.0.0.1:1", "nowhere:at:all", "foo"])
def test_where_no_scheduler_answers_it_is_said(bad, monkeypatch):
    monkeypatch.setattr("tutorial_lib.experiments.common.cluster.PATIENCE", 0.5)
    words = f"--scheduler {bad}: no scheduler answers there"
    with pytest.raises(InputError, match=words), on_cluster(bad):
        pass


def test_without_an_address_the_work_is_done_here():
    with on_cluster(""):
        assert for_each(slow_square, range(2), 1, label="squares", jobs=1) == [1, 2]


@pytest.mark.full
def test_an_experiment_has_the_same_rows_there(cluster, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("tutorial_lib.commands.experiment.made_from", lambda *_: {})
    command = ["experiment", "plans", "--family", "hall", "--quick", "--worlds", "10500:10502"]
    here, there = tmp_path / "here.json", tmp_path / "there.json"
    assert main([*command, "--json", str(there), "--scheduler", cluster[0]]) == 0
    with joblib.parallel_config(backend="sequential"):
        assert main([*command, "--json", str(here)]) == 0
    rows = [json.loads(path.read_text())["rows"] for path in (here, there)]
    assert rows[0] == rows[1]
    assert rows[0][0]["plans"] == 2


@pytest.mark.full
def test_a_worker_that_is_killed_loses_nothing(cluster):
    address, workers = cluster
    killer = threading.Timer(0.6, lambda: os.kill(workers[0].pid, signal.SIGKILL))
    with on_cluster(address):
        killer.start()
        found = for_each(slow_square, range(12), 1, label="squares")
    assert found == [number * number + 1 for number in range(12)]
    workers[0].wait(timeout=10)
