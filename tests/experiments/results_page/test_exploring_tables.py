"""Tables of exploration, from made-up rows."""

from itertools import product

from tests.experiments.results_page.tables import cells
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.results_page import exploring, returning, speed
from tutorial_lib.experiments.results_page.exploring import choices, in_time, success_and_spl
from tutorial_lib.experiments.results_page.sources import EXPLORING, Results
from tutorial_lib.experiments.results_page.summary import exploration

SECTIONS = (*exploring.SECTIONS, *returning.SECTIONS)
LEVELS = ("easy", "medium", "hard")
SIGNS = ("plain", "wayfinding")
SPL = {"nts": 0.6, "fbe": 0.5, "ans_like": 0.55, "nts_no_score": 0.4, "nts_blind": 0.45}
SPL |= {"il": 0.1, "random": 0.7, "oracle": 0.95}
GAIN = {"gain": 0.2, "gain_low": 0.1, "gain_high": 0.3}


def chosen(score, sensor, signs, difficulty):
    top1 = {"semantic": 0.8, "blind": 0.6, "histogram": 0.4, "random": 0.2}[score]
    row = {"score": score, "sensor": sensor, "signs": signs, "difficulty": difficulty}
    return row | {"decisions": 100, "top1": top1, "low": top1, "high": top1} | GAIN


CHOSEN = [
    chosen(*key)
    for key in product(("semantic", "blind", "histogram", "random"), ("rgbd",), SIGNS, LEVELS)
] + [chosen("semantic", "rgb", signs, level) for signs in SIGNS for level in LEVELS]
TABLE = [
    {
        "agent": agent,
        "sensor": sensor,
        "signs": signs,
        "difficulty": level,
        "episodes": 300,
        "success": spl + 0.05,
        "spl": spl - 0.1 * (level == "hard"),
        "success_125": 0.1,
        "success_250": 0.2,
        "paper_success": 0.43 if agent == "nts" else None,
        "paper_spl": 0.26 if agent == "nts" else None,
    }
    for agent, spl in SPL.items()
    for sensor in (("rgbd", "rgb") if agent == "nts" else ("rgbd",))
    for signs in SIGNS
    for level in LEVELS
]


def results(name, rows, notes):
    return Results({name: Report(name, 0, tuple(range(14)), False, 1.0, rows, tuple(notes))})


def test_choices_stand_beside_a_blind_score_and_another_sensor():
    head, *lines = cells(choices(CHOSEN))
    assert len(lines) == 6
    assert head[2:6] == ["F_S", "blind", "colours", "random"]
    gap = "+20.0 points (+10.0 to +30.0)"
    expected = ["plain", "easy", "80.0%", "60.0%", "40.0%", "20.0%", gap, gap, "80.0%"]
    assert lines[0] == expected
    text = exploring.SECTIONS[0].text(results("nts_scores", CHOSEN, ()))
    assert "600 decisions" not in text
    assert "300 decisions in 14 test worlds" in text


def test_the_best_agent_is_bold_and_bounds_take_no_part():
    _, *lines = cells(success_and_spl(TABLE, "plain"))
    assert [line[0] for line in lines[:2]] == ["NTS", "NTS, random scores"]
    assert len(lines) == len(SPL) + 1
    assert lines[0][2] == "**65.0% / 0.600**"
    assert lines[0][4] == "**65.0% / 0.500**"
    walk = next(line for line in lines if line[0] == "random walk")
    assert walk[2] == "75.0% / 0.700"
    assert lines[0][5] == ", ".join(["0.43 / 0.26"] * 3)
    assert lines[-1][:2] == ["NTS", "without depth"]
    _, mine, *_ = cells(in_time(TABLE, "plain"))
    assert mine == ["NTS", *["10.0% / 20.0% / 65.0%"] * 3]


def test_every_section_of_table1_has_its_differences():
    notes = [
        f"SPL, nts - {agent} (rgbd), {signs}, {level}: +0.1"
        for agent in ("fbe", "ans_like", "nts_no_score", "nts_blind")
        for signs in SIGNS
        for level in LEVELS
    ]
    text = exploring.SECTIONS[1].text(results("nts_table1", TABLE, notes))
    assert text.count("+0.1") == len(notes)
    assert "300 episodes of each difficulty" in text


def test_the_other_sections_read_their_reports():
    rows = [
        {"agent": agent, "signs": signs, "goals": goals, "episodes": 320, "success": 0.9}
        | {"spl": 0.7, "spl_gap": goals / 100}
        | {
            f"success_{key}": value
            for key, value in zip(("gap", "gap_low", "gap_high"), (0.1, 0.0, 0.2), strict=True)
        }
        for agent in ("nts", "nts_no_graph", "nts_no_score")
        for signs in SIGNS
        for goals in range(1, 11)
    ]
    text = returning.SECTIONS[0].text(results("nts_fig8", rows, ()))
    assert "NTS without a graph, plain: +0.010 to +0.100" in text
    rows = [
        {"method": method, "signs": signs, "goals": goals, "trials": 80, "success": 0.9}
        | {"low": 0.8, "high": 0.95, "spl": 0.7, "steps": 60.0, "recalled": 0.6}
        | GAIN
        for method in ("both", "memory", "explorer")
        for signs in SIGNS
        for goals in ("passed", "elsewhere", "all")
    ]
    text = returning.SECTIONS[1].text(results("nts_second_visit", rows, ("first visits took",)))
    assert text.count("+20.0 points") == 12
    assert "First visits took" in text
    rows = [{"agent": "nts", "model": "rgbd", "episodes": 64, "steps_per_s": 1_834.0}]
    assert "| NTS | network, with depth | 1,834 |" in speed.SECTIONS[-1].text(
        results("explore", rows, ())
    )
    named = {name for section in SECTIONS for name in section.sources}
    assert named == {f"nts_{name}" for name in EXPLORING}


def test_the_short_table_has_hard_goals_with_signs_and_without():
    rows = [row | {"success": row["success"] - 0.1 * (row["signs"] == "plain")} for row in TABLE]
    what, here, beside, paper = exploration(rows)
    assert what.endswith("with signs / without: NTS")
    assert (here, paper) == ("65.0% / 55.0% (SPL 0.50 / 0.50)", "43%, SPL 0.26")
    assert beside == (
        "nearest frontier 55.0% / 45.0% (SPL 0.40 / 0.40), learned choice of frontier 60.0% / "
        "50.0% (SPL 0.45 / 0.45), random walk 75.0% / 65.0% (SPL 0.60 / 0.60)"
    )
