import pytest

from tests.experiments.results_page.tables import cells, section
from tutorial_lib.experiments.results_page import navigation, paper
from tutorial_lib.experiments.results_page.navigation import (
    failures,
    gaps,
    sizes_by_world,
    success_by_world,
    table_of_maps,
    thresholds,
    total_vertices,
)
from tutorial_lib.experiments.results_page.sources import load_results
from tutorial_lib.experiments.results_page.tables import total

METHODS = ("meng", "sptm", "random", "oracle")


def world(place, *successes, trials=200):
    rows = []
    for number, (method, success) in enumerate(zip(METHODS, successes, strict=True)):
        row = {"world": place, "family": "loop_corridor", "area": 1_287, "images": 25_590}
        row |= {"method": method, "trials": trials, "success": success}
        row |= {"low": success - 0.1, "high": success, "wrong_place": 0.01, "gave_up": 0.02}
        row |= {"stuck": 0.03, "late": 0.04, "vertices": 1_000 + number, "edges": 2_000 + number}
        rows.append(row | {"wormholes": 3 + number})
    return rows


def test_success_of_each_world_and_of_all_together_is_counted():
    rows = [*world(7, 0.9, 0.8, 0.1, 1.0), *world(8, 0.5, 0.6, 0.2, 1.0, trials=100)]
    found = cells(success_by_world(rows))
    assert found[0] == ["world", "Meng", "SPTM", "random", "oracle"]
    seventh = ["**90.0% (80.0 to 90.0)**", "80.0% (70.0 to 80.0)", "10.0% (0.0 to 10.0)"]
    assert found[1] == ["loop corridor 7, 1,287 m²", *seventh, "100.0% (90.0 to 100.0)"]
    assert found[2][1:3] == ["50.0% (40.0 to 50.0)", "**60.0% (50.0 to 60.0)**"]
    sums = ["**76.7% (230 of 300)**", "73.3% (220 of 300)", "13.3% (40 of 300)"]
    assert found[3] == ["all together", *sums, "100.0% (300 of 300)"]
    assert len(cells(success_by_world(world(7, 0.9, 0.8, 0.1, 1.0)))) == 2


def test_a_map_has_no_total_and_random_stands_beside_every_one():
    rows = [*world("depot.yaml", 0.7, 0.5, 0.2, 1.0), *world("hall.yaml", 0.9, 0.9, 0.5, 1.0)]
    found = cells(table_of_maps(rows))
    assert [line[0] for line in found] == ["map", "depot, 1,287 m²", "hall, 1,287 m²"]
    assert found[2][1:4] == [
        "**90.0% (80.0 to 90.0)**", "**90.0% (80.0 to 90.0)**", "50.0% (40.0 to 50.0)",
    ]  # fmt: skip


def test_sizes_of_both_maps_stand_side_by_side():
    (line,) = cells(sizes_by_world(world(7, 0.9, 0.8, 0.1, 1.0)))[1:]
    expected = ["25,590", "1,000", "2,000", "3", "1,001", "2,001", "4"]
    assert line[1:] == expected


def test_failures_are_counted_by_how_a_trial_ended():
    found = cells(failures(world(7, 0.9, 0.8, 0.1, 1.0)))
    assert found[0][3:] == ["arrived elsewhere", "gave up", "stuck", "out of time"]
    assert [line[1:] for line in found[1:]] == [
        ["Meng", "200", "2", "4", "6", "8"],
        ["SPTM", "200", "2", "4", "6", "8"],
    ]


def test_thresholds_are_shown_with_counts():
    row = {"method": "sptm", "threshold": 0.995, "replans": 0, "vertices": 4_693, "edges": 24_210}
    row |= {"wormholes": 1_000, "trials": 120, "success": 0.9}
    found = cells(thresholds([row, row | {"method": "meng", "replans": 8}]))
    size = ["4,693", "24,210", "1,000", "90.0% (108 of 120)"]
    assert found[1:] == [["SPTM", "0.995", "no", *size], ["Meng", "0.995", "yes", *size]]


def test_totals_and_gaps_are_those_of_the_worlds():
    rows = [*world(7, 0.9, 0.8, 0.1, 1.0), *world(8, 0.5, 0.6, 0.2, 1.0, trials=100)]
    assert total(rows, "meng") == {"method": "meng", "trials": 300, "success": 230 / 300}
    assert gaps(rows, "meng", "sptm") == pytest.approx([0.1, -0.1])
    assert total_vertices(rows, "sptm") == 2_002
    assert total_vertices(rows, places=[8]) == 1_000


def test_the_paper_s_numbers_are_those_of_its_table():
    text = section(navigation, "Table II: navigation", load_results()).text
    (found,) = [cells(part) for part in text.split("\n\n") if part.startswith("| paper's world")]
    first = ["460 m²", "30,342", "86.9%", "974 / 1,482", "48.1%", "1,648 / 3,201"]
    assert found[1] == first
    assert len(found) == 1 + len(paper.TABLE_2) == 6
