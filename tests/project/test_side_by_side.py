"""How tests are run side by side, unless options differ."""

import os
from pathlib import Path
from types import SimpleNamespace

import pytest
import torch

from tests import conftest
from tutorial_lib.learning.threads import use_threads

PROJECT = Path(__file__).resolve().parents[2]
FOLDER, FILE = str(PROJECT / "tests"), f"{__file__}::test_the_files_named_exist"


@pytest.mark.parametrize(
    ("arguments", "given", "workers", "dist"),
    [
        ([FOLDER], {}, "auto", "loadfile"),
        ([FOLDER, FILE], {}, None, "no"),
        ([FOLDER], {"numprocesses": 0}, 0, "no"),
        ([FOLDER], {"numprocesses": 3}, 3, "loadfile"),
        ([FILE], {"numprocesses": 3, "dist": "load"}, 3, "load"),
        ([FOLDER], {"capture": "no"}, None, "no"),
        ([FOLDER], {"tx": ["popen"], "dist": "each"}, None, "each"),
    ],
)
def test_folders_are_run_side_by_side(arguments, given, workers, dist):
    usual = {"numprocesses": None, "maxprocesses": None, "maxworkerrestart": None}
    usual |= {"tx": [], "dist": "no", "capture": "fd"}
    config = SimpleNamespace(args=arguments, option=SimpleNamespace(**usual | given))
    conftest.pytest_cmdline_main(config)
    assert (config.option.numprocesses, config.option.dist) == (workers, dist)
    assert config.option.maxprocesses == (conftest.MOST_WORKERS if workers == "auto" else None)


def test_without_xdist_nothing_is_set():
    config = SimpleNamespace(args=[FOLDER], option=SimpleNamespace(capture="fd"))
    conftest.pytest_cmdline_main(config)
    assert vars(config.option) == {"capture": "fd"}


def test_a_worker_is_limited():
    if "PYTEST_XDIST_WORKER" not in os.environ:
        pytest.skip("this is no worker")
    assert all(os.environ.get(name) for name in conftest.LIMITS)
    use_threads(2)
    assert torch.get_num_threads() == 1


def test_the_files_named_exist():
    assert all((PROJECT / name).exists() for name in (*conftest.LONGEST, *conftest.ALONE))
