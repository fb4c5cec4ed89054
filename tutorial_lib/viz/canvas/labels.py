"""Words and numbers on a picture."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.geometry import to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

FONT, SIZE = cv2.FONT_HERSHEY_SIMPLEX, 0.62
"""Of a label, unless another size is given."""


def label(
    picture: Picture,
    text: str,
    x: int,
    y: int,
    size: float = SIZE,
    colour: tuple[int, int, int] = colours.INK,
) -> None:
    """Write on a picture; (x, y) is the lower left corner of the first letter. Latin letters only.

    OpenCV draws question marks in place of all others.
    """
    cv2.putText(picture, text, (x, y), FONT, size, colour, 1, cv2.LINE_AA)


def write_beside(
    view: PlanView, picture: Picture, text: str, pose: ArrayLike, off: float = 18.0
) -> None:
    """Write a text to the left of a pose (3,), `off` pixels from it."""
    beside = to_world(pose, [0.0, off / view.scale])
    (wide, high), _ = cv2.getTextSize(text, FONT, 0.5, 1)
    corner = view.pixels(beside) + np.array([-wide / 2, high / 2])
    label(picture, text, *np.round(corner).astype(int).tolist(), 0.5)


def draw_badge(picture: Picture, text: str, pixel: NDArray[np.float64]) -> None:
    """Draw a number on a disc at a pixel (2,)."""
    column, row = np.round(pixel).astype(int).tolist()
    cv2.circle(picture, (column, row), 12, colours.INK, cv2.FILLED, cv2.LINE_AA)
    (wide, high), _ = cv2.getTextSize(text, FONT, 0.5, 1)
    label(picture, text, column - wide // 2, row + high // 2, 0.5, colours.PAPER)
