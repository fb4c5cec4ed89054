"""Work on many items: in order, and by workers that may be replaced while it lasts."""

import subprocess
import sys
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from tutorial_lib import parallel
from tutorial_lib.errors import InputError
from tutorial_lib.parallel import for_each


def square(number, offset):
    return number * number + offset


def test_results_come_in_the_order_of_the_items():
    assert for_each(square, iter(range(7)), 1, label="squares", jobs=2) == [
        square(number, 1) for number in range(7)
    ]


def grow(number, megabytes, kept=[]):  # noqa: B006 - it is to grow
    """Keep memory, and say in which process."""
    import os
    import time

    kept.append(bytearray(b"x" * (megabytes * 1_000_000)))
    time.sleep(1.2)  # loky measures once a second
    return number, os.getpid()


MANY = """
from tests.test_parallel import grow
from tutorial_lib import parallel
from tutorial_lib.parallel import for_each
found = for_each(grow, range(6), 400, label="worlds", jobs=2)
assert [number for number, _ in found] == list(range(6))
print(len({process for _, process in found}))
"""


@pytest.mark.full
def test_workers_that_have_grown_are_replaced_without_a_word():
    pytest.importorskip("psutil")
    done = subprocess.run(
        [sys.executable, "-W", "always", "-c", MANY],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        timeout=180,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 2  # so it did happen
    assert "worker stopped" not in done.stderr


def fail(number):
    """The process ends, as one that the system killed."""
    import os

    os._exit(number)


@pytest.mark.full
def test_a_worker_that_dies_is_an_error():
    with pytest.raises(
        InputError, match=r"^worlds: a worker process was ended from outside.*; close"
    ):
        for_each(fail, range(4), label="worlds", jobs=2)


def test_a_worker_that_dies_before_all_is_handed_out_is_an_error(monkeypatch):
    class Broken:
        def __init__(self, **options):
            pass

        def __call__(self, pieces):
            raise BrokenProcessPool

    monkeypatch.setattr(parallel, "Parallel", Broken)
    with pytest.raises(InputError, match="worlds: a worker process was ended from outside"):
        for_each(square, range(4), 1, label="worlds", jobs=2)


class Clock:
    """A monotonic clock that goes on by four seconds at every look."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        self.now += 4.0
        return self.now


def test_in_a_log_file_progress_is_a_line_now_and_then(monkeypatch, capsys):
    monkeypatch.setattr(parallel, "time", Clock())
    passed = parallel.progress(iter("abcdefgh"), 8, "worlds")
    assert next(iter(passed)) == "a"
    assert "".join(passed) == "bcdefgh"
    lines = capsys.readouterr().err.splitlines()
    assert lines == ["worlds: 3 of 8, 12 s", "worlds: 6 of 8, 24 s"]  # and none at the end


def test_short_work_says_nothing_in_a_log_file(capsys):
    assert for_each(square, range(3), 1, label="squares", jobs=1) == [1, 2, 5]
    assert capsys.readouterr().err == ""


def test_on_a_terminal_progress_is_a_bar(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert list(parallel.progress(range(3), 3, "worlds")) == [0, 1, 2]
    assert "worlds: 100%" in capsys.readouterr().err


def noted(number, folder):
    """Say that it was done, and fail at 3 as long as there is a stone in the way."""
    with (folder / "done").open("a") as done:
        done.write(f"{number} ")
    if number == 3 and (folder / "stone").exists():
        raise RuntimeError("stone")
    return number * number


def test_what_was_finished_before_a_failure_is_not_done_again(tmp_path):
    (tmp_path / "stone").touch()
    kept = tmp_path / "kept"

    def attempt():
        with parallel.resumable(kept):
            return for_each(noted, range(5), tmp_path, label="squares", jobs=1)

    with pytest.raises(RuntimeError, match="stone"):
        attempt()
    before = len(list(kept.glob("*.pkl")))
    assert before == 3
    (tmp_path / "stone").unlink()
    (tmp_path / "done").unlink()
    assert attempt() == [0, 1, 4, 9, 16]
    assert (tmp_path / "done").read_text() == "3 4 "
    assert not kept.exists()
    (tmp_path / "done").unlink()
    assert attempt() == [0, 1, 4, 9, 16]
    assert (tmp_path / "done").read_text() == "0 1 2 3 4 "


def test_other_arguments_are_other_work(tmp_path):
    kept = tmp_path / "kept"
    with parallel.resumable(kept):
        one = for_each(square, range(3), 1, label="squares", jobs=1)
        other = for_each(square, range(3), 2, label="squares", jobs=1)
        assert (one, other) == ([1, 2, 5], [2, 3, 6])
        assert len(list(kept.glob("*.pkl"))) == 6


def test_where_nothing_can_be_kept_the_work_is_done_all_the_same(tmp_path):
    (tmp_path / "file").touch()
    with parallel.resumable(tmp_path / "file" / "kept"):
        assert for_each(square, range(3), 1, label="squares", jobs=1) == [1, 2, 5]
