"""What many machines cost is what the stored results took."""

import re
from pathlib import Path

import pytest

from tutorial_lib.experiments.common.results import load_result

PAGE = Path(__file__).parents[2] / ".github" / "CLUSTER.md"
CORES, WORLDS, MANY = 2, 1_000, 64
ROWS = re.findall(r"^\| `(\w+)` \| (\d+) \| ([\d.]+) \| (\d+) min \|$", PAGE.read_text(), re.M)


@pytest.mark.parametrize(("name", "seconds", "hours", "minutes"), ROWS)
def test_the_table_has_today_s_slopes(name, seconds, hours, minutes):
    report = load_result(name)
    slope = CORES * report.seconds / len(report.worlds)
    assert float(seconds) == pytest.approx(slope, rel=0.05, abs=0.5)
    assert float(hours) == pytest.approx(WORLDS * slope / 3_600, rel=0.05)
    assert float(minutes) == pytest.approx(60 * WORLDS * slope / 3_600 / MANY, rel=0.1, abs=0.5)


def test_the_table_is_there():
    assert len(ROWS) == 7
