import os
import subprocess
import sys

import pytest

LOADED = "from tutorial_lib.learning import WaypointNetwork; WaypointNetwork('waypoint_k2')"
SHOWN = "import torch; print(torch.get_num_threads(), flush=True)"
OURS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS")
EACH = """
import os, sys
import cv2, networkx, numba, scipy.spatial, torch  # what takes long, once for all
for code in sys.argv[1:]:
    child = os.fork()
    if not child:
        exec(code)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
"""


def run(*arguments, **environment):
    """The numbers that a process of its own prints."""
    clean = {name: value for name, value in os.environ.items() if name not in OURS}
    call = [sys.executable, "-c", *arguments]
    found = subprocess.run(
        call, env=clean | environment, capture_output=True, text=True, check=True
    )
    return [int(number) for number in found.stdout.split()]


@pytest.mark.full
def test_the_environment_decides():
    assert run(f"{LOADED}; {SHOWN}", OMP_NUM_THREADS="2") == [2]


@pytest.mark.full
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a process of its own for each takes long")
def test_the_first_network_sets_one_thread_unless_a_number_is_set_before_or_later():
    imported = "from tutorial_lib.learning import WaypointNetwork, use_threads"
    usual = "torch.get_num_threads()"
    expected = {
        "pass": usual,
        f"os.environ['MKL_NUM_THREADS'] = '2'; {LOADED}": usual,
        LOADED: 1,
        f"torch.set_num_threads(3); {LOADED}": 3,
        f"{imported}; torch.set_num_threads(3); {LOADED}": 3,
        f"{imported}; use_threads(3); {LOADED}": 3,
    }
    if sys.platform == "linux" and os.uname().machine == "x86_64":  # where MKL knows
        expected[f"torch.set_num_threads({usual}); {LOADED}"] = usual
    found = run(EACH, *(f"{code}; {SHOWN}" for code in expected))
    wanted = [found[0] if number == usual else number for number in expected.values()]
    assert dict(zip(expected, found, strict=True)) == dict(zip(expected, wanted, strict=True))
