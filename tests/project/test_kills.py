"""A job may be killed at any moment: what was whole stays so, and the next run ends well."""

import os
import random
import shutil
import sys
import time

import pytest

from tests.jobs import check_whole, forks, killed, started, temporaries

KILLS = {"save": 35, "demo": 25, "build": 15, "experiment": 10, "train": 15}
"""A hundred."""
PATIENCE = 900.0
pytestmark = [
    pytest.mark.full,
    pytest.mark.skipif(sys.platform == "win32", reason="nothing is forked there"),
]


def finished(context, name, folder):
    """Let a job end; the seconds that it took."""
    begun = time.monotonic()
    process = started(context, name, folder)
    process.join(PATIENCE)
    assert process.exitcode == 0
    return time.monotonic() - begun


@pytest.mark.parametrize("name", KILLS)
def test_a_killed_job_loses_nothing_and_is_done_by_the_next_run(name, tmp_path):
    context, rng = forks(), random.Random(name)
    finished(context, name, tmp_path)
    seconds = finished(context, name, tmp_path)
    whole, before = check_whole(tmp_path), contents(tmp_path)
    kills = runs = left = 0
    while kills < KILLS[name]:
        if name == "train" and runs % 3 == 0:
            shutil.rmtree(tmp_path / "work", ignore_errors=True)  # it records again, too
        process = started(context, name, tmp_path)
        kills += killed(process, rng.uniform(0.0, seconds))  # unless it was faster
        runs += 1
        left = max(left, len(temporaries(tmp_path)))
        kept = check_whole(tmp_path)
        assert {file for file in whole if not file.startswith("work/")} <= set(kept)
    aged(tmp_path)
    finished(context, name, tmp_path)
    assert temporaries(tmp_path) == []
    assert set(whole) <= set(check_whole(tmp_path))
    same = [file for file, data in contents(tmp_path).items() if before.get(file) == data]
    print(
        f"{name}: {kills} kills in {runs} runs of {seconds:.1f} s, {left} temporary files at most"
    )
    if name in ("train", "save"):
        assert {"weights/tiny.safetensors", "flat.npz"} & set(same)


def contents(folder):
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


def aged(folder):
    """Two days pass for the temporary files."""
    then = time.time() - 2 * 24 * 3600
    for path in temporaries(folder):
        os.utime(path, (then, then))


@pytest.mark.parametrize("name", ["demo", "train"])
def test_two_at_a_time_in_one_folder_leave_whole_files(name, tmp_path):
    context = forks()
    both = [started(context, name, tmp_path) for _ in range(2)]
    for process in both:
        process.join(PATIENCE)
    assert [process.exitcode for process in both] == [0, 0]
    assert check_whole(tmp_path)
    assert temporaries(tmp_path) == []
