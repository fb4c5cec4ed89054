"""Words and numbers on a picture, in the typeface of the charts (DejaVu Sans)."""

from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont

from tutorial_lib.se2 import to_world
from tutorial_lib.validation import floats, instance, number, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import LARGEST, check_canvas, colour_of, places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

SIZE = 0.62
"""Of a label, unless another size is given; 1 is `_HEIGHT` pixels."""
_HEIGHT, _MOST = 24.0, 100.0
_FILE = Path("fonts") / "ttf" / "DejaVuSans.ttf"  # in the data of matplotlib


def label(
    picture: Picture,
    text: str,
    x: int,
    y: int,
    size: float = SIZE,
    colour: tuple[int, int, int] = colours.INK,
) -> None:
    """Write on a picture; (x, y) is the left end of the line on which the letters stand.

    What lies outside of the picture is cut off.

    Raises:
        InputError: when an argument is no such thing; x and y are whole numbers.
    """
    check_canvas(picture)
    size, colour = number("size", size, least=0.0, most=_MOST), colour_of("colour", colour)
    x, y = whole("x", x), whole("y", y)
    ink, above = _drawn(instance("text", text, str), round(_HEIGHT * size))
    top, left = y - above, x
    rows = slice(max(top, 0), min(top + ink.shape[0], picture.shape[0]))
    columns = slice(max(left, 0), min(left + ink.shape[1], picture.shape[1]))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return
    share = ink[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    under = picture[rows, columns].astype(float)
    mixed = under + share[..., None] * (np.asarray(colour, dtype=float) - under)
    picture[rows, columns] = mixed.round().astype(np.uint8)


def text_size(text: str, size: float = SIZE) -> tuple[int, int]:
    """Width of a text and height of its capitals, in pixels."""
    font = _font(round(_HEIGHT * size))
    return round(font.getlength(text)), round(-font.getbbox("H", anchor="ls")[1])


@lru_cache(maxsize=64)
def _font(pixels: int) -> ImageFont.FreeTypeFont:
    import matplotlib  # slow to import, and not all drawing has words

    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / _FILE), max(pixels, 6))


@lru_cache(maxsize=1024)
def _drawn(text: str, pixels: int) -> tuple[NDArray[np.float64], int]:
    """The share of ink (H, W) of a text, and the rows of it above the line."""
    font = _font(pixels)
    above, below = font.getmetrics()
    drawn = Image.new("L", (max(round(font.getlength(text)) + 1, 1), above + below))
    ImageDraw.Draw(drawn).text((0, above), text, fill=255, font=font, anchor="ls")
    return np.asarray(drawn) / 255.0, above


def write_beside(
    view: PlanView, picture: Picture, text: str, pose: ArrayLike, off: float = 18.0
) -> None:
    """Write a text to the left of a pose (3,), `off` pixels from it."""
    pose, off = places_of("pose", pose, (3,)), number("off", off, least=-LARGEST, most=LARGEST)
    instance("view", view, PlanView)
    beside = to_world(pose, [0.0, off / view.scale])
    write_middle(picture, instance("text", text, str), view.pixels(beside), 0.5)


def write_middle(
    picture: Picture,
    text: str,
    pixel: ArrayLike,
    size: float = SIZE,
    colour: tuple[int, int, int] = colours.INK,
) -> None:
    """Write a text whose middle is at a pixel (2,), column and row."""
    wide, high = text_size(text, size)
    column, row = np.round(np.asarray(pixel) + np.array([-wide, high]) / 2).astype(int).tolist()
    label(picture, text, column, row, size, colour)


def draw_badge(
    picture: Picture,
    text: str,
    pixel: ArrayLike,
    size: float = 0.5,
    colour: tuple[int, int, int] = colours.INK,
) -> None:
    """Draw a number on a disc with a pale rim at a pixel (2,); `size` is that of its label."""
    check_canvas(picture)
    pixel = floats("pixel", pixel, (2,), least=-LARGEST, most=LARGEST)
    size, colour = number("size", size, least=0.0, most=_MOST), colour_of("colour", colour)
    column, row = np.round(pixel).astype(int).tolist()
    radius = round(_HEIGHT * size)
    cv2.circle(picture, (column, row), radius + 2, colours.PAPER, cv2.FILLED, cv2.LINE_AA)
    cv2.circle(picture, (column, row), radius, colour, cv2.FILLED, cv2.LINE_AA)
    write_middle(picture, instance("text", text, str), [column, row], size, colours.PAPER)
