"""Every notebook, as it is built and as students get it, from top to bottom."""

import re
from pathlib import Path

import nbformat
import pytest
from nbformat import NotebookNode
from nbformat.v4 import new_notebook

from tests.project.printed import differences, printed
from tests.project.unsolved import both
from tutorial_lib.builder import LARGEST, execute, for_students, read, to_text, unmarked
from tutorial_lib.builder.page import lead_to_notebooks
from tutorial_lib.checks.framework.check import Result
from tutorial_lib.commands.outputs import WIDGET
from tutorial_lib.learning.threads import processor

PROJECT = Path(__file__).parents[2]
SOURCES = sorted(PROJECT.glob("solutions/*.py"))
each_source = pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.stem)


def solved(source):
    return read(source, PROJECT / "tests" / "wrong_answers" / source.name)


def texts(cells):
    """Everything that cells print or show as text."""
    parts = []
    for cell in cells:
        for output in cell.get("outputs", []):
            assert output.output_type != "error", output
            parts.append(output.get("text", "") + output.get("data", {}).get("text/plain", ""))
    return "\n".join(parts)


def shown_as_html(cells):
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    return "\n".join(output.get("data", {}).get("text/html", "") for output in outputs)


def exercises(cells):
    return [cell.metadata["exercise"] for cell in cells if "exercise" in cell.metadata]


@each_source
def test_a_rebuild_changes_nothing(source):
    notebook = solved(source)
    students = PROJECT / "notebooks" / f"{source.stem}.ipynb"
    assert students.read_text(encoding="utf-8") == to_text(for_students(notebook))
    there = nbformat.read(source.with_suffix(".ipynb"), as_version=4)
    assert there.metadata.kernelspec == notebook.metadata.kernelspec
    lead_to_notebooks(notebook)
    assert [(c.id, c.source) for c in there.cells] == [
        (c.id, unmarked(c.source)) for c in notebook.cells
    ]


@each_source
def test_the_solved_notebook_can_be_read_where_it_is_hosted(source):
    file = source.with_suffix(".ipynb")
    assert file.stat().st_size <= LARGEST
    there = nbformat.read(file, as_version=4)
    nbformat.validate(there)
    assert WIDGET not in file.read_text(encoding="utf-8")
    said = texts(there.cells)
    for name in exercises(there.cells):
        assert f"{name}: passed" in said
        verdict = Result(name, "passed", "")._repr_html_().partition("<br>")[0]
        assert verdict in shown_as_html(there.cells), f"{name} looks otherwise: execute it anew"
    pictures = [
        o for c in there.cells for o in c.get("outputs", []) if "image/png" in str(o.keys())
    ]
    shown = [
        o for c in there.cells for o in c.get("outputs", []) if "image/png" in o.get("data", {})
    ]
    assert len(shown) + len(pictures) >= 5


@each_source
def test_it_runs_from_top_to_bottom_unsolved_and_solved(source, request):
    """In one kernel, which imports the library and runs what both have in common once.

    Slow cells behind a check are run unsolved as well with --full.

    What the solved one prints is what is stored, and so what its text speaks of; on another kind of
    processor some robots drive otherwise, since the last digits of what networks predict differ.
    """
    notebook = solved(source)
    students = for_students(notebook)
    cells, first, second = both(
        notebook.cells, students.cells, slow_ones=request.config.getoption("--full")
    )
    run = new_notebook(cells=[NotebookNode(cell, id=f"cell-{i}") for i, cell in enumerate(cells)])
    execute(run, PROJECT / "notebooks")
    names = exercises(students.cells)
    for expected, part in (("passed", first), ("not attempted", second)):
        said = texts(run.cells[i] for i in part)
        assert re.findall(r"^(\w+): (?:passed|failed|not attempted)", said, re.MULTILINE) == names
        assert said.count(f": {expected}.") == len(names)
    stored = nbformat.read(source.with_suffix(".ipynb"), as_version=4)
    if stored.metadata.processor != processor():
        return
    for before, now in zip(stored.cells, (run.cells[i] for i in first), strict=True):
        assert not differences(printed(before), printed(now)), before.source


def test_whose_functions_the_solved_robot_of_06_has_is_what_its_text_says():
    """The build saves no answers, so that none is found in `my_answers`."""
    (source,) = (source for source in SOURCES if source.stem.startswith("06"))
    stored = nbformat.read(source.with_suffix(".ipynb"), as_version=4)
    (table,) = (cell for cell in stored.cells if ".mine()" in cell.source)
    rows = texts([table]).split("written by")[1].strip().splitlines()
    assert len(rows) > 10
    assert all(row.endswith("the library") for row in rows)
    said = "\n".join(cell.source for cell in solved(source).cells)
    assert "so in its table all are the library's" in said


def test_no_notebook_is_without_a_source():
    known = {source.stem for source in SOURCES}
    for folder in ("notebooks", "solutions"):
        assert {file.stem for file in (PROJECT / folder).glob("*.ipynb")} == known


def test_what_is_stored_is_compared_in_words_and_numbers():
    said = "path: 12 edges, 0.87\nfound in 3.1 s"
    assert differences(said, "path: 12 edges, 0.88\nfound in 12 s") == []
    assert differences(said, "path: 15 edges, 0.87\nfound in 3.1 s") == [
        "'path: 12 edges, 0.87', now 'path: 15 edges, 0.87'"
    ]
    assert differences(said, "path: 12 edges, 0.87\nlost in 3.1 s") != []
    assert differences(said, "path: 12 edges, 0.87") == ["2 lines, now 1"]
