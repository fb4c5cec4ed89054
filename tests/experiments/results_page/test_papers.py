"""Papers and course: nothing left out, and what is said of trends holds of the stored rows."""

import re
from functools import cache
from pathlib import Path

import pytest

from tests.experiments.results_page.tables import cells, section
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.results_page import papers
from tutorial_lib.experiments.results_page.markdown import table
from tutorial_lib.experiments.results_page.page import page_of
from tutorial_lib.experiments.results_page.sources import Results, load_results
from tutorial_lib.experiments.results_page.tables import matching, one
from tutorial_lib.experiments.results_page.templates import render_chapter

RESULTS = load_results()
PAGE = Path(papers.__file__).parents[2] / "results"
CHAPTER = "Papers and course"
SIGNS = ("plain", "wayfinding")


@cache
def text():
    """The whole page."""
    return page_of(RESULTS)


@cache
def sections():
    """Of the chapter: of each paper what is compared, then what is ours."""
    return render_chapter(RESULTS, papers)[1]


def names(lines):
    """Tables and figures of rows, whatever else their names say; a range is taken apart."""
    found = set()
    for name, *_ in lines:
        if number := re.match(r"\[?Figs?\. (\d+)(?: to (\d+))?", name):
            first, last = number[1], number[2] or number[1]
            found |= {f"Fig. {n}" for n in range(int(first), int(last) + 1)}
        elif number := re.match(r"\[?(Table \w+)", name):
            found.add(number[1])
    return found


def lines(title):
    """The lines of the table of one section."""
    (found,) = [found for found in sections() if found.title.startswith(title)]
    _, *rows = cells(found.text.split("\n\n")[2])
    return rows


def test_every_table_and_figure_of_both_papers_has_a_row():
    meng, nts = lines("Meng"), lines("Chaplot")
    assert names(meng) == {"Table I", "Table II", *(f"Fig. {n}" for n in range(1, 14))}
    assert names(nts) == {"Table 1", "Table 2", *(f"Fig. {n}" for n in range(1, 15))}
    for line in (*meng, *nts):
        assert len(line) == 4
        assert line[3]


def test_a_row_has_what_the_paper_reports_and_what_was_measured():
    rows = {line[0].partition("]")[0].removeprefix("["): line for line in lines("Chaplot")}
    assert rows["Table 1, NTS, RGBD"][1] == "87%, 58%, 43%"
    assert rows["Table 2, without noise, learned choice of frontier"][1] == "+10.0 points"
    levels = [
        one(RESULTS.rows("nts_table1"), agent="nts", sensor="rgbd", signs="plain", difficulty=d)
        for d in ("easy", "medium", "hard")
    ]
    mine = ", ".join(f"{row['success']:.0%}" for row in levels)
    assert rows["Table 1, NTS, RGBD"][2].startswith(f"{mine} / ")
    assert rows["Table 2, without stop, target-driven RL"][1] == "+19.0 points"
    assert rows["Table 1, target-driven RL, RGB"][1:3] == ["56%, 17%, 6%", "not trained here"]
    learned = [
        RESULTS.row(
            "nts_table2_rl", agent="map_rl", signs="plain", difficulty=d, condition="standard"
        )
        for d in ("easy", "medium", "hard")
    ]
    mine = ", ".join(f"{row['success']:.0%}" for row in learned)
    assert rows["Table 1, metric map and RL, RGBD"][2].startswith(f"{mine} / ")
    (car,) = [line for line in lines("Meng") if "IV-D" in line[0]]
    for number in ("7 trajectories", "3,200 images", "206 vertices", "215 edges"):
        assert number in car[1]
    depot = one(RESULTS.rows("meng_table2_depot"), method="meng")
    assert f"depot {depot['success']:.1%} with {depot['vertices']:,} vertices" in car[2]
    assert car[3] == "no counterpart"


def test_what_is_said_of_meng_holds_of_the_stored_rows():
    clean = matching(RESULTS.rows("meng_table1"), condition="clean")
    direct, k0, k2, k5 = (
        one(clean, controller=name)["success"] for name in ("direct", "k0", "k2", "k5")
    )
    assert direct + 0.3 < k0 < k2 < k5
    encoders = {row["variant"]: row["success"] for row in RESULTS.rows("ablation_encoder")}
    assert encoders["pair"] > max(encoders["separate"], encoders["stacked"])
    anchors = {row["context"]: row for row in RESULTS.rows("meng_fig5")}
    assert anchors["k5"]["anchors"] < anchors["k2"]["anchors"] < anchors["laser"]["anchors"]
    assert all(row["with_clearance_low"] > 0 > row["with_turn_high"] for row in anchors.values())
    assert anchors["laser"]["with_clearance"] >= anchors["k2"]["with_clearance"]
    rows = RESULTS.rows("meng_table2")
    success, vertices = (
        {name: [row[key] for row in matching(rows, method=name)] for name in ("meng", "sptm")}
        for key in ("success", "vertices")
    )
    assert sum(success["sptm"]) >= sum(success["meng"])
    assert max(vertices["meng"]) < min(vertices["sptm"])
    kept = matching(RESULTS.rows("meng_fig7"), method="meng", condition="clean", threshold=0.99)
    stored = [one(kept, context=name)["stored"] for name in ("k0", "k2", "k5")]
    assert stored == sorted(stored)
    bins = matching(RESULTS.rows("meng_fig9"), calibrated=False)
    arrived = [row["success"] for row in bins]
    assert arrived == sorted(arrived)
    assert all(row["success"] < row["probability"] + 0.01 for row in bins)
    remedy = {row["remedy"]: row["success"] for row in RESULTS.rows("meng_fig12")}
    assert remedy["replan"] - remedy["none"] > 0.5 * (remedy["all"] - remedy["none"])


def test_what_is_said_of_nts_holds_of_the_stored_rows():
    rows = RESULTS.rows("nts_table1")
    for signs in SIGNS:
        for level in ("easy", "medium", "hard"):
            spl = {
                agent: one(rows, agent=agent, sensor="rgbd", signs=signs, difficulty=level)["spl"]
                for agent in ("nts", "ans_like", "fbe", "il")
            }
            assert spl["ans_like"] == max(spl.values())
            assert (spl["nts"] > spl["fbe"]) == (level != "easy")
    for signs in SIGNS:
        for agent in ("nts", "nts_no_graph", "nts_no_score"):
            first, last = (
                one(RESULTS.rows("nts_fig8"), agent=agent, signs=signs, goals=count)
                for count in (1, 10)
            )
            assert last["success"] < first["success"]
            grows = last["spl_gap"] > first["spl_gap"]
            assert grows == (
                (agent, signs)
                in {
                    ("nts_no_score", "plain"),
                    ("nts_no_score", "wayfinding"),
                    ("nts_no_graph", "plain"),
                }
            )
    assert last["success_gap_low"] > 0
    ahead = one(RESULTS.rows("nts_fig8"), agent="nts_no_graph", signs="wayfinding", goals=10)
    assert ahead["success_gap"] < 0 < ahead["success_gap_high"]


def test_what_is_said_of_the_papers_rules_holds_of_the_stored_rows():
    rows = RESULTS.rows("nts_table1_rules")

    def gap(agent, signs, level):
        keys = {"signs": signs, "difficulty": level}
        return abs(one(rows, agent="nts", **keys)["spl"] - one(rows, agent=agent, **keys)["spl"])

    for signs in SIGNS:
        for level in ("easy", "medium", "hard"):
            assert gap("nts_all_nodes", signs, level) < 0.01
            assert gap("nts_by_odometry", signs, level) < 0.01
        assert gap("nts_no_ghost_nodes", signs, "hard") > 0.2


def test_what_is_said_of_ltvn_holds_of_the_stored_rows():
    first = RESULTS.rows("ltvn_lifelong", block=0, family="others", perception="network")
    ltvn, sptm, ving, meng = (one(first, agent=name) for name in ("frozen", "sptm", "ving", "meng"))
    assert meng["vertices"] < ltvn["vertices"] < min(sptm["vertices"], ving["vertices"])
    assert ltvn["success"] > max(sptm["success"], ving["success"])


def test_a_departure_says_where_it_is_and_links_to_its_rows():
    assert papers.where("topology/planner.py", "06", measured="Fig. 8: whole maps") == (
        "[planner.py](../topology/planner.py) and "
        "[06](../../notebooks/06_probabilistic_planning.ipynb); "
        "[Fig. 8: whole maps](#fig-8-whole-maps)"
    )
    assert papers.where("agents/nts.py") == "[nts.py](../agents/nts.py)"


def test_what_is_ours_leads_to_files_and_headings_that_exist():
    headings = re.findall(r"^#+ (.*)$", text(), re.MULTILINE)
    lines = [line for found in sections()[1::2] for line in found.text.splitlines()]
    departures = [line for line in lines if line.startswith("- ")]
    assert len(departures) > 60
    for line in departures:
        files = re.findall(r"\]\(([^)#]+)\)", line)
        assert files, line
        for target in files:
            assert (PAGE / target).is_file(), target
        for title in re.findall(r"\[([^]]*)\]\(#", line):
            assert title in headings, line


def test_each_link_of_the_chapter_leads_to_a_heading():
    contents = dict(re.findall(r"^ *- \[(.*)\]\(#(.*)\)$", text(), re.MULTILINE))
    links = re.findall(r"\]\(#([^)]*)\)", text().partition(f"\n## {CHAPTER}\n")[2])
    assert len(links) > 40
    assert set(links) <= set(contents.values())


def test_a_damaged_row_is_named_with_its_command():
    rows = [row for row in RESULTS.rows("nts_fig8") if row["goals"] != 10]
    report = Report("nts_fig8", 0, (1,), False, 1.0, rows, ())
    with pytest.raises(InputError, match=r"nts_fig8\.json.*: damaged.*experiment nts_fig8 "):
        section(papers, sections()[2].title, Results({**RESULTS.reports, "nts_fig8": report}))


def test_sections_without_a_command_have_no_block_and_tables_are_whole():
    for shown in sections():
        assert "```" not in shown.text
        for part in shown.text.split("\n\n"):
            if part.startswith("|"):
                head, *lines = cells(part)
                assert table(head, lines) == part
