"""The pages for who changes the library: their examples run, and what they name is there."""

import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from tests.project.test_layers import LAYERS
from tutorial_lib.agents import MengAgent
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.interfaces import Plan

PROJECT = Path(__file__).resolve().parents[2]
PAGES = {
    name: (PROJECT / ".github" / name).read_text(encoding="utf-8")
    for name in ("ARCHITECTURE.md", "CONTRIBUTING.md")
}
EXAMPLES = re.findall(r"```python\n(.*?)```", PAGES["CONTRIBUTING.md"], re.DOTALL)
NEW = ("arc_length.py", "bold.py", "text_map.py", "drift.py", "test_drift.py", "drift.json")
"""Files of the examples, which are not in the project."""


def example(number, name, monkeypatch):
    """The names of an example, run as a module, which dataclasses look up."""
    module = ModuleType(name)
    monkeypatch.setitem(sys.modules, name, module)
    exec(EXAMPLES[number], vars(module))
    return module


def test_the_exercise_names_its_mistakes(monkeypatch):
    check = example(0, "tutorial_lib.checks.nb01.arc_length", monkeypatch).check_arc_length
    assert check(check.reference).status == "passed"
    assert len(check.mistakes) == 2
    for words, mistake in check.mistakes.items():
        assert words in check(mistake).message


def test_the_agent_follows_a_path_that_is_refused(monkeypatch):
    agent = object.__new__(example(1, "bold", monkeypatch).BoldAgent)
    refused = Plan((1, 2), 0, (0.3, 0.3, 0.3), refusal="improbable")
    monkeypatch.setattr(MengAgent, "find_path", lambda *_: refused)
    assert agent.find_path(None, None, ()) == replace(refused, refusal="")


def test_the_importer_reads_a_plan_and_names_what_is_none(monkeypatch, tmp_path):
    read, path = example(2, "text_map", monkeypatch).import_text_map, tmp_path / "plan.txt"
    path.write_text("\n".join([" " + "." * 30] * 20))
    assert read(path).area == pytest.approx(6.0)
    path.write_text("")
    with pytest.raises(InputError, match=r"plan\.txt: no free region"):
        read(path)


def test_the_experiment_has_rows_that_grow(monkeypatch):
    rows = example(3, "drift", monkeypatch).EXPERIMENT.report(Options(quick=True)).rows
    errors = [row["error"] for row in rows]
    assert errors == sorted(errors)
    assert len(errors) == 4


def test_the_floors_are_those_that_the_tests_enforce():
    named = re.findall(r"^\| (`[^|]*`) \|", PAGES["ARCHITECTURE.md"], re.MULTILINE)
    floors = [tuple(re.findall(r"`(\w+)`", cell)) for cell in named]
    built = [tuple(sorted(set(layer) - {"__main__"})) for layer in LAYERS]
    assert [tuple(sorted(floor)) for floor in floors[: len(built)]] == built


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_is_named_is_there(page):
    named = re.findall(r"`([\w.]+/[\w./]*)`|\]\(([\w./]+)", PAGES[page])
    names = [path or link for path, link in named if not (path or link).endswith(NEW)]
    names = [name for name in names if not re.search(r"NN_|NAME|PACKAGE|api/|\.venv", name)]
    assert len(names) > 8
    # A page names what is in the library without the library's name, and links from where it is.
    folders = (PROJECT, PROJECT / "tutorial_lib", PROJECT / ".github")
    missing = [name for name in names if not any((folder / name).exists() for folder in folders)]
    assert missing == []
