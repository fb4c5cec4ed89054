import numpy as np
import pytest

from tutorial_lib.checks.framework import my_answers, record
from tutorial_lib.checks.league import League
from tutorial_lib.errors import InputError

COLUMNS = {"paths": "d", "wormholes": "d", "score": "d"}
BASELINES = {"the paper's": (24, 5, -1), "none": (7, 1, 2)}


pytestmark = pytest.mark.usefixtures("folder")


def names(table):
    return [row[0] for row in table.rows]


def test_the_best_stands_first_and_the_best_baseline_is_to_be_beaten():
    league = League("05", COLUMNS, BASELINES)
    assert league.table().caption == "to beat: none, 2"
    assert names(league.table()) == ["none", "the paper's"]
    shown = league.enter("mine", (np.int64(20), 3, 5))
    assert names(shown) == ["mine", "none", "the paper's"]
    assert shown.caption == "you lead by 3"
    assert names(league.enter("worse", (9, 4, -11)))[-1] == "worse"


def test_rows_are_kept_once_and_come_back(folder):
    for _ in range(2):
        League("05", COLUMNS, BASELINES).enter("mine", (20, 3, 5))
    assert record.scores("05") == [["mine", 20, 3, 5]]
    assert names(League("05", COLUMNS, BASELINES).table()) == ["mine", "none", "the paper's"]
    assert [path.name for path in folder.iterdir()] == [record.FILE]


def test_rows_of_other_columns_and_notebooks_are_left_out():
    record.keep_score("05", ["old", 1])
    record.keep_score("06", ["other", 1, 2, 3])
    assert League("05", COLUMNS, BASELINES).rows == []


def test_where_nothing_is_kept_a_league_lives_as_long_as_the_notebook(monkeypatch):
    monkeypatch.setenv(my_answers.FOLDER, "")
    league = League("05", COLUMNS, BASELINES)
    assert names(league.enter("mine", (20, 3, 5)))[0] == "mine"
    assert League("05", COLUMNS, BASELINES).rows == []


def test_a_row_has_a_number_for_each_column():
    with pytest.raises(InputError, match="mine: 2 numbers; give 3"):
        League("05", COLUMNS, BASELINES).enter("mine", (1, 2))
    with pytest.raises(InputError, match="none: 1 numbers; give 3"):
        League("05", COLUMNS, {"none": (1,)})
