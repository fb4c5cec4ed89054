import pytest

from tutorial_lib.checks.framework import my_answers
from tutorial_lib.checks.marking import all_checks, mark
from tutorial_lib.cli import main
from tutorial_lib.errors import InputError

RIGHT = """import numpy as np


def compose(first, second):
    cos, sin = np.cos(first[2]), np.sin(first[2])
    x = first[0] + cos * second[0] - sin * second[1]
    y = first[1] + sin * second[0] + cos * second[1]
    return np.array([x, y, np.angle(np.exp(1j * (first[2] + second[2])))])
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "01_compose.py").write_text(RIGHT)
    (tmp_path / "01_to_local.py").write_text("def to_local(pose, points):\n    return points\n")
    (tmp_path / "01_wall_share.py").write_text("def wall_share(:\n")
    (tmp_path / "01_unknown.py").write_text("x = 1\n")
    return tmp_path


def test_every_answer_is_judged_again(folder):
    results = {result.exercise: result for result in mark(folder)}
    assert {name: result.status for name, result in results.items()} == {
        "compose": "passed",
        "to_local": "failed",
        "wall_share": "failed",
    }
    assert "does not run" in results["wall_share"].message


def test_the_command_marks_several_students(folder, tmp_path, capsys):
    assert main(["mark", str(folder), str(folder)]) == 0
    said = capsys.readouterr().out
    assert said.count("1 of 3 pass") == 2
    assert "compose: passed" in said
    (tmp_path / "empty").mkdir()
    assert main(["mark", str(tmp_path / "empty")]) == 2
    with pytest.raises(InputError, match="no answers"):
        list(mark(tmp_path / "empty"))


def test_what_the_checks_save_can_be_marked(tmp_path, monkeypatch):
    monkeypatch.setenv(my_answers.FOLDER, str(tmp_path))
    checks = {check.name: check for check in all_checks()}
    assert len(checks) > 20
    check = checks["compose"]
    (tmp_path / "source.py").write_text(RIGHT)
    check.use(my_answers.read(tmp_path / "source.py", "compose"))
    assert [result.status for result in mark(tmp_path)] == ["passed"]
