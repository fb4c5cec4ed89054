"""Tables of remedies for places that look alike, and of the filter."""

import pytest

from tests.experiments.results_page.tables import cells, section
from tutorial_lib.agents.remedies import REMEDIES
from tutorial_lib.experiments.common.report import SHARE, Finding, Report
from tutorial_lib.experiments.meng2020.fig12_localization import CASES
from tutorial_lib.experiments.results_page import aliasing, sources
from tutorial_lib.experiments.results_page.sources import Results

SHARES = tuple(aliasing.SHARES)


def remedy_row(number, name):
    share = 0.5 + number / 20
    return {
        "remedy": name,
        "trials": 500,
        "success": share,
        "low": share - 0.1,
        "high": share + 0.04,
        "wormholes": 10 - number,
        "edges": 4_000,
        "vertices": 1_500,
        "wrong_place": 0.01,
        "gave_up": 0.02,
        "stuck": 0.03,
        "late": 0.04,
        "lost": 0.0,
        "circled": 0.002,
    }


def case_row(case, **shares):
    row = {"case": case, "count": 1_200}
    for name in SHARES:
        value = shares.get(name)
        low, high = (None, None) if value is None else (value - 0.02, value + 0.01)
        row |= {name: value, f"{name}_low": low, f"{name}_high": high}
    return row


GAPS = (
    *(Finding(f"{name} - none", 0.01, -0.01, 0.03) for name in REMEDIES[1:5]),
    *(Finding(f"{name} - all", -0.02, -0.04, 0.01) for name in REMEDIES[5:9]),
    Finding("all - none", 0.45, 0.4, 0.5),
)
ROWS = {
    "meng_fig12": [remedy_row(number, name) for number, name in enumerate(REMEDIES)],
    "meng_fig12_localization": [
        case_row("driven", right=0.9, sure=0.7, right_if_sure=0.93),
        case_row("doors", right=0.8, sure=0.6, right_if_sure=0.88),
        case_row("standstill", changes_at_most_once=0.97),
        case_row("kidnapped", noticed=0.98, found=0.81),
    ],
}


@pytest.fixture
def results():
    worlds = tuple(range(20_000, 20_010))
    reports = {
        name: Report(name, 0, worlds, False, 1.0, rows, findings=GAPS)
        for name, rows in ROWS.items()
    }
    for names in aliasing.ELSEWHERE.values():
        for name, shares in zip(names, ((0.9, 0.8), (0.95, 0.7)), strict=True):
            rows = [
                {
                    "world": world,
                    "method": method,
                    "success": share if method == "meng" else 0.1,
                    "late": 1 - share,
                }
                for world, share in enumerate(shares)
                for method in ("meng", "sptm")
            ]
            share = Finding("meng, all worlds", sum(shares) / 2, form=SHARE)
            reports[name] = Report(name, 0, (0, 1), False, 1.0, rows, findings=(share,))
    return Results(reports)


def test_each_choice_of_remedies_is_compared_with_all_or_with_none(results):
    head, *lines = cells(aliasing.success_by_remedy(results))
    found = {line[0]: dict(zip(head, line, strict=True)) for line in lines}
    assert list(found) == list(aliasing.NAMES.values())
    assert found["none"]["points"] == ""
    assert found["filter alone"]["points"] == "+1.0 (-1.0 to +3.0) against *none*"
    assert found["all but filter"]["points"] == "-2.0 (-4.0 to +1.0) against *all*"
    assert found["all"]["points"] == "+45.0 (+40.0 to +50.0) against *none*"
    assert found["all"]["success"] == "**95.0% (85.0 to 99.0)**"
    assert found["none"]["success"] == "50.0% (40.0 to 54.0)"
    assert found["all"]["edges over 5 m"] == "1 of 4,000"
    assert found["all"]["out of time"] == "4.0%"


def test_every_choice_of_remedies_and_every_case_is_shown():
    assert list(aliasing.NAMES) == list(REMEDIES)
    assert list(aliasing.SHOWN_CASES) == list(CASES)


def test_a_case_of_the_filter_shows_only_what_it_has(results):
    head, *lines = cells(aliasing.filter_by_case(ROWS["meng_fig12_localization"]))
    assert len(lines) == 4
    found = {line[0]: dict(zip(head, line, strict=True)) for line in lines}
    carried = found["carried to another room"]
    assert carried["noticed within 5 s"] == "98.0% (96.0 to 99.0)"
    assert carried["within 2.5 m"] == ""
    assert found["driven"]["right where sure"] == "93.0% (91.0 to 94.0)"
    assert found["standing still"]["vertex changes at most once"] == "97.0% (95.0 to 98.0)"


def test_the_sections_tell_the_numbers_below_their_commands(results):
    titles = ("Fig. 12: starts that look alike", "A belief over vertices")
    titles += ("Table II with the remedies",)
    remedies, belief, elsewhere = (section(aliasing, title, results).text for title in titles)
    assert "With all remedies 95.0% of the trials succeed, with none 50.0%" in remedies
    assert "1 of 500 trials with all remedies" in remedies
    assert "Where it is sure it is right in 93.0% of the steps" in belief
    assert "corridor with a twin only in 88.0%" in belief
    assert "81.0% are localized again within 20 s" in belief
    assert "17.5% of the trials run out of time with the remedies, 15.0% without" in elsewhere
    for text, name in zip((remedies, belief), ROWS, strict=True):
        assert f"{sources.COMMANDS[name]} --json tutorial_lib/results/{name}.json" in text


def test_elsewhere_the_remedies_are_compared_world_by_world(results):
    head, *lines = cells(aliasing.success_elsewhere(results))
    assert [line[0] for line in lines] == list(aliasing.ELSEWHERE)
    found = dict(zip(head, lines[0], strict=True))
    assert (found["without"], found["with all"], found["worlds"]) == ("85.0%", "82.5%", "2")
    assert (found["points"], found["by world"]) == ("-2.5 (-10.0 to +5.0)", "-10.0 to +5.0")
