"""What notebook 07 says of Fig. 12's remedies is what was measured.

The notebook prints its numbers from the report and says the rest in words. Where a test fails after
a new measurement, the sentence has to be thought over.
"""

from pathlib import Path

import pytest

from tutorial_lib.experiments import load_result

PROJECT = Path(__file__).resolve().parents[3]
TEXT = (PROJECT / "solutions" / "07_aliasing.py").read_text(encoding="utf-8")
REMEDIES = load_result("meng_fig12")
ROWS = {row["remedy"]: row for row in REMEDIES.rows}
CASES = {row["case"]: row for row in load_result("meng_fig12_localization").rows}


def missed(remedy):
    return ROWS["all"]["success"] - ROWS[f"no_{remedy}"]["success"]


def compared(key, one, other):
    return ROWS[one][key] / ROWS[other][key]


def wormholes(remedy):
    return ROWS[remedy]["wormholes"] / ROWS[remedy]["edges"]


SENTENCES = {
    f"Here are {ROWS['all']['trials']} in ten offices": len(REMEDIES.worlds) == 10,
    "replanning is missed most, then the filter, then sequences": (
        missed("replan") > missed("filter") > missed("sequence") > 0
    ),
    "With sequences it can, and drops a plan that began in the wrong room": (
        ROWS["no_replan"]["low"] > ROWS["none"]["high"]
    ),
    "the other three together do worse than replanning alone": (
        ROWS["no_filter"]["high"] < ROWS["replan"]["low"]
    ),
    "more of their trips run out of time": ROWS["no_filter"]["late"] > ROWS["replan"]["late"],
    "Without counting, about one robot in a hundred circles, and with it none": (
        0.005 < ROWS["no_cycles"]["circled"] < 0.015 < 0.02 < ROWS["replan"]["circled"]
        and ROWS["all"]["circled"] == 0
    ),
    "Plans around what was visited are longer": ROWS["all"]["late"] > ROWS["no_cycles"]["late"],
    "one in thirteen ran out of time": 1 / 14 < ROWS["all"]["late"] < 1 / 12,
    "One edge in five is a wormhole even with sequences": 0.15 < wormholes("sequence") < 0.25,
    "the <i>number</i> of wormholes hardly falls": (
        0.9 < compared("wormholes", "sequence", "none") < 1
    ),
    "four times as many vertices": 3.5 < compared("vertices", "sequence", "none") < 4.5,
    "where the robot is sure of its place, it's right in 94% of the steps": (
        round(CASES["driven"]["right_if_sure"], 2) == 0.94
    ),
    "even where it's sure, only in six of ten": 0.55 < CASES["doors"]["right_if_sure"] < 0.65,
    "it's right in about half of the steps": 0.45 < CASES["doors"]["right"] < 0.6,
}


@pytest.mark.parametrize("sentence", SENTENCES)
def test_the_notebook_says_what_was_measured(sentence):
    assert sentence in TEXT
    assert SENTENCES[sentence]


def interval(difference):
    """The bounds, in points, that the report has for a difference."""
    found = REMEDIES.finding(difference)
    return 100 * found.low, 100 * found.high


def test_one_remedy_alone_helps_and_three_do_nothing():
    assert interval("replan - none")[0] > 0
    for name in ("sequence", "cycles", "filter"):
        low, high = interval(f"{name} - none")
        assert low <= 0 <= high
    low, high = interval("no_cycles - all")
    assert low < 0 < high  # not missed
