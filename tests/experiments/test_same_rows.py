"""An experiment has the same rows each time, whatever number of processes it is given."""

import json
import os
import subprocess
import sys

import pytest

CHEAP = (
    ("plans", "--family", "maze", "--worlds", "10500:10503"),
    ("meng_fig8", "--worlds", "10500:10502"),
)


@pytest.mark.full
@pytest.mark.parametrize("arguments", CHEAP, ids=[arguments[0] for arguments in CHEAP])
def test_quick_runs_give_the_same_json_with_one_and_with_two_processes(tmp_path, arguments):
    found = []
    for number, processes in enumerate(("1", "1", "2")):
        path = tmp_path / f"{number}.json"
        command = ["experiment", arguments[0], "--quick", *arguments[1:], "--json", str(path)]
        subprocess.run(
            [sys.executable, "-m", "tutorial_lib", *command],
            env={**os.environ, "LOKY_MAX_CPU_COUNT": processes},
            check=True,
            capture_output=True,
            timeout=900,
        )
        report = json.loads(path.read_text())
        assert report.pop("seconds") > 0  # the one thing that may differ
        found.append(json.dumps(report))
    assert found[0] == found[1] == found[2]
