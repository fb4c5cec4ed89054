"""Tables of what was learned of a part of the drives."""

from tests.experiments.results_page.tables import cells, section
from tutorial_lib.experiments.common.report import SHARE, Finding, Report
from tutorial_lib.experiments.results_page import navigation
from tutorial_lib.experiments.results_page.navigation import chosen, composed_trials, map_sizes
from tutorial_lib.experiments.results_page.sources import (
    COMMANDS,
    DRIVES,
    HARDER,
    LEARNED,
    Results,
    command_of,
    stored_as,
)

FINDINGS = (
    Finding("meng, all worlds", 0.91, 0.8, 0.95, SHARE),
    Finding("meng, composed", 0.81, 0.7, 0.9, SHARE),
    Finding("sptm, composed", 0.12, 0.05, 0.2, SHARE),
    Finding("random, composed", 0.03, 0.01, 0.05, SHARE),
    Finding("oracle, composed", 1.0, 1.0, 1.0, SHARE),
    Finding("meng - sptm, composed", 0.69, 0.6, 0.75),
    Finding("goals on a learned drive, composed", 0.82, form=SHARE),
    Finding("trials on a recorded drive past start and goal", 0.995, form=SHARE),
)


def row(world, method, composed, success):
    return {
        "world": world,
        "method": method,
        "images": 4_000,
        "vertices": 900 + world,
        "edges": 2_000,
        "wormholes": 2,
        "trials": 200,
        "trials_composed": composed,
        "success_driven": success,
    }


ROWS = [
    row(world, method, composed, success)
    for world, composed, success in ((0, 100, 0.9), (10, 150, 0.5), (20, 200, None))
    for method in ("meng", "sptm", "random", "oracle")
]


def results(rows, *names):
    """Stored reports that all have those rows."""
    worlds = tuple(range(20_000, 20_010))
    return Results(
        {name: Report(name, 0, worlds, False, 1.0, rows, findings=FINDINGS) for name in names}
    )


def test_success_in_composed_trials_stands_beside_that_in_driven_ones():
    found = cells(composed_trials(results(ROWS, "a"), {"20%": "a"}))
    assert found[0] == [
        "learned", "trials", "Meng", "SPTM", "random", "oracle", "Meng - SPTM", "Meng, driven",
        "goals passed",
    ]  # fmt: skip
    (line,) = found[1:]
    assert line[:3] == ["20%", "450", "81.0% (70.0% to 90.0%)"]
    assert line[6] == "+69.0 points (+60.0 to +75.0)"
    assert line[8] == "82.0%"
    assert line[7] == "76.7%"  # 90 of 100 and 25 of 50; a world without driven trials has none


def test_a_table_in_which_everything_is_composed_has_no_driven_success():
    rows = [row(0, method, 200, None) for method in ("meng", "sptm")]
    (line,) = cells(composed_trials(results(rows, "a"), {"a tour": "a"}))[1:]
    assert line[7] == ""


def test_sizes_are_means_over_worlds_and_wormholes_sums():
    (line,) = cells(map_sizes(results(ROWS, "a"), {"20%": "a"}))[1:]
    assert line == ["20%", "4,000", "910", "2,000", "6", "910", "2,000", "6"]


def test_thresholds_have_their_success_in_composed_trials():
    rows = [
        {"method": "meng", "threshold": 0.97, "replans": True, "vertices": 5, "edges": 6}
        | {"wormholes": 0, "trials": 10, "success": 0.5, "success_composed": share}
        for share in (0.25, 0.75)
    ]
    found = cells(chosen(rows))
    assert found[0][-2:] == ["success", "composed"]
    assert [line[-1] for line in found[1:]] == ["25.0%", "75.0%"]


def test_the_sections_say_what_the_protocol_hides_and_by_which_command():
    names = [stored_as(drives) for drives in LEARNED]
    title, stored = "Table II: a part of the drives", (*names, HARDER, "meng_table2")
    found = section(navigation, title, results(ROWS, *stored))
    text = found.text
    assert found.sources == (*names, HARDER)
    assert "in 99.5% of its trials some recorded drive passes" in text
    for drives, name in zip(LEARNED, names, strict=True):
        assert f"--worlds 20000:20010 --drives {drives} --json" in command_of(name)
        assert command_of(name) in text
    assert "--drives tour --starts anywhere --goals turned --json" in command_of(HARDER)
    assert "| a tour, harder trials | 450 | 81.0% (70.0% to 90.0%) |" in text


def test_thresholds_are_measured_for_each_part():
    names = tuple(stored_as(drives, "thresholds") for drives in DRIVES)
    title = "Table II: thresholds for a part of the drives"
    rows = [{"method": "meng", "threshold": 0.97, "replans": True, "vertices": 5, "edges": 6}]
    rows[0] |= {"wormholes": 0, "trials": 10, "success": 0.5, "success_composed": 0.25}
    reports = {
        name: Report(
            name, 0, (1,), False, 1.0, rows, (f"best with --drives {drives}: p_edge 0.97",)
        )
        for drives, name in zip(DRIVES, names, strict=True)
    }
    found = section(navigation, title, Results(reports))
    assert found.sources == names
    assert "Best with --drives tour: p_edge 0.97." in found.text
    assert set(names) < set(COMMANDS)
