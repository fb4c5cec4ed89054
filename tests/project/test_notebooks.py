"""Every notebook, as it is built and as students get it, from top to bottom."""

import re
from pathlib import Path

import nbformat
import pytest

from tests.conftest import LIMITS
from tutorial_lib.builder import LARGEST, execute, for_students, read, to_text, unmarked

PROJECT = Path(__file__).parents[2]
SOURCES = sorted(PROJECT.glob("solutions/*.py"))
each_source = pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.stem)


def solved(source):
    return read(source, PROJECT / "tests" / "wrong_answers" / source.name)


def texts(notebook):
    """Everything that the cells print or show as text."""
    parts = []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            assert output.output_type != "error", output
            parts.append(output.get("text", "") + output.get("data", {}).get("text/plain", ""))
    return "\n".join(parts)


def exercises(notebook):
    return [cell.metadata["exercise"] for cell in notebook.cells if "exercise" in cell.metadata]


@each_source
def test_a_rebuild_changes_nothing(source):
    notebook = solved(source)
    students = PROJECT / "notebooks" / f"{source.stem}.ipynb"
    assert students.read_text(encoding="utf-8") == to_text(for_students(notebook))
    there = nbformat.read(source.with_suffix(".ipynb"), as_version=4)
    assert [(c.id, c.source) for c in there.cells] == [
        (c.id, unmarked(c.source)) for c in notebook.cells
    ]


@each_source
def test_the_solved_notebook_can_be_read_where_it_is_hosted(source):
    file = source.with_suffix(".ipynb")
    assert file.stat().st_size <= LARGEST
    there = nbformat.read(file, as_version=4)
    nbformat.validate(there)
    said = texts(there)
    for name in exercises(there):
        assert f"{name}: passed" in said
    pictures = [
        o for c in there.cells for o in c.get("outputs", []) if "image/png" in str(o.keys())
    ]
    shown = [
        o for c in there.cells for o in c.get("outputs", []) if "image/png" in o.get("data", {})
    ]
    assert len(shown) + len(pictures) >= 5


@each_source
@pytest.mark.parametrize("version", ["solved", "students"])
def test_it_runs_from_top_to_bottom(monkeypatch, source, version):
    for name in LIMITS:  # as on a student's machine, also where tests run side by side
        monkeypatch.delenv(name, raising=False)
    notebook = solved(source)
    names = exercises(notebook)
    if version == "students":
        notebook = for_students(notebook)
    execute(notebook, PROJECT / "notebooks")
    said = texts(notebook)
    expected = "passed" if version == "solved" else "not attempted"
    assert re.findall(r"^(\w+): (?:passed|failed|not attempted)", said, re.MULTILINE) == names
    assert said.count(f": {expected}.") == len(names)


def test_no_notebook_is_without_a_source():
    known = {source.stem for source in SOURCES}
    for folder in ("notebooks", "solutions"):
        assert {file.stem for file in (PROJECT / folder).glob("*.ipynb")} == known
