import functools
import math
import operator

import numpy as np
import pytest

from tutorial_lib.checks.framework import guard, my_answers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare

FACTOR = 2.0
TABLE = np.array([1.0, 2.0])
UNKNOWN = object()


def helper(x):
    return FACTOR * x + (helper(x - 1) if x > 1e9 else 0.0)


def doubled(x, table=TABLE):
    """Twice x."""
    return helper(x) + 0.0 * table[0] * math.cos(0.0) * np.sin(0.0)


def doubled_otherwise(x):
    return x + x


def doubled_from_afar(x):
    return x + x if UNKNOWN else x


def add(x, y):
    return x + y


sum_of = add


def by_another_name(x):
    return sum_of(x, x)


def reference(x):
    return 2 * x


@check(reference, (1.0,))
def check_doubled(student):
    """It doubles."""
    compare("doubled", student, {"two": (2.0,)}, reference, {})


def named(function):
    function.__name__ = "doubled"
    return function


def test_a_passed_answer_is_saved_with_all_that_it_needs(folder, capsys):
    assert check_doubled.use(doubled) is doubled
    assert "saved in my_answers/" in capsys.readouterr().out
    (file,) = folder.glob("*.py")
    text = file.read_text()
    assert text.startswith("# version 1 of doubled")
    assert "FACTOR = 2.0" in text
    assert "TABLE = np.array([1.0, 2.0])" in text
    assert text.index("def helper") < text.index("def doubled")
    assert "import math" in text
    again = my_answers.load(check_doubled.notebook, "doubled")
    assert again is not doubled
    assert again(2.0) == 4.0


def test_another_answer_takes_its_place_and_the_old_one_is_kept(folder):
    check_doubled.use(doubled)
    check_doubled.use(doubled)
    assert not (folder / "older").exists()
    check_doubled.use(named(doubled_otherwise))
    (file,) = folder.glob("*.py")
    assert file.read_text().startswith("# version 2 of doubled")
    (older,) = (folder / "older").glob("*_v1.py")
    assert "def helper" in older.read_text()


def test_wrong_answers_and_the_reference_are_not_saved(folder):
    check_doubled.use(lambda x: x)
    check_doubled.use(reference)
    assert not folder.exists()


def test_what_cannot_be_saved_passes_all_the_same(folder, capsys):
    assert check_doubled.use(doubled_from_afar) is doubled_from_afar
    assert "could not be saved" in capsys.readouterr().out
    folder.write_text("a file where the folder should be")
    assert check_doubled.use(doubled) is doubled
    assert "could not be saved" in capsys.readouterr().out


def test_mine_is_the_saved_answer_or_the_librarys(folder, capsys):
    assert check_doubled.mine() is reference
    check_doubled.use(doubled)
    capsys.readouterr()
    assert check_doubled.mine()(3.0) == 6.0
    assert not capsys.readouterr().out
    (file,) = folder.glob("*.py")
    file.write_text("def doubled(x):\n    return x\n")
    assert check_doubled.mine() is reference
    assert "is used" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("doubled = 1 /\n", "does not run (SyntaxError"),
        ("raise ValueError('no')\n", "does not run (ValueError: no)"),
        ("import sys\nsys.exit(0)\n", "does not run (SystemExit: 0)"),
        ("import os\nos._exit(3)\n", "does not run (SystemExit: 3)"),
        ("while True:\n    pass\n", "has not ended after 0.3 seconds"),
        (
            "while True:\n    try:\n        while True: pass\n    except: pass\n",
            "has not ended after 0.3 seconds",
        ),
        ("def other(x):\n    return 2 * x\n", "defines no function doubled"),
        ("doubled = 2\n", "defines no function doubled"),
        ("def doubled(x):\n    raise SystemExit\n", "ends the program"),
        ("x = '\0'\n", "does not run"),
    ],
)
def test_nothing_in_a_saved_answer_stops_a_notebook(folder, capsys, monkeypatch, text, said):
    monkeypatch.setattr(guard, "SECONDS", 0.3)
    folder.mkdir()
    my_answers.path(check_doubled.notebook, "doubled").write_text(text)
    assert check_doubled.mine() is reference
    printed = capsys.readouterr().out
    assert said in printed
    assert "The library's doubled is used" in printed


def test_what_was_judged_is_saved_under_the_exercise_s_name(folder):
    check_doubled.use(doubled_otherwise)
    assert my_answers.load(check_doubled.notebook, "doubled")(2.5) == 5.0
    check_doubled.use(by_another_name)
    again = my_answers.load(check_doubled.notebook, "doubled")
    assert again(2.5) == 5.0
    assert again.__globals__["sum_of"](1, 2) == 3


def closed_over(factor):
    def doubled(x):
        return factor * x

    return doubled


@pytest.mark.parametrize(
    ("student", "said"),
    [
        (closed_over(2), "uses factor of the function around it"),
        (lambda x: 2 * x, "write it with def"),
        (functools.partial(operator.mul, 2), "write it with def"),
    ],
    ids=["closure", "lambda", "partial"],
)
def test_what_a_file_could_not_define_is_not_saved(folder, capsys, student, said):
    assert check_doubled.use(student) is student
    assert said in capsys.readouterr().out
    assert my_answers.load(check_doubled.notebook, "doubled") is None


def test_a_name_that_stands_for_two_things_is_not_saved(folder, capsys):
    def calls_itself(x):
        return doubled(x)

    assert check_doubled.use(calls_itself) is calls_itself
    assert "two different things in it are called doubled" in capsys.readouterr().out


def test_without_a_folder_nothing_is_kept(monkeypatch, tmp_path):
    monkeypatch.setenv(my_answers.FOLDER, "")
    monkeypatch.chdir(tmp_path)
    assert check_doubled.use(doubled) is doubled
    assert my_answers.load("00", "doubled") is None
    assert list(tmp_path.iterdir()) == []
