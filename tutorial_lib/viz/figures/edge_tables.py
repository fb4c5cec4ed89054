"""Rules of map building: tables of reachabilities, and sequences of anchors side by side."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.validation import alike, flag, flags, floats, instances, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label, write_middle
from tutorial_lib.viz.canvas.plan_view import Picture

HOLDS, FAILS, PALE = (214, 236, 228), (250, 226, 214), (244, 244, 244)
"""Tints of a cell: an edge, no edge, and neither."""
CELL, SIZE = 46, 0.66
"""Pixels of a cell, and the size of the label that nearly fills it."""
_HEAD = 46  # pixels


def edge_table(
    values: ArrayLike,
    chosen: ArrayLike,
    rings: ArrayLike | None = None,
    names: Sequence[str] = ("from", "to"),
    blank: bool = False,
) -> Picture:
    """A table of numbers (R, C); `chosen` cells are green, the others red.

    Args:
        values: (R, C); cells that are not finite stay empty.
        chosen: (R, C) bool.
        rings: (R, C) bool, cells with a frame around them.
        names: of rows and columns.
        blank: leave the others pale instead of red.
    """
    values = floats("values", values, ("R", "C"), infinite=True, nan=True)
    rows, columns = values.shape
    chosen = flags("chosen", chosen, (rows, columns))
    rings = np.zeros_like(chosen) if rings is None else flags("rings", rings, (rows, columns))
    blank, names = flag("blank", blank), instances("names", names, str)
    if len(names) != 2:
        raise InputError(f"names: {len(names)}; give that of the rows and that of the columns")
    size = (rows * CELL + _HEAD + 1, columns * CELL + _HEAD + 1, 3)
    picture = np.full(size, colours.PAPER, np.uint8)
    for row, column in np.ndindex(rows, columns):
        left, top = column * CELL + _HEAD, row * CELL + _HEAD
        tint = HOLDS if chosen[row, column] else PALE if blank else FAILS
        draw_cell(picture, left, top, tint, values[row, column])
        if rings[row, column]:
            corner = (left + CELL - 4, top + CELL - 4)
            cv2.rectangle(picture, (left + 1, top + 1), corner, colours.GOAL, 2)
    for row in range(rows):
        label(picture, str(row), 16, row * CELL + _HEAD + 30, SIZE, colours.SOLID)
    for column in range(columns):
        label(picture, str(column), column * CELL + _HEAD + 16, 36, SIZE, colours.SOLID)
    label(picture, names[0], 2, _HEAD - 4, 0.55, colours.SOLID)
    label(picture, names[1], _HEAD, 14, 0.55, colours.SOLID)
    return picture


def draw_cell(picture: Picture, left: int, top: int, tint: ArrayLike, value: float) -> None:
    """Fill a cell with a tint, and write its value if it is finite."""
    picture[top : top + CELL - 2, left : left + CELL - 2] = tint
    if np.isfinite(value):
        middle = [left + CELL / 2 - 1, top + CELL / 2 - 1]
        write_middle(picture, f"{value:.2f}", middle, SIZE)


def aligned_sequences(
    row: Sequence[str], column: Sequence[str], pairs: ArrayLike, framed: int | None = None
) -> Picture:
    """Two rows of anchors, one above the other, with the RE of each aligned pair between them.

    Args:
        row: names of the anchors of the new trajectory.
        column: names of the vertices aligned with them, as many.
        pairs: RE of each pair; the smallest is red.
        framed: the index of a pair with a frame around it.
    """
    row, column = instances("row", row, str), instances("column", column, str)
    pairs = floats("pairs", pairs, ("N",), empty=False)
    alike(row=row, column=column, pairs=pairs)
    if framed is not None:
        framed = whole("framed", framed, least=0, most=len(pairs) - 1)
    wide, high = 104, 190
    picture = np.full((high, wide * len(row) + 20, 3), colours.PAPER, np.uint8)
    for line, names in ((34, row), (156, column)):
        cv2.line(picture, (20, line), (picture.shape[1] - 20, line), colours.FAINT, 2)
        for place, name in enumerate(names):
            centre = (10 + wide * place + wide // 2, line)
            tone = colours.ROBOT if line < 90 else colours.PATH
            cv2.circle(picture, centre, 22, tone, cv2.FILLED, cv2.LINE_AA)
            label(picture, name, centre[0] - 8 * len(name), line + 7, 0.6, colours.PAPER)
    for place, value in enumerate(pairs):
        across = 10 + wide * place + wide // 2
        tone = colours.LASER if value == min(pairs) else colours.SOLID
        cv2.arrowedLine(picture, (across, 60), (across, 130), tone, 2, cv2.LINE_AA, 0, 0.15)
        label(picture, f"{value:.2f}", across + 6, 100, 0.5, tone)
        if place == framed:
            corners = (across - 48, 4), (across + 48, high - 5)
            cv2.rectangle(picture, *corners, colours.INK, 2)
    return picture
