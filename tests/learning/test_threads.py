import os
import subprocess
import sys

import pytest

LOADED = "from tutorial_lib.learning import WaypointNetwork; WaypointNetwork('waypoint_k2')"
SHOWN = "import torch; print(torch.get_num_threads())"
OURS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS")


def threads(*statements, **environment):
    """What torch says in a process of its own after these statements."""
    clean = {name: value for name, value in os.environ.items() if name not in OURS}
    code = "\n".join((*statements, SHOWN))
    run = [sys.executable, "-c", code]
    found = subprocess.run(run, env=clean | environment, capture_output=True, text=True, check=True)
    return int(found.stdout)


def test_the_first_network_sets_one_thread():
    assert threads("import torch", LOADED) == 1


@pytest.mark.parametrize("name", OURS)
def test_the_environment_decides(name):
    assert threads(LOADED, **{name: "2"}) == 2


def test_a_number_set_before_stays_and_one_set_later_too():
    told = "import torch; torch.set_num_threads(3)"
    assert threads(told, LOADED) == 3
    assert threads("from tutorial_lib.learning import WaypointNetwork", told, LOADED) == 3
    usual = threads()
    if sys.platform == "linux" and os.uname().machine == "x86_64":  # where MKL knows
        assert threads(f"import torch; torch.set_num_threads({usual})", LOADED) == usual


def test_use_threads_stays_whatever_comes():
    told = "from tutorial_lib.learning import use_threads; use_threads(3)"
    assert threads(told, LOADED) == 3
