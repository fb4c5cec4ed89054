import json

import pytest

from tutorial_lib.checks import robot
from tutorial_lib.checks.framework import my_answers, record
from tutorial_lib.errors import InputError

pytestmark = pytest.mark.usefixtures("folder")


def test_the_robot_has_the_name_that_it_was_given_last():
    assert robot.robot_name() == robot.DEFAULT
    assert robot.name_robot("  Dot ") == "Dot"
    assert robot.name_robot("Kröte 2") == "Kröte 2"
    assert robot.robot_name() == "Kröte 2"


def test_the_name_stands_beside_what_else_is_kept(folder):
    record.keep_prediction("00", "photo", "A", "B")
    robot.name_robot("Dot")
    record.keep_prediction("00", "twins", "C", "C")
    known = json.loads((folder / record.FILE).read_text())["00"]
    assert known["robot"] == "Dot"
    assert list(known["predictions"]) == ["photo", "twins"]


@pytest.mark.parametrize("name", ["", "   ", "D\not", "x" * 21, 7, None])
def test_what_is_no_name_is_refused(folder, name):
    with pytest.raises(InputError, match="name"):
        robot.name_robot(name)
    assert not folder.exists()


def test_a_damaged_name_is_reported(folder):
    folder.mkdir()
    (folder / record.FILE).write_text('{"00": {"robot": ["Dot"]}}')
    with pytest.raises(InputError, match="damaged"):
        robot.robot_name()


def test_where_no_answers_are_kept_no_name_is(monkeypatch):
    monkeypatch.setenv(my_answers.FOLDER, "")
    assert robot.name_robot("Dot") == "Dot"
    assert robot.robot_name() == robot.DEFAULT
