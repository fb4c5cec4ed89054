"""The first picture of every notebook, with the question below it, on one sheet for teachers."""

from base64 import b64decode
from pathlib import Path

import cv2
import nbformat
import numpy as np
from nbformat import NotebookNode

from tutorial_lib.builder.page import title_of
from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path
from tutorial_lib.validation import instance
from tutorial_lib.viz.canvas.given import Picture
from tutorial_lib.viz.figures.panels import side_by_side, stacked

FILE = Path(".pictures/first_screens.png")
"""In the project."""
_COLUMNS, _HEIGHT = 3, 400


def write_contact_sheet(project: Path) -> Path:
    """Write the sheet of the solved notebooks in the project's folder.

    Raises:
        InputError: when a solved notebook is missing, or the file cannot be written.
    """
    target, sheet = project / FILE, contact_sheet(sorted(project.glob("solutions/*.py")))
    with atomic_path(target) as temporary:  # in all colours: eleven buildings have many
        smallest = [cv2.IMWRITE_PNG_COMPRESSION, 9]
        temporary.write_bytes(cv2.imencode(".png", sheet[..., ::-1], smallest)[1].tobytes())
    return target


def contact_sheet(sources: list[Path]) -> Picture:
    """The first picture of each notebook, which is beside its source, below its title."""
    tiles = [(first_picture(source.with_suffix(".ipynb")), title_of(source)) for source in sources]
    rows = [tiles[first : first + _COLUMNS] for first in range(0, len(tiles), _COLUMNS)]
    return stacked(
        [side_by_side(*map(list, zip(*row, strict=True)), height=_HEIGHT, gap=24) for row in rows]
    )


def first_picture(solved: Path) -> Picture:
    """The first picture that a solved notebook shows, in RGB.

    Raises:
        InputError: when it is not there, or shows none.
    """
    if not solved.is_file():
        raise InputError(f"{solved}: is not there; build it first")
    cells = instance("notebook", nbformat.read(solved, as_version=4), NotebookNode).cells
    pictures = (
        output.data["image/png"]
        for cell in cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    )
    found = next(pictures, None)
    if found is None:
        raise InputError(f"{solved}: shows no picture; begin the notebook with one")
    data = np.frombuffer(b64decode(found), np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)[..., ::-1]
