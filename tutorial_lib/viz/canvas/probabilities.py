"""Probabilities as colours on the plan."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.validation import alike, floats, instance, number
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import FAR, check_canvas, points_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

_MIDDLE = (240, 238, 232)  # the colour of one half
_GAP = 0.06  # share of a cell that is left free


def probability_colours(probability: ArrayLike) -> NDArray[np.uint8]:
    """Colours (..., 3) of probabilities (...): red for 0, pale for one half, blue for 1.

    >>> probability_colours([0.0, 1.0]).tolist()
    [[213, 94, 0], [0, 114, 178]]
    """
    stops = np.array([colours.LASER, _MIDDLE, colours.ROBOT], dtype=float)
    probability = np.asarray(probability, dtype=float)
    parts = [np.interp(probability, [0.0, 0.5, 1.0], channel) for channel in stops.T]
    return np.stack(parts, axis=-1).round().astype(np.uint8)


def draw_cells(
    view: PlanView,
    picture: Picture,
    places: ArrayLike,
    probability: ArrayLike,
    size: float,
    opacity: float = 0.85,
) -> None:
    """Draw a square of `size` metres for each probability (N,) at `places` (N, 2 or 3)."""
    check_canvas(picture)
    instance("view", view, PlanView)
    places = points_of("places", places)
    probability = floats("probability", probability, ("N",), least=0.0, most=1.0)
    alike(places=places, probability=probability)
    size = number("size", size, least=0.0, most=FAR)
    opacity = number("opacity", opacity, least=0.0, most=1.0)
    half = size * (1 - _GAP) / 2
    square = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    layer = picture.copy()
    tones = probability_colours(probability).tolist()
    for place, tone in zip(places, tones, strict=True):
        view.polygon(layer, place + square, tuple(tone))
    cv2.addWeighted(layer, opacity, picture, 1 - opacity, 0, dst=picture)
