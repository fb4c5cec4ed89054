import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from tutorial_lib.experiments.common.agents import custom
from tutorial_lib.interfaces import Plan

HERE = Path(__file__).parents[2]
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
        ("images 64 × 16", "image16"),
        ("images 64 × 64", "image64"),
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
        next(r for r in rows if (r["controller"], r["condition"]) == (which, "clean"))
        for which in ("k5", "oracle")
    )
    words = f"{name} {k5['success']:.1%} with k = 5, {oracle['success']:.1%} by the oracle"
    assert words in README


ESTIMATORS = {
    "RE, k = 0": "k0",
    "RE, k = 2": "k2",
    "RE, k = 5": "k5",
    "RE, laser, k = 2": "laser",
    "SPTM's network": "sptm",
    "image similarity": "image",
    "true geometry": "geometry",
}


def share(value, digits=1):
    return "" if value is None else f"{value:.{digits}%}"


@pytest.mark.parametrize(("label", "estimator"), ESTIMATORS.items())
def test_the_table_of_estimators_is_that_of_the_results(label, estimator):
    row = next(row for row in rows_of("calibration") if row["estimator"] == estimator)
    keys = ("precision_mix", "precision_consecutive", "precision_map")
    expected = [f"{row['auc']:.3f}", f"{row['ece']:.3f}", *(share(row[key]) for key in keys)]
    assert cells_of(label) == [*expected, share(row["far_above_09"], 2)]


@pytest.mark.parametrize(
    ("label", "method", "chosen"),
    [(f"RE above {p:g}", "meng", p) for p in (0.9, 0.95, 0.97, 0.99)]
    + [(f"every {n}th frame", "sptm", n) for n in (10, 20, 30, 40)],
)
def test_the_table_of_anchors_is_that_of_the_results(label, method, chosen):
    rows = {
        (row["context"], row["condition"]): row
        for row in rows_of("meng_fig7")
        if (row["method"], row["threshold"]) == (method, chosen)
    }
    keys = [("k0", "clean"), ("k2", "clean"), ("k2", "noise"), ("k5", "clean")]
    expected = [
        f"{rows[key]['cover_rate']:.1%} at {rows[key]['sparsity']:.3f}" if key in rows else ""
        for key in keys
    ]
    assert cells_of(label) == expected


def test_what_is_said_of_disturbances_is_that_of_the_results():
    rows = {row["disturbance"]: row for row in rows_of("disturbances")}
    for kind in ("none", "pushed", "turned", "person"):
        assert f"{rows[kind]['finished']:.1%}" in README
    assert f"{rows['carried']['soon']:.1%} declare within 5 s that they are lost" in README


def test_the_speed_of_reachability_is_that_of_the_results():
    rows = {row["what"]: row for row in rows_of("reachability")}
    assert f"run {rows['rollouts']['per_s']:,.0f} rollouts a second" in README
    assert f"{rows['cached']['per_s']:,.0f} queries a second" in README
    assert f"{rows['cached']['over_plain']:.1f} times as many" in README


def test_the_speed_of_control_is_that_of_the_results():
    rows = {r["stage"]: r for r in rows_of("control") if r["cars"] == 256}
    assert f"{rows['all']['car_steps_per_s']:,.0f} car-steps a second" in README
    assert f"{rows['network']['plain_over_cached']:.1f} times as fast" in README


def test_the_examples_run(capsys):
    first, second, _ = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names = {}
    exec(first, names)
    assert "[ True]" in capsys.readouterr().out
    exec(second, names)
    assert "m from the target" in capsys.readouterr().out


def test_a_planner_of_ones_own_is_compared(tmp_path):
    *_, planner = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert planner.count("\n") < 30
    (tmp_path / "my_planner.py").write_text(planner)
    agent = custom(f"{tmp_path / 'my_planner.py'}:Doubtful")
    usual = Plan((1, 2), 0, (0.99, 0.99, 0.8))
    agent.planner.usual = SimpleNamespace(plan=lambda *arguments: usual)
    assert agent.planner.plan(None, None, None).refusal
    agent.planner.usual = SimpleNamespace(plan=lambda *arguments: Plan((), 0, (0.95,)))
    assert not agent.planner.plan(None, None, None).refusal
    assert "--agent my_planner.py:Doubtful" in README


def test_every_picture_and_page_that_is_linked_is_there():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert links
    for link in links:
        assert (HERE / link).exists(), link


@pytest.mark.parametrize("world", range(20_000, 20_005))
def test_the_table_of_navigation_is_that_of_the_results(world):
    found = {row["method"]: row for row in rows_of("meng_table2") if row["world"] == world}
    label = f"{found['meng']['family']} {world}, {found['meng']['area']} m²"
    expected = []
    for name in ("meng", "sptm"):
        row = found[name]
        expected += [f"{row['success']:.1%}", f"{row['vertices']:,} / {row['edges']:,}"]
    expected += [f"{found[name]['success']:.1%}" for name in ("random", "oracle")]
    assert cells_of(label) == expected


def test_what_is_said_of_navigation_is_that_of_the_results():
    notes = json.loads((RESULTS / "meng_table2.json").read_text())["notes"]
    by_kind = dict(note.split(": ", 1) for note in notes)
    for name, words in (("meng", "Meng"), ("sptm", "SPTM")):
        assert f"{by_kind[f'{name}, all worlds'].split()[0]} for {words}" in README
    assert f"a difference of {by_kind['meng - sptm']}" in README
    assert f"{by_kind['meng'].split()[0]} of Meng's edges are no wormholes" in README


def notes_of(name):
    """The notes of a result by what stands before their colon."""
    notes = json.loads((RESULTS / f"{name}.json").read_text())["notes"]
    return dict(note.split(": ", 1) for note in notes if ": " in note)


def listed(rows, key, digits):
    """A column as it is written in a sentence."""
    *first, last = (f"{row[key]:.{digits}%}" for row in rows)
    return f"{', '.join(first)} and {last}"


def test_what_is_said_of_a_plans_probability_is_that_of_the_results():
    rows = [row for row in rows_of("meng_fig9") if not row["calibrated"]]
    assert f"{sum(row['trials'] for row in rows):,} starts from anywhere" in README
    assert listed(rows, "probability", 0) in README
    assert listed(rows, "success", 0) in README
    by_kind = notes_of("meng_fig9")
    for kind in ("product of RE", "recalibrated"):
        ece, spearman = re.fullmatch(r"ECE (\S+), Spearman .* (\S+)", by_kind[kind]).groups()
        assert f"ECE {ece}" in README
        assert f"Spearman {spearman}" in README


def test_what_is_said_of_fewer_trajectories_is_that_of_the_results():
    rows = rows_of("meng_fig10")
    assert listed(rows, "success", 1) in README
    assert listed(rows, "no_generalisation", 0) in README
    assert listed(rows, "share", 0) in README


def test_what_is_said_of_growth_is_that_of_the_results():
    (note,) = json.loads((RESULTS / "meng_fig13.json").read_text())["notes"]
    assert note in README


def test_what_is_said_of_faults_is_that_of_the_results():
    rows = {row["fault"]: row for row in rows_of("faults")}
    assert f"{rows['blocked']['reached']:.1%} of {rows['blocked']['trials']} robots" in README
    assert f"{rows['none']['reached']:.1%} when nobody is there" in README
    assert f"{rows['strange_goal']['refused']:.1%} are refused" in README
    assert f"{rows['own_goal']['refused']:.1%} of the building's own" in README


def test_what_is_said_of_other_colours_and_real_maps_is_that_of_the_results():
    by_kind = notes_of("meng_table2_shifted")
    for name, words in (("meng", "Meng"), ("sptm", "SPTM")):
        assert f"{by_kind[f'{name}, all worlds'].split()[0]} for {words}" in README
    for name in ("depot", "tb3_sandbox", "warehouse"):
        rows = {row["method"]: row["success"] for row in rows_of(f"meng_table2_{name}")}
        assert f"{name} {rows['meng']:.1%} and {rows['sptm']:.1%}" in README


def test_what_is_said_of_the_speed_of_maps_is_that_of_the_results():
    rows = rows_of("map")
    indexed, exhaustive = (row for row in rows if row["map"] == "one building, no reuse")
    assert f"{indexed['queries'] / exhaustive['queries']:.1%} of the queries" in README
    assert f"finds {indexed['recall']:.2%} of the edges" in README
    large = {row["vertices"]: row for row in rows[4:] if row["method"] == "indexed"}
    thousand = min(large, key=lambda size: abs(size - 1_000))
    assert f"{large[thousand]['plan_ms']:.0f} ms on {thousand:,} vertices" in README
    assert f"{large[max(large)]['plan_ms']:.0f} ms on {max(large):,}" in README


def test_what_is_said_of_thresholds_is_that_of_the_results():
    rows = [row for row in rows_of("meng_table2_thresholds") if row["replans"]]
    assert listed([row for row in rows if row["method"] == "meng"], "success", 1) in README
    for row in rows:
        if row["method"] == "sptm" and row["threshold"] in (0.9, 0.99, 0.999):
            assert f"{row['success']:.1%} at {row['threshold']:g}" in README
