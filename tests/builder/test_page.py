import json
import re

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from tests.builder.test_notebooks import GOOD, WRONG
from tutorial_lib.builder import read
from tutorial_lib.builder.page import Entry, explained, lead_to_notebooks, navigation, read_glossary
from tutorial_lib.errors import InputError

ENTRIES = {
    "RE": Entry("RE", 'the "estimator"'),
    "look ahead": Entry("look ahead", "How far.", unit="m"),
}


def test_a_term_is_a_link_that_shows_its_meaning():
    text = explained("see [[RE]] and [[Look ahead]]", ENTRIES, "x.py")
    assert "[RE](README.md#re \"the 'estimator'\")" in text
    assert '[Look ahead](README.md#look-ahead "How far. (m)")' in text


def test_an_unknown_term_is_refused():
    with pytest.raises(InputError, match=r"x.py: \[\[nonsense\]\]"):
        explained("[[nonsense]]", ENTRIES, "x.py")


def test_the_glossary_is_read_in_the_order_of_the_alphabet(tmp_path):
    assert read_glossary(tmp_path) == {}
    path = tmp_path / "glossary.json"
    path.write_text(json.dumps({"b": {"meaning": "B."}, "A": {"meaning": "A.", "unit": "m"}}))
    assert list(read_glossary(tmp_path)) == ["A", "b"]
    path.write_text(json.dumps({"b": {"means": "B."}}))
    with pytest.raises(InputError, match="not a glossary"):
        read_glossary(tmp_path)


def test_links_lead_to_the_neighbours(tmp_path):
    for stem, title in (("01_one", "01 · One"), ("02_two", "02 · Two"), ("03_three", "03 · Three")):
        (tmp_path / f"{stem}.py").write_text(f"# %% [markdown]\n# # {title}\n")
    line = navigation(tmp_path / "02_two.py")
    assert "[← 01 · One](01_one.ipynb)" in line
    assert "[03 · Three →](03_three.ipynb)" in line
    assert "→" not in navigation(tmp_path / "03_three.py")
    assert "←" not in navigation(tmp_path / "01_one.py")


def test_a_solved_notebook_leads_to_the_map_and_not_to_the_teacher_s_page():
    text = f"{explained('[[RE]]', ENTRIES, 'x.py')} [map](README.md) [other](../README.md#a)"
    code = new_code_cell("print('[map](README.md)')")
    notebook = new_notebook(cells=[new_markdown_cell(text), code])
    lead_to_notebooks(notebook)
    links = re.findall(r"\]\(([^) ]+)", notebook.cells[0].source)
    assert links == ["../notebooks/README.md#re", "../notebooks/README.md", "../README.md#a"]
    assert notebook.cells[1].source == code.source


def test_the_page_begins_and_ends_with_links_and_hidden_code_is_folded(tmp_path):
    source = tmp_path / "09_double.py"
    hidden = "\n# %% hidden=true\n# Draw\nx = 1\n"
    source.write_text(GOOD + hidden)
    answers = tmp_path / "answers.py"
    answers.write_text(WRONG)
    notebook = read(source, answers)
    first, last = (
        [cell for cell in notebook.cells if cell.cell_type == "markdown"][i] for i in (0, -1)
    )
    assert first.source.startswith("# Doubling\n\n[map of the course")
    assert last.source.endswith("[map of the course and glossary](README.md)")
    assert notebook.cells[-1].metadata == {"jupyter": {"source_hidden": True}}
    nbformat.validate(notebook)
