"""The sheet of first pictures is that of the solved notebooks."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.builder.test_guides import PROJECT
from tutorial_lib.builder import contact_sheet
from tutorial_lib.builder.contact_sheet import FILE, first_picture, write_contact_sheet

LARGEST = 2.0
"""Mean difference of a block of 40 pixels, where another OpenCV makes pictures smaller."""
SOURCES = sorted((PROJECT / "solutions").glob("*.py"))


def test_the_stored_sheet_has_the_first_pictures_of_today():
    stored = cv2.imread(str(PROJECT / FILE))[..., ::-1].astype(int)
    made = contact_sheet(SOURCES).astype(int)
    assert stored.shape == made.shape, "python -m tutorial_lib build"
    rows, columns = (length // 40 * 40 for length in stored.shape[:2])
    apart = np.abs(stored - made)[:rows, :columns].reshape(rows // 40, 40, columns // 40, 40, 3)
    assert apart.mean(axis=(1, 3, 4)).max() < LARGEST


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.stem)
def test_each_notebook_begins_with_a_picture(source):
    assert min(first_picture(source.with_suffix(".ipynb")).shape[:2]) > 300


def test_teachers_see_it_first():
    text = (PROJECT / "solutions/README.md").read_text(encoding="utf-8")
    assert f"](../{FILE})" in text[: text.index("## ")]


def test_it_is_written_into_the_project(tmp_path):
    (tmp_path / "solutions").mkdir()
    (tmp_path / ".pictures").mkdir()
    for file in (SOURCES[0], SOURCES[0].with_suffix(".ipynb")):
        (tmp_path / "solutions" / file.name).write_bytes(file.read_bytes())
    written = write_contact_sheet(tmp_path)
    assert written == tmp_path / Path(FILE)
    assert cv2.imread(str(written)).shape[0] > 400
