import json
import re
from pathlib import Path

import pytest

HERE = Path(__file__).parent.parent
README = (HERE / "README.md").read_text(encoding="utf-8")
RESULTS = HERE / "tutorial_lib" / "results"


def rows_of(name):
    return json.loads((RESULTS / f"{name}.json").read_text())["rows"]


def cells_of(label):
    line = next(line for line in README.splitlines() if line.startswith(f"| {label} |"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


@pytest.mark.parametrize("row", rows_of("plans"), ids=lambda row: row["family"])
def test_the_table_of_plans_is_that_of_the_results(row):
    numbers = [str(row[key]) for key in ("plans", "valid", "drives")]
    expected = [*numbers, f"{row['success']:.1%}", str(row["walls_crossed"])]
    assert cells_of(row["family"]) == expected


@pytest.mark.parametrize(
    ("label", "method"),
    [
        ("numpy, vectorised", "numpy"),
        ("rays, batches of 256", "numba"),
        ("rays, one pose at a time", "numba_single"),
        ("pictures 64 × 16", "image16"),
        ("pictures 64 × 64", "image64"),
    ],
)
def test_the_table_of_rays_is_that_of_the_results(label, method):
    ratios = [row["ratio"] for row in rows_of("raycast") if row["method"] == method]
    assert cells_of(label) == [f"{ratio:.1f} ×" for ratio in ratios]


def test_the_speed_of_the_fleet_is_that_of_the_results():
    ratio = next(row["ratio"] for row in rows_of("fleet") if row["method"] == "fleet")
    assert f"steps {ratio:.1f} times as fast" in README


def test_the_example_runs(capsys):
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL).group(1)
    exec(code, {})
    assert "[ True]" in capsys.readouterr().out


def test_every_picture_and_page_that_is_linked_is_there():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert links
    for link in links:
        assert (HERE / link).exists(), link
