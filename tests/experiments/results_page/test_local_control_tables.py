import pytest

from tests.experiments.results_page.tables import cells
from tutorial_lib.experiments.results_page.local_control import (
    BREAKDOWN,
    CONTROLLERS,
    breakdown,
    on_maps,
    smoothing,
    table_1,
    variants,
)


def made_up(controller, condition, success, **others):
    row = {"controller": controller, "condition": condition, "episodes": 40, "success": success}
    row |= {"low": success - 0.05, "high": success + 0.02, "paper": None}
    return row | dict.fromkeys([*BREAKDOWN, "collided"], 0.5) | others


def every(condition, start):
    """A row for each controller, each a point above the one before."""
    return [
        made_up(name, condition, start + 0.01 * number) for number, name in enumerate(CONTROLLERS)
    ]


def test_table_1_has_each_controller_s_success_in_the_column_of_its_condition():
    rows = [*every("clean", 0.1), *every("noise", 0.2), *every("obstacles", 0.3)]
    rows += every("shifted", 0.4)
    rows[1]["paper"] = 0.46
    found = cells(table_1(rows[::-1]))
    assert found[0] == [
        *("controller", "paper, clean", "clean", "noise", "two obstacles", "shifted colours")
    ]
    assert [line[0] for line in found[1:]] == list(CONTROLLERS.values())
    direct = ["46%", "11.0% (6.0 to 13.0)", "21.0% (16.0 to 23.0)"]
    assert found[2][1:] == [*direct, "31.0% (26.0 to 33.0)", "41.0% (36.0 to 43.0)"]
    assert found[1][1] == ""


def test_the_best_is_bold_and_the_oracle_takes_no_part():
    rows = [*every("clean", 0.1), *every("noise", 0.2), *every("obstacles", 0.3)]
    rows += every("shifted", 0.4)
    found = cells(table_1(rows))
    assert found[-1][2] == "16.0% (11.0 to 18.0)"
    assert found[-2][2] == "**15.0% (10.0 to 17.0)**"
    assert sum("**" in cell for line in found for cell in line) == 4


def test_a_missing_row_is_an_error():
    with pytest.raises(LookupError, match="noise"):
        table_1(every("clean", 0.1))


def test_the_breakdown_has_each_kind_of_target_in_its_column():
    rows = every("clean", 0.1)
    for number, key in enumerate([*BREAKDOWN, "collided"]):
        rows[2][key] = 0.9 + 0.01 * number
    found = cells(breakdown(rows))
    assert found[0][1:] == [*BREAKDOWN.values(), "collided"]
    expected = [f"**{90 + number}.0%**" for number in range(len(BREAKDOWN))]
    assert found[3] == ["C, k = 0", *expected, "98.0%"]  # collisions are not to be won
    assert found[4][1] == "50.0%"


def test_each_map_has_a_column_with_the_rows_of_its_condition():
    maps = {"depot": [*every("clean", 0.1), *every("obstacles", 0.2)], "hall": every("clean", 0.5)}
    maps["hall"][-1]["episodes"] = 30
    found = cells(on_maps(maps, "clean"))
    assert found[0] == ["controller, clean", "depot, 40 episodes", "hall, 30 episodes"]
    assert found[1] == ["random waypoints", "10.0% (5.0 to 12.0)", "50.0% (45.0 to 52.0)"]
    assert "20.0%" in on_maps({"depot": maps["depot"]}, "obstacles")


def test_the_variant_with_the_least_error_and_the_most_success_is_bold():
    first = {"variant": "matching", "parameters": 1_234, "worlds": 96, "median_m": 0.3}
    first |= {"success": 0.8, "low": 0.7, "high": 0.9}
    other = {"variant": "pair", "parameters": 999, "worlds": 4, "median_m": 0.2}
    other |= {"success": 0.6, "low": 0.5, "high": 0.7}
    assert cells(variants([first, other]))[1:] == [
        ["columns matched (as shipped)", "1,234", "96", "0.30 m", "**80.0% (70.0 to 90.0)**"],
        ["the paper's pair encoder, in small", "999", "4", "**0.20 m**", "60.0% (50.0 to 70.0)"],
    ]


def test_each_controller_is_compared_with_itself_smoothed_in_either_kind_of_worlds():
    def row(controller, share, success):
        found = {"controller": controller, "share": share, "success": success}
        return found | {"low": success - 0.1, "high": success + 0.1}

    homes = [row("k0", 1.0, 0.5), row("k0", 0.3, 0.6), row("k5", 1.0, 0.8), row("k5", 0.3, 0.7)]
    halls = [row("k0", 1.0, 0.4), row("k0", 0.3, 0.3), row("k5", 1.0, 0.2), row("k5", 0.3, 0.3)]
    found = cells(smoothing({"homes": homes, "halls": halls[::-1]}))
    ends = [f"{name}, share {share}" for name in ("homes", "halls") for share in ("1", "0.3")]
    assert found[0] == ["controller", *ends]
    low = ["50.0% (40.0 to 60.0)", "**60.0% (50.0 to 70.0)**"]
    assert found[1] == ["C, k = 0", *low, "**40.0% (30.0 to 50.0)**", "30.0% (20.0 to 40.0)"]
    assert found[2][0] == "C, k = 5"
    assert [cell.startswith("**") for cell in found[2][1:]] == [True, False, False, True]
