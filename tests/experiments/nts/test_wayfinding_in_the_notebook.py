"""What notebook 09 says of the worth of a score is what was measured."""

from pathlib import Path

import pytest

from tutorial_lib.experiments import load_result
from tutorial_lib.experiments.nts.table1 import PAPER

PROJECT = Path(__file__).resolve().parents[3]
TEXT = (PROJECT / "solutions" / "09_ghost_nodes.py").read_text(encoding="utf-8")
ROWS = {
    (row["signs"], row["difficulty"], row["model"]): row
    for row in load_result("nts_wayfinding").rows
}

SCORED = {
    (row["signs"], row["difficulty"]): row
    for row in load_result("nts_scores").rows
    if (row["score"], row["pairs"]) == ("blind", "unconnected")
}


def worth(signs, difficulty):
    return f"{100 * SCORED[signs, difficulty]['gain']:.0f}"


def gain(signs, difficulty):
    return f"{100 * ROWS[signs, difficulty, 'goal']['gain']:.0f}"


def top(signs):
    return f"{100 * ROWS[signs, 'hard', 'goal']['top1']:.0f}"


SENTENCES = [
    f"knowing the goal gains {gain('plain', 'easy')} points on easy, {gain('plain', 'medium')} on "
    f"medium, and {gain('plain', 'hard')} on hard decisions",
    f"the gain is {gain('wayfinding', 'easy')} points, {gain('wayfinding', 'medium')} and "
    f"{gain('wayfinding', 'hard')}:",
    f"finds the best direction in {top('wayfinding')}% of cases in wayfinding buildings, and in "
    f"{top('plain')}% in plain ones",
    f"the goal is worth {worth('plain', 'easy')} to {worth('wayfinding', 'easy')} points, and on "
    f"medium ones {worth('plain', 'medium')} to {worth('wayfinding', 'medium')}:",
    f"with wayfinding accents it is worth {worth('wayfinding', 'hard')} points",
]


@pytest.mark.parametrize("sentence", SENTENCES)
def test_the_notebook_says_what_was_measured(sentence):
    assert sentence in TEXT


def test_what_is_said_without_numbers_holds():
    plain = ROWS["plain", "hard", "goal"]
    assert plain["gain_high"] < 0.03  # next to nothing
    assert ROWS["wayfinding", "hard", "goal"]["gain_low"] > plain["gain_high"]
    nts, next_best = PAPER["nts", "rgbd"], PAPER["ans_like", "rgbd"]
    ahead = [mine[0] - other[0] for mine, other in zip(nts, next_best, strict=True)]
    assert ahead == sorted(ahead)  # the advantage is largest on hard episodes


def test_a_whole_search_needs_to_see_the_goal():
    """A sentence without numbers, beside the choice for which the goal is worth nothing."""
    found = {
        row["agent"]: row["success"]
        for row in load_result("nts_table1").rows
        if (row["signs"], row["difficulty"], row["sensor"]) == ("plain", "hard", "rgbd")
    }
    assert "the library's agent finds about three in four; with the blind scores" in TEXT
    assert "it finds little more than half" in TEXT
    assert 0.7 < found["nts"] < 0.8
    assert 0.5 < found["nts_blind"] < 0.6


def test_a_graph_saves_metres_and_a_score_finds_goals():
    rows = {(row["signs"], row["agent"], row["goals"]): row for row in load_result("nts_fig8").rows}

    def ahead(key, signs, other, goals):
        return rows[signs, "nts", goals][key] - rows[signs, other, goals][key]

    assert "the graph is worth some 0.03 to 0.06 of SPL" in TEXT
    for signs in ("plain", "wayfinding"):
        assert all(0.025 < ahead("spl", signs, "nts_no_graph", n) < 0.075 for n in (1, 10))
        assert abs(ahead("success", signs, "nts_no_graph", 10)) < 0.03  # about as many
        worse = [ahead("success", signs, "nts_no_score", n) for n in (1, 5, 10)]
        assert worse == sorted(worse)
    assert ahead("spl", "plain", "nts_no_graph", 10) > ahead("spl", "plain", "nts_no_graph", 1)
