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


@pytest.mark.parametrize(
    ("label", "controller"),
    [
        ("random waypoints", "random"),
        ("direct, k = 2", "direct"),
        ("C, k = 0", "k0"),
        ("C, k = 2", "k2"),
        ("C, k = 5", "k5"),
        ("C, laser, k = 2", "laser"),
        ("oracle", "oracle"),
    ],
)
def test_the_table_of_local_controllers_is_that_of_the_results(label, controller):
    rows = {r["condition"]: r for r in rows_of("meng_table1") if r["controller"] == controller}
    paper = rows["clean"]["paper"]
    expected = ["" if paper is None else f"{paper:.0%}"]
    expected += [
        f"{rows[name]['success']:.1%}" for name in ("clean", "noise", "obstacles", "shifted")
    ]
    assert cells_of(label) == expected


@pytest.mark.parametrize("name", ["depot", "tb3_sandbox", "warehouse"])
def test_success_on_real_maps_is_that_of_the_results(name):
    rows = rows_of(f"meng_table1_{name}")
    k5, oracle = (
        next(r for r in rows if (r["controller"], r["condition"]) == (who, "clean"))
        for who in ("k5", "oracle")
    )
    told = f"{name} {k5['success']:.1%} with k = 5, {oracle['success']:.1%} by the oracle"
    assert told in README


def test_the_speed_of_control_is_that_of_the_results():
    rows = {r["stage"]: r for r in rows_of("control") if r["cars"] == 256}
    assert f"{rows['all']['car_steps_per_s']:,.0f} car-steps a second" in README
    assert f"{rows['network']['plain_over_cached']:.1f} times as fast" in README


def test_the_examples_run(capsys):
    first, second = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names = {}
    exec(first, names)
    assert "[ True]" in capsys.readouterr().out
    exec(second, names)
    assert "m from the target" in capsys.readouterr().out


def test_every_picture_and_page_that_is_linked_is_there():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert links
    for link in links:
        assert (HERE / link).exists(), link
