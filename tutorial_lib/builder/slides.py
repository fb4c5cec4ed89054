"""Slides of a solved notebook: one HTML file that needs no network.

First comes the notebook's opening, then each committed prediction, whose answer is a click away,
and a figure of each section that asks none. What is asked comes from a run of its own, since the
stored page shows answers.
"""

import re
from base64 import b64decode, b64encode
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

import cv2
import nbformat
import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from nbformat import NotebookNode

from tutorial_lib.builder.notebooks import execute
from tutorial_lib.checks.predictions import without_text
from tutorial_lib.files import write_text
from tutorial_lib.validation import instance
from tutorial_lib.viz.canvas.given import Picture
from tutorial_lib.viz.notebook.display import STATIC

FIGURES = 3
"""Slides at most that show a figure and ask nothing."""
_SECTION = re.compile(r"^#+ (?:\d+ · )?(.+)$", re.MULTILINE)
_PNG = "image/png"


@dataclass(frozen=True)
class Slide:
    """One slide.

    Attributes:
        title: above it.
        text: Markdown's paragraphs, as the notebook has them.
        picture: a PNG, in base64; empty for none.
        answer: a PNG that a click puts in its place; empty for none.
    """

    title: str
    text: tuple[str, ...] = ()
    picture: str = ""
    answer: str = ""


def write_slides(source: Path, folder: Path) -> Path:
    """Write the slides ``NN_name.html`` of the notebook beside a source, which is run for them.

    Raises:
        InputError: when a cell raises.
    """
    stored = nbformat.read(source.with_suffix(".ipynb"), as_version=4)
    solved = instance("notebook", stored, NotebookNode)
    asking = deepcopy(solved)
    execute(asking, source.parent.parent / "notebooks", {STATIC: ""})
    slides = slides_of(solved, asking)
    where = FileSystemLoader(Path(__file__).parent)
    page = Environment(loader=where, undefined=StrictUndefined, autoescape=True)
    file = folder / f"{source.stem}.html"
    write_text(file, page.get_template("slides.html.j2").render(slides=slides))
    return file


def slides_of(solved: NotebookNode, asking: NotebookNode) -> list[Slide]:
    """The slides of a solved notebook; `asking` is the same, executed while nothing is answered."""
    first, *others = solved.cells[0].source.split("\n\n")
    opening = [text for text in others if not text.startswith("[")]
    slides = [Slide(first.lstrip("# "), tuple(map(_plain, opening)))]
    section, figure, figures = "", "", 0
    for cell, question in zip(solved.cells, asking.cells, strict=True):
        if cell.cell_type == "markdown":
            found = _SECTION.findall(cell.source)
            if found and figure and figures < FIGURES:
                slides.append(Slide(_plain(section), picture=figure))
                figures += 1
            if found:
                section, figure = found[-1], ""
            continue
        picture, asked = _picture(cell), _asked(question)
        if asked:
            title, *options, _ = asked.split("\n")
            before = _png(without_text(_pixels(_picture(question)), asked))
            slides.append(Slide(title, tuple(options), before, picture))
            section = figure = ""
        elif picture and section:
            figure = picture
    return slides


def _picture(cell: NotebookNode) -> str:
    """The last picture that a cell has put out."""
    found = [o.data[_PNG] for o in cell.outputs if _PNG in o.get("data", {})]
    return found[-1].replace("\n", "") if found else ""


def _asked(cell: NotebookNode) -> str:
    """The text of a cell that shows a prediction; empty where it shows none."""
    texts = [output.get("data", {}).get("text/plain", "") for output in cell.outputs]
    return next((text for text in texts if ".commit(" in text.split("\n")[-1]), "")


def _pixels(png: str) -> Picture:
    return np.asarray(cv2.imdecode(np.frombuffer(b64decode(png), np.uint8), cv2.IMREAD_COLOR))


def _png(pixels: Picture) -> str:
    return b64encode(cv2.imencode(".png", pixels)[1].tobytes()).decode()


def _plain(text: str) -> str:
    """Markdown without links and marks."""
    text = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", text)
    return re.sub(r"[*`$]|</?\w+>", "", text).replace("\n", " ")
