"""Slides of a notebook: what is asked is shown without its answer, which is a click away."""

import re
from base64 import b64decode, b64encode

import cv2
import nbformat
import numpy as np
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

from tutorial_lib.builder import execute
from tutorial_lib.builder.slides import FIGURES, slides_of, write_slides

ASKING = """
import numpy as np
from tutorial_lib.checks.predictions import Prediction

asked = Prediction(
    "05", "asked", "Which one is it, of two that look so much alike?", {"A": "one", "B": "two"},
    right="B", robot="it takes B.", tempting="A", because="it comes first.",
    before=np.full((40, 600, 3), 90, np.uint8), after=np.full((60, 600, 3), 160, np.uint8),
)
asked
"""
DRAWING = """
import numpy as np
from tutorial_lib.viz import show

show(np.full((30, 50, 3), {level}, np.uint8), "a figure")
"""


def pixels(png):
    return cv2.imdecode(np.frombuffer(b64decode(png), np.uint8), cv2.IMREAD_COLOR)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    project = tmp_path_factory.mktemp("project")
    for folder in ("notebooks", "solutions", "slides"):
        (project / folder).mkdir()
    cells = [new_markdown_cell("# 05 · Maps\n\n[← back](04.ipynb)\n\n**A trip.** Which [way](x)?")]
    for level in (10, 20, 30, 40, 50):
        cells += [
            new_markdown_cell(f"## {level // 10} · Section {level}\n\nWords."),
            new_code_cell(DRAWING.format(level=level)),
        ]
    cells.insert(3, new_code_cell(ASKING))
    solved = new_notebook(cells=cells)
    execute(solved, project / "notebooks")
    nbformat.write(solved, project / "solutions/05_maps.ipynb")
    return write_slides(project / "solutions/05_maps.py", project / "slides")


@pytest.mark.full
def test_a_file_has_opening_questions_and_some_figures_and_needs_no_network(written):
    text = written.read_text()
    titles = re.findall(r"<h1>(.+?)</h1>", text)
    assert titles[0] == "05 · Maps"
    assert titles[1].startswith("Which one is it")
    assert titles[2:] == [f"Section {level}" for level in (20, 30, 40)][:FIGURES]
    assert "← back" not in text
    assert "A trip. Which way?" in text
    assert not re.search(r"(src|href)=.?https?:", text)
    pictures = re.findall(r'src="data:image/png;base64,(.+?)"', text)
    (answer,) = re.findall(r'data-answer="data:image/png;base64,(.+?)"', text)
    assert pixels(pictures[0]).shape == (40, 600, 3)  # no text, no answer
    assert (pixels(pictures[0]) == 90).all()
    assert (pixels(answer)[:60] == 160).all()


def figure(level):
    png = cv2.imencode(".png", np.full((3, 4, 3), level, np.uint8))[1]
    return new_output("display_data", {"image/png": b64encode(png).decode()})


def test_a_section_shows_its_last_figure_and_no_more_than_a_few_are_shown():
    cells = [new_markdown_cell("# 01 · Cars\n\nHello.")]
    for number in range(6):
        cells.append(new_markdown_cell(f"## {number} · Part {number}"))
        cells.append(new_code_cell("x", outputs=[figure(number), figure(100 + number)]))
    notebook = new_notebook(cells=cells)
    slides = slides_of(notebook, notebook)
    assert [slide.title for slide in slides] == ["01 · Cars", "Part 0", "Part 1", "Part 2"]
    assert (pixels(slides[1].picture) == 100).all()
    assert all(not slide.answer for slide in slides)


def test_a_notebook_without_pictures_has_its_opening():
    notebook = new_notebook(cells=[new_markdown_cell("# 00 · Hello\n\nOne.\n\nTwo.")])
    (slide,) = slides_of(notebook, notebook)
    assert slide.text == ("One.", "Two.")
