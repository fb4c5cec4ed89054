"""Targets that were reached and targets that were missed, told apart without their colours."""

import cv2
import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.validation import flag, instance
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import check_canvas, places_of
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

_SIZE = 0.16
"""Metres from the middle of a mark to its edge."""


def draw_outcome(view: PlanView, picture: Picture, place: ArrayLike, reached: bool) -> None:
    """Mark a target at `place` (2,): a disc if it was reached, a cross if not."""
    size = max(3, round(_SIZE * instance("view", view, PlanView).scale))
    place, reached = places_of("place", place, (2,)), flag("reached", reached)
    check_canvas(picture)
    x, y = view.pixels(place).round().astype(int).tolist()
    _mark(picture, x, y, size, reached)


def outcome_legend() -> Picture:
    """A legend of both marks."""
    picture = np.full((26, 300, 3), colours.PAPER, np.uint8)
    for x, reached, word in ((14, True, "reached"), (150, False, "not reached")):
        _mark(picture, x, 13, 8, reached)
        label(picture, word, x + 16, 19)
    return picture


def _mark(picture: Picture, x: int, y: int, size: int, reached: bool) -> None:
    if reached:
        cv2.circle(picture, (x, y), size, colours.GOAL, cv2.FILLED, cv2.LINE_AA)
        return
    width = max(2, size // 2)
    for corner in ((size, size), (size, -size)):
        begin, end = (x - corner[0], y - corner[1]), (x + corner[0], y + corner[1])
        cv2.line(picture, begin, end, colours.LASER, width, cv2.LINE_AA)
