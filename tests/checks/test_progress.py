import json
from pathlib import Path

import pytest

from tutorial_lib.checks.framework import my_answers, record
from tutorial_lib.checks.progress import progress, report
from tutorial_lib.cli import main
from tutorial_lib.errors import InputError

PROJECT = Path(__file__).resolve().parents[2]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "mine").mkdir()
    monkeypatch.setenv(my_answers.FOLDER, str(tmp_path / "mine"))
    for stem, names in (("01_one", ["a", "b"]), ("02_two", ["c"])):
        cells = [{"metadata": {"exercise": name}} for name in names] + [{"metadata": {}}]
        (tmp_path / f"{stem}.ipynb").write_text(json.dumps({"cells": cells}))
    return tmp_path


def test_an_exercise_is_done_when_its_answer_is_saved(folder):
    (folder / "mine" / "01_b.py").write_text(
        "# version 3 of b, notebook 01: passed its check on 2030-01-02 10:00\n\nx = 1\n"
    )
    (folder / "mine" / "02_a.py").write_text("another notebook's\n")
    found = progress(folder)
    assert {
        notebook: [(one.name, bool(one.passed)) for one in own] for notebook, own in found.items()
    } == {
        "01_one": [("a", 0), ("b", 1)],
        "02_two": [("c", 0)],
    }
    text = report(found)
    assert "01_one: 1 of 2" in text
    assert "02_two: 0 of 1" in text
    assert "2030-01-02 10:00, version 3" in text
    assert text.endswith("1 of 3 exercises are done")


def test_missing_and_damaged_notebooks_are_named(folder):
    with pytest.raises(InputError, match="no notebooks"):
        progress(folder / "mine")
    (folder / "02_two.ipynb").write_text("{")
    with pytest.raises(InputError, match="02_two"):
        progress(folder)


@pytest.mark.parametrize("name", ["x" * 300, "../up", "a b", "", 3, [0.0] * 1000, None])
def test_what_is_no_function_is_no_exercise(folder, name):
    cells = [{"metadata": {"exercise": name}}]
    (folder / "02_two.ipynb").write_text(json.dumps({"cells": cells}))
    with pytest.raises(InputError, match=r"02_two.*is no function\); restore it") as error:
        progress(folder)
    assert len(str(error.value)) < len(str(folder)) + 120


def test_the_command_lists_the_exercises_of_the_course(capsys):
    assert main(["progress"]) == 0
    said = capsys.readouterr().out
    assert "01_world_and_car: 0 of" in said
    assert "- to_local" in said


def test_predictions_are_counted_and_never_among_the_exercises(folder):
    record.keep_prediction("01", "trip", "A", "B")
    record.keep_prediction("01", "way", "C", "C")
    text = report(progress(folder))
    assert "01_one: 0 of 2" in text
    assert "  predictions: 2 made, 1 right" in text
    assert text.count("predictions") == 1


def test_predictions_count_where_there_is_no_exercise(folder):
    (folder / "00_start.ipynb").write_text(json.dumps({"cells": []}))
    record.keep_prediction("00", "trip", "A", "A")
    text = report(progress(folder))
    assert text.startswith("00_start: no exercises\n  predictions: 1 made, 1 right\n01_one: 0 of 2")
