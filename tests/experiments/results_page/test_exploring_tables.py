"""Tables of exploration, from made-up rows."""

from itertools import product

import pytest

from tests.experiments.results_page.tables import cells, section
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import CHANGE, Finding, Report
from tutorial_lib.experiments.nts import second_visit
from tutorial_lib.experiments.nts.scores import PAIRS, SCORES
from tutorial_lib.experiments.results_page import exploring, speed
from tutorial_lib.experiments.results_page.exploring import choices, in_time, table_1
from tutorial_lib.experiments.results_page.page import block_of
from tutorial_lib.experiments.results_page.sources import EXPLORING, Results, load_results
from tutorial_lib.experiments.results_page.templates import render_chapter

LEVELS = ("easy", "medium", "hard")
SIGNS = ("plain", "wayfinding")
SPL = {"nts": 0.6, "fbe": 0.5, "ans_like": 0.55, "nts_no_score": 0.4, "nts_blind": 0.45}
SPL |= {"il": 0.1, "random": 0.7, "oracle": 0.95}
RL_SPL = {"target_rl": 0.3, "map_rl": 0.35}
GAIN = {"gain": 0.2, "gain_low": 0.1, "gain_high": 0.3}
LESS = {"easy": 0.0, "medium": 0.02, "hard": 0.1}
OTHER_GAIN = {"gain": 0.4, "gain_low": 0.3, "gain_high": 0.5}


def chosen(score, sensor, signs, difficulty, pairs):
    top1 = {"semantic": 0.8, "masked": 0.7, "blind": 0.6, "histogram": 0.4, "random": 0.2}[score]
    top1 -= LESS[difficulty] + 0.03 * (sensor == "rgb") + 0.05 * (signs == "plain")
    row = {"score": score, "sensor": sensor, "signs": signs, "difficulty": difficulty}
    row |= {"pairs": pairs}
    row |= {
        "decisions": 100 if pairs == "all" else 80,
        "top1": top1,
        "low": top1 - 0.01,
        "high": top1 + 0.01,
    }
    return row | (OTHER_GAIN if score == "histogram" else GAIN)


CHOSEN = [chosen(*key) for key in product(SCORES, ("rgbd",), SIGNS, LEVELS, PAIRS)] + [
    chosen("semantic", "rgb", *key) for key in product(SIGNS, LEVELS, PAIRS)
]


def table(found):
    """Made-up rows of Table 1, by the SPL of each agent."""
    return [
        {
            "agent": agent,
            "sensor": sensor,
            "signs": signs,
            "difficulty": level,
            "episodes": 300,
            "success": spl + 0.05 - LESS[level],
            "spl": spl - LESS[level] - 0.03 * (sensor == "rgb") - 0.05 * (signs == "wayfinding"),
            "success_125": 0.1 - LESS[level] / 2,
            "success_250": 0.2 - LESS[level] / 2,
            "paper_success": 0.43 - LESS[level] if agent == "nts" else None,
            "paper_spl": 0.26 - LESS[level] if agent == "nts" else None,
        }
        for agent, spl in found.items()
        for sensor in (("rgbd", "rgb") if agent == "nts" else ("rgbd",))
        for signs in SIGNS
        for level in LEVELS
    ]


TABLE = table(SPL)


def results(name, rows, notes=(), findings=()):
    worlds = tuple(range(14))
    return Results({name: Report(name, 0, worlds, False, 1.0, rows, tuple(notes), tuple(findings))})


def both_tables(findings=()):
    """The reports on Table 1, with those who learn by reinforcement in one of their own."""
    found = results("nts_table1", TABLE, findings=findings).reports
    learned = [
        row | {"condition": condition, "spl": row["spl"] * share}
        for row in table(RL_SPL)
        for condition, share in (("standard", 1.0), ("no_stop", 0.0))
    ]
    return Results(found | results("nts_table2_rl", learned).reports)


def text_of(title, found):
    """The text of a section of the chapter."""
    return section(exploring, title, found).text


def test_choices_stand_beside_a_blind_score_and_another_sensor():
    head, *lines = cells(choices(CHOSEN))
    assert len(lines) == 12
    assert head[4:9] == ["F_S", "masked", "blind", "colours", "random"]
    shares = ["65.0% (64.0 to 66.0)", "55.0%", "45.0%", "25.0%", "5.0%"]
    gaps = ["+20.0 points (+10.0 to +30.0)"] * 2 + ["+40.0 points (+30.0 to +50.0)"]
    assert lines[2] == ["unconnected", "plain", "hard", "80", *shares, *gaps, "62.0%"]
    assert lines[10][:4] == ["all", "wayfinding", "medium", "100"]
    assert lines[10][4] == "78.0% (77.0 to 79.0)"
    text = text_of("Scores of directions", results("nts_scores", CHOSEN, ()))
    assert "600 decisions" not in text
    assert "300 decisions in 14 test worlds" in text
    assert "those 240 *unconnected* pairs come first" in text


def test_the_best_agent_is_bold_and_bounds_take_no_part():
    _, *lines = cells(table_1(both_tables(), "plain"))
    assert [line[0] for line in lines[:2]] == ["NTS", "NTS, random scores"]
    assert len(lines) == len(SPL) + 1 + 2 + 1  # those of reinforcement learning, and one without
    learned = [line for line in lines if line[0] in exploring.RL.values()]
    assert [line[1:3] for line in learned] == [
        ["with depth", "35.0% / 0.300"],
        ["with depth", "40.0% / 0.350"],
        ["without depth", exploring.NOT_HERE],
    ]
    assert learned[2][5] == "0.56 / 0.22, 0.17 / 0.06, 0.06 / 0.02"
    assert lines[0][2:5] == ["**65.0% / 0.600**", "**63.0% / 0.580**", "**55.0% / 0.500**"]
    walk = next(line for line in lines if line[0] == "random walk")
    assert walk[2] == "75.0% / 0.700"
    assert lines[0][5] == "0.87 / 0.65, 0.58 / 0.38, 0.43 / 0.26"
    assert lines[-2][:3] == ["NTS", "without depth", "65.0% / 0.570"]
    _, mine, *_ = cells(in_time(TABLE, "plain"))
    spread = ["10.0% / 20.0% / 65.0%", "9.0% / 19.0% / 63.0%", "5.0% / 15.0% / 55.0%"]
    assert mine == ["NTS", *spread]


def test_the_curves_of_all_policies_stand_side_by_side():
    first, second = (
        [
            {"steps": 1_000.0 * number}
            | {
                f"{part}success_{d}": (share + number) / 100
                for d in LEVELS
                for part in ("", "training_")
            }
            for number in (1, 2)
        ]
        for share in (10, 20)
    )
    second[1]["success_hard"] = 0.99
    head, *lines = cells(exploring.learning({"target_rl": first, "map_rl": second}))
    assert head[:3] == ["frames", "target-driven RL, training", "target-driven RL, unseen"]
    assert lines[0] == ["1,000", *["11% / 11% / 11%"] * 2, *["21% / 21% / 21%"] * 2]
    assert lines[1][3:] == ["22% / 22% / 22%", "22% / 22% / 99%"]


def test_every_section_of_table1_has_its_differences():
    others = ("fbe", "ans_like", "nts_no_score", "nts_blind")
    gaps = [
        Finding(f"SPL, nts (rgbd) - {agent} (rgbd), {signs}, {level}", number / 100, form=CHANGE)
        for number, (agent, signs, level) in enumerate(product(others, SIGNS, LEVELS))
    ]
    text = text_of("Table 1: image-goal navigation", both_tables(gaps))
    assert "| nearest frontier | wayfinding | +0.030 | +0.040 | +0.050 |" in text
    assert "| NTS, scores blind to the goal | plain | +0.180 | +0.190 | +0.200 |" in text
    assert "300 episodes of each difficulty" in text


def test_cars_stand_beside_round_robots():
    cars = [
        row | {"success": row["success"] + 0.01, "spl": row["spl"] - 0.1}
        for row in TABLE
        if row["sensor"] == "rgbd" and row["agent"] in ("nts", "fbe")
    ]
    both = results("nts_table1", TABLE).reports
    both |= results("nts_table1_car", cars, ("3 of 9 cars were turned at their starts",)).reports
    text = text_of("Table 1 with a car", Results(both))
    assert "3 of 9 cars were turned at their starts, where they did not fit" in text
    assert "| plain | NTS | 66.0% / 0.500 | 65.0% / 0.600 | 64.0% / 0.480 | 63.0%" in text
    assert "NTS in a car succeeds in 64.0% and the round robot in 63.0%" in text
    assert "(SPL 0.480 and 0.580)" in text


def test_table2_says_what_is_gained_where_a_difficulty_is_taken_away():
    conditions, reports = ("standard", "no_stop", "no_noise"), {}
    agents = {"nts_table2": ("nts", "fbe", "ans_like", "il"), "nts_table2_rl": tuple(exploring.RL)}
    for name, those in agents.items():
        runs = list(enumerate(product(those, SIGNS, conditions)))
        rows = [
            {"agent": agent, "signs": signs, "condition": condition, "difficulty": level}
            | {"episodes": 300, "success": 0.5 + 0.01 * number if level == "overall" else 0.1}
            for number, (agent, signs, condition) in runs
            for level in (*LEVELS, "overall")
        ]
        gains = [
            Finding(f"{agent}, {signs}: {condition} - standard", number / 100)
            for number, (agent, signs, condition) in runs
            if condition != "standard"
        ]
        reports |= results(name, rows, findings=gains).reports
    text = text_of("Table 2: stopping and noise", Results(reports))
    for line in (
        "| nearest frontier | plain | 56.0% | 57.0% | 58.0% | +7.0 points | +8.0 points |",
        "| nearest frontier | the paper | 42% | 56% | 49% | +14.0 points | +7.0 points |",
        "| NTS | the paper | 63% | 75% | 64% | +12.0 points | +1.0 points |",
        "| metric map and RL | the paper | 34% | 52% | 35% | +18.0 points | +1.0 points |",
        "| metric map and RL | plain | 56.0% | 57.0% | 58.0% | +7.0 points | +8.0 points |",
        "| target-driven RL | wayfinding | 53.0% | 54.0% | 55.0% | +4.0 points | +5.0 points |",
    ):
        assert line in text
    assert "300 episodes of each difficulty" in text


def test_the_other_sections_read_their_reports():
    rows = [
        {"agent": agent, "signs": signs, "goals": goals, "episodes": 320, "success": 0.9}
        | {"spl": 0.7, "spl_gap": goals / 100, "success_gap": -0.02 * goals}
        | {"success_gap_low": -0.3, "success_gap_high": 0.1}
        for agent in ("nts", "nts_no_graph", "nts_no_score")
        for signs in SIGNS
        for goals in range(1, 11)
    ]
    text = text_of("Fig. 8: goals one after another", results("nts_fig8", rows))
    ends = "-2.0 points (-30.0 to +10.0) | -20.0 points (-30.0 to +10.0) | +0.010 | +0.100 |"
    assert f"| NTS without a graph | plain | grows | {ends}" in text
    assert f"| NTS, random scores | wayfinding | shrinks | {ends}" in text
    assert "without a graph is ahead by 20.0 points" in text
    rows = [
        {"method": method, "signs": signs, "goals": goals, "trials": 80, "success": 0.9}
        | {"low": 0.8, "high": 0.95, "spl": 0.7, "steps": 60.0, "recalled": 0.6}
        | GAIN
        for method in ("both", "memory", "explorer")
        for signs in SIGNS
        for goals in ("passed", "elsewhere", "all")
    ]
    text = text_of("A second visit", results("nts_second_visit", rows, ("first visits took",)))
    assert text.count("+20.0 points") == 12
    assert tuple(exploring.METHODS) == second_visit.METHODS
    assert "First visits took" in text
    rows = [
        {"figure": figure, "world": f"office/{world}/standard/wayfinding", "what": goal}
        | {"chosen": ghost, "best": 5, "success": ghost != 3, "travelled": 7.25}
        for figure in (4, 10)
        for world, ghosts in (("20000", (4, 4)), ("20001", (3, 5)))
        for goal, ghost in zip(("kitchen", "bathroom"), ghosts, strict=True)
    ]
    text = text_of("Figs. 3, 4, 9 and 10: examples", results("nts_figs", rows))
    assert text.count("| office 20000 | kitchen | 4 | 5 | 7.2 m |") == 1
    assert "| office 20001 | kitchen | 3 | 5 | missed |" in text
    assert "Here they do in 1 of 2." in text
    rows = [{"agent": "nts", "model": "rgbd", "episodes": 64, "steps_per_s": 1_834.0}]
    assert "| NTS | network, with depth | 1,834 |" in speed.exploration(rows)
    _, sections = render_chapter(load_results(), exploring)
    named = {name for found in sections for name in found.sources}
    assert named == {
        f"nts_{name}" for name in (*EXPLORING, "table1_car", "table1_rules", "table2_rl")
    }


RULES = [
    {"agent": agent, "signs": signs, "difficulty": level, "episodes": 120}
    | {"success": 0.9 - LESS[level] - number / 20, "spl": 0.8 - LESS[level]}
    for number, agent in enumerate(exploring.RULES)
    for signs in SIGNS
    for level in LEVELS
]
RULE_GAPS = [
    Finding(f"SPL, nts (rgbd) - {agent} (rgbd), {signs}, {level}", number / 100, form=CHANGE)
    for number, (agent, signs, level) in enumerate(product([*exploring.RULES][1:], SIGNS, LEVELS))
]


def with_rules(rows):
    """The stored reports, but that on the rules of the paper."""
    found = results("nts_table1_rules", rows, findings=RULE_GAPS)
    return Results(load_results().reports | found.reports)


def test_rules_of_the_paper_stand_beside_the_course_s():
    text = text_of("Rules of the paper", with_rules(RULES))
    course = "| the course's | plain | 90.0% / 0.800 | 88.0% / 0.780 | 80.0% / 0.700 |  |  |  |"
    masked = "| 85.0% / 0.800 | 83.0% / 0.780 | 75.0% / 0.700 | +0.030 | +0.040 | +0.050 |"
    assert course in text
    assert f"| F_S masked | wayfinding {masked}" in text
    assert "60% / 60% of the hard goals are found (plain / wayfinding), with one 80% / 80%" in text
    assert "better on medium goals in plain worlds: +0.010." in text


def test_rules_beyond_the_paper_keep_a_sentence():
    text = text_of("Rules of the paper", with_rules(RULES))
    assert "over ten goals: -0.017 (-0.030 to -0.007)" in text
    assert "78% / 92% of the hard goals are found instead of 71% / 88%" in text
    assert "only 89% / 91% of ten goals one after another, instead of 92% / 96%" in text


def test_a_section_names_the_reports_that_may_be_damaged():
    names = r"nts_table1_rules\.json, .*: damaged.*--ablation rules.*; restore it"
    with pytest.raises(InputError, match=names):
        text_of("Rules of the paper", with_rules(RULES[:-1]))


def test_the_short_table_has_hard_goals_with_signs_and_without():
    rows = [row | {"success": row["success"] - 0.1 * (row["signs"] == "plain")} for row in TABLE]
    stored = load_results().reports
    block = block_of(Results(stored | results("nts_table1", rows).reports))
    (line,) = [line for line in block.splitlines() if line.startswith("| a picture 5")]
    what, here, beside, paper = (cell.strip() for cell in line.strip("|").split(" | "))
    assert what.endswith("with signs / without: NTS")
    assert (here, paper) == ("55.0% / 45.0% (SPL 0.45 / 0.50)", "33%, SPL 0.16")
    assert beside == (
        "nearest frontier 45.0% / 35.0% (SPL 0.35 / 0.40), learned choice of frontier 50.0% / "
        "40.0% (SPL 0.40 / 0.45), random walk 65.0% / 55.0% (SPL 0.55 / 0.60)"
    )
