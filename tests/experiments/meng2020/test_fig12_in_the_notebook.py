"""What notebook 07 says of Fig. 12's remedies is what was measured.

After a new measurement: write into the notebook what the failing test shows. Where the failing one
is `test_what_is_said_without_numbers_holds`, the sentence has to be thought over.
"""

import re
from pathlib import Path

import pytest

from tutorial_lib.experiments import load_result

PROJECT = Path(__file__).resolve().parents[3]
TEXT = (PROJECT / "solutions" / "07_aliasing.py").read_text(encoding="utf-8")
REMEDIES = load_result("meng_fig12")
ROWS = {row["remedy"]: row for row in REMEDIES.rows}
CASES = {row["case"]: row for row in load_result("meng_fig12_localization").rows}


def percent(remedy, key="success"):
    return f"{100 * ROWS[remedy][key]:.0f}"


def missed(remedy):
    return f"{100 * (ROWS['all']['success'] - ROWS[f'no_{remedy}']['success']):.0f}"


def share(remedy):
    return f"{100 * ROWS[remedy]['wormholes'] / ROWS[remedy]['edges']:.0f}"


def case(name, key):
    return f"{100 * CASES[name][key]:.0f}"


TRIALS = ROWS["all"]["trials"]
SENTENCES = [
    f"the same trials in ten offices, {TRIALS} in all",
    f"Alone</i>, only <code>replan</code> helps, and much: from {percent('none')} to "
    f"{percent('replan')} %.",
    f"that is how {percent('none', 'gave_up')} % of the trials of <code>none</code> end.",
    f"without replanning, the three reach {percent('no_replan')} %:",
    f"The other {percent('no_replan', 'gave_up')} % still give up.",
    f"replanning is missed most ({missed('replan')} points), then the filter ({missed('filter')}), "
    f"then sequences ({missed('sequence')}).",
    f"sequences and cycles, reaches {percent('no_filter')} %, less than the {percent('replan')} % "
    f"of <code>replan</code> alone, and {percent('no_filter', 'late')} % of its trials are out of "
    f"time instead of {percent('replan', 'late')} %.",
    f"success is even {-int(missed('cycles'))} point higher, with an interval that holds zero",
    f"({percent('no_cycles', 'circled')} %, and {percent('replan', 'circled')} % with "
    "<code>replan</code> alone)",
    f"{percent('all', 'late')} % of the trials are out of time with it, "
    f"{percent('no_cycles', 'late')} % without.",
    f"with it no robot circled in {TRIALS} trials.",
    f"falls from {share('none')} % to {share('sequence')} %, but their number hardly does: "
    f"{ROWS['none']['wormholes']:,} become {ROWS['sequence']['wormholes']:,}.",
    f"and {ROWS['sequence']['edges']:,} edges instead of {ROWS['none']['edges']:,}.",
    f"localized within 2.5 m in {case('driven', 'right')} %, and where it is sure (a belief of 0.9 "
    f"of being there) in {case('driven', 'right_if_sure')} %; over the steps in such corridors in "
    f"{case('doors', 'right')} %, and where it is sure in {case('doors', 'right_if_sure')} %:",
]


@pytest.mark.parametrize("sentence", SENTENCES)
def test_the_notebook_says_what_was_measured(sentence):
    assert sentence in TEXT


def interval(difference):
    """The bounds, in points, that the report has for a difference."""
    note = next(note for note in REMEDIES.notes if note.startswith(f"{difference}: "))
    return tuple(map(float, re.search(r"\(([-+.\d]+) to ([-+.\d]+)\)", note).groups()))


def test_what_is_said_without_numbers_holds():
    assert len(REMEDIES.worlds) == 10
    assert interval("replan - none")[0] > 0
    for name in ("sequence", "cycles", "filter"):  # alone they do nothing
        low, high = interval(f"{name} - none")
        assert low <= 0 <= high
    low, high = interval("no_cycles - all")
    assert low < 0 < high  # not missed
    assert ROWS["all"]["circled"] == 0
    assert ROWS["no_filter"]["high"] < ROWS["replan"]["low"]
    assert float(missed("replan")) > float(missed("filter")) > float(missed("sequence"))
    assert 0.15 < ROWS["sequence"]["wormholes"] / ROWS["sequence"]["edges"] < 0.25  # one in five
    assert 3.5 < ROWS["all"]["vertices"] / ROWS["none"]["vertices"] < 4.5  # four times as many
    assert 0.9 < ROWS["sequence"]["wormholes"] / ROWS["none"]["wormholes"] < 1  # hardly falls
