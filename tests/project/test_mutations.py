"""The list of wrong changes fits the code, and `tests.mutate` tells what becomes of them."""

import ast
import re
import shlex
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from tests import mutate
from tests.mutate import BROKEN, KILLED, LIBRARY, STALE, SURVIVED, TESTS
from tests.mutations import Mutation, mutations

PROJECT = Path(__file__).resolve().parents[2]
ALL = mutations()


def named(mutation):
    return f"{mutation.file}: {mutation.what}"


@pytest.mark.parametrize("mutation", ALL, ids=named)
def test_a_change_can_be_made_and_leaves_code(mutation):
    text = (PROJECT / LIBRARY / mutation.file).read_text(encoding="utf-8")
    assert text.count(mutation.old) == 1, "update the old text in tests/mutations"
    assert mutation.old != mutation.new
    changed = ast.parse(text.replace(mutation.old, mutation.new))
    assert ast.dump(changed) != ast.dump(ast.parse(text))


@pytest.mark.parametrize("arguments", sorted({mutation.tests for mutation in ALL}))
def test_there_are_tests_for_it(arguments):
    file, *options = shlex.split(arguments)
    tree = ast.parse((PROJECT / TESTS / file).read_text(encoding="utf-8"))
    names = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    assert any(name.startswith("test_") for name in names)
    if options:
        assert options[:-1] == ["-k"]
        words = set(re.findall(r"\w+", options[-1])) - {"or", "and", "not"}
        assert any(word in name for word in words for name in names if name.startswith("test_"))


def test_changes_are_many_differ_and_are_spread_over_the_packages():
    assert len(ALL) >= 60
    assert len(set(map(named, ALL))) == len(ALL)
    packages = Counter(mutation.file.split("/")[0] for mutation in ALL)
    folders = [file.name for file in (PROJECT / LIBRARY).iterdir() if file.name in packages]
    assert all(packages[folder] >= 5 for folder in folders if (PROJECT / LIBRARY / folder).is_dir())
    assert max(packages.values()) < 0.25 * len(ALL)


SUM = """def total(values):
    sum_ = 0
    for value in values:
        sum_ += value
    return sum_
"""
CHECK = """from tutorial_lib.total import total

def test_total():
    assert total([1, 2]) == 3
"""


@pytest.fixture
def small(tmp_path):
    """A project with a function and a test."""
    for name, text in {
        "tutorial_lib/__init__.py": "",
        "tutorial_lib/total.py": SUM,
        "tests/test_total.py": CHECK,
        ".gitignore": "ignored\n",
        "ignored": "",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    if subprocess.run(["git", "init", "-q", tmp_path], check=False).returncode:
        pytest.skip("git does not answer")
    return tmp_path


def change(old, new, tests="test_total.py"):
    return Mutation(f"{old} to {new}", "total.py", old, new, tests)


def test_each_change_gets_its_verdict_and_is_undone(small, capsys):
    changes = [
        change("+= value", "-= value"),
        change("sum_ = 0", "sum_ = 0.0"),
        change("sum_", "summe"),
        change("no such text", ""),
        change("def total", "def totals"),
        change("+= value", "-= value", "test_total.py -k nothing"),
    ]
    found = mutate.run(small, changes[:-1], jobs=2, options=())
    assert found == [KILLED, SURVIVED, STALE, STALE, BROKEN]
    assert "sum_ = 0 to sum_ = 0.0" in capsys.readouterr().out
    with pytest.raises(SystemExit, match="does not pass before anything is changed"):
        mutate.run(small, changes[-1:], options=())
    assert (small / "tutorial_lib/total.py").read_text() == SUM
    copy = small / "copy"
    mutate.copy_project(small, copy)
    assert not (copy / "ignored").exists()
    assert mutate.try_out(copy, changes[0], small / "cache", options=()) == KILLED
    assert (copy / "tutorial_lib/total.py").read_text() == SUM


def test_tests_that_never_end_are_stopped(small, monkeypatch):
    monkeypatch.setattr(mutate, "TIMEOUT", 3.0)
    endless = change("sum_ += value", "values.append(1)")
    assert mutate.try_out(small, endless, small / "cache", options=()) == KILLED


@pytest.mark.parametrize(
    ("verdicts", "code"),
    [
        ([KILLED] * 19 + [SURVIVED], 0),
        ([KILLED] * 18 + [SURVIVED] * 2, 1),
        ([KILLED] * 99 + [STALE], 1),
        ([KILLED] * 99 + [BROKEN], 1),
    ],
)
def test_more_than_one_survivor_in_twenty_is_a_failure(verdicts, code):
    line, found = mutate.summary(verdicts)
    assert found == code
    assert line.startswith(f"{len(verdicts)} changes: {verdicts.count(KILLED)} killed, ")


def test_changes_are_listed_and_chosen(capsys):
    assert mutate.main(["--list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(ALL)
    assert mutate.main(["--list", "--only", "world/noise.py"]) == 0
    assert capsys.readouterr().out.startswith("world/noise.py: ")
    with pytest.raises(SystemExit):
        mutate.main(["--only", "no such change"])
