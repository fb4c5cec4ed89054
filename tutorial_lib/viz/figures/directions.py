"""Directions of a panorama: over its picture, and around the robot on a local map."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import alike, flags, floats, number, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import picture_of, pixels_of, resized
from tutorial_lib.viz.canvas.labels import draw_badge, label, text_size
from tutorial_lib.viz.canvas.plan_view import Picture

_TALL = 46
"""Pixels of the bars of scores under a panorama."""
_NAMES = 22
"""Pixels of the line with the directions' numbers."""
_CELL = 5
"""Pixels of a local map's cell."""


def panorama_picture(image: NDArray[np.uint8], width: int = 768, height: int = 96) -> Picture:
    """A panorama (H, W, 3) enlarged for people; behind the robot is at both ends."""
    size = pixels_of("width", width), pixels_of("height", height)
    return resized(picture_of("image", image), size, cv2.INTER_NEAREST)


def scored_panorama(
    image: NDArray[np.uint8],
    scores: ArrayLike,
    explorable: ArrayLike | None = None,
    chosen: int | None = None,
    truth: ArrayLike | None = None,
    width: int = 768,
) -> Picture:
    """A panorama with its directions under it: number and score, ghosts filled, the rest pale.

    Args:
        image: (H, W, 3) of a panorama.
        scores: (K,) from 0 to 1, drawn as bars from the lowest to the highest.
        explorable: (K,) which of them have a ghost; all unless given.
        chosen: the direction that the robot takes, if any.
        truth: (K,) scores to mark on the bars by a line.
        width: pixels.
    """
    scores = floats("scores", scores, ("K",), empty=False)
    count, width = len(scores), pixels_of("width", width, least=40)
    explorable = np.ones(count, bool) if explorable is None else explorable
    filled = flags("explorable", explorable, ("K",))
    alike(scores=scores, explorable=filled)
    if truth is not None:
        truth = floats("truth", truth, ("K",))
        alike(scores=scores, truth=truth)
    chosen = None if chosen is None else whole("chosen", chosen, least=0, most=count - 1)
    both = scores if truth is None else np.concatenate([scores, truth])
    low, high = float(both.min()), max(float(both.max()), float(both.min()) + 1e-6)
    under = np.full((_TALL + _NAMES, width, 3), colours.PAPER, np.uint8)

    def tall(score: float) -> int:
        return 4 + round((_TALL - 8) * (score - low) / (high - low))

    for k in range(count):
        middle = _column(k, count, width)
        tone = colours.GOAL if k == chosen else colours.ROBOT if filled[k] else (200, 205, 210)
        bar = slice(_TALL - tall(scores[k]), _TALL)
        for left, right in _wrapped(middle, width // (3 * count), width):
            under[bar, left:right] = tone
            if truth is not None:
                line = _TALL - tall(float(truth[k]))
                under[max(line - 1, 0) : line + 2, left:right] = colours.LASER
        text = f"{k}"
        wide, _ = text_size(text, 0.5)
        place = min(max(middle - wide // 2, 0), width - wide)
        label(under, text, place, _TALL + _NAMES - 6, 0.5)
    return np.concatenate([panorama_picture(image, width), under])


def map_picture(
    free: NDArray[np.bool_], chosen: Sequence[bool] | NDArray[np.bool_], reach: float
) -> Picture:
    """A local map with a numbered dot in each direction: green if it is chosen, orange if not.

    Args:
        free: (S, S) cells where a robot can be; rows run along y, and y is up in the picture.
        chosen: (K,) of the directions.
        reach: cells from the middle to the dots.
    """
    free, chosen = flags("free", free, ("S", "S"), empty=False), flags("chosen", chosen, ("K",))
    if free.shape[0] != free.shape[1]:
        raise InputError(f"free: shape {free.shape}; give (S, S)")
    reach = number("reach", reach, least=0.0, most=float(len(free)))
    rows = np.where(free[::-1, :, None], colours.PAPER, colours.SOLID).astype(np.uint8)
    picture = rows.repeat(_CELL, axis=0).repeat(_CELL, axis=1)
    middle, count = (len(free) // 2 + 0.5) * _CELL, len(chosen)
    for k, good in enumerate(chosen):
        angle = 2 * np.pi * k / count
        end = middle + reach * _CELL * np.array([np.cos(angle), -np.sin(angle)])
        draw_badge(picture, str(k), end, 0.6, colours.GOAL if good else colours.LASER)
    nose = np.array([[12, 0], [-8, 7], [-8, -7]]) + round(middle)
    cv2.fillPoly(picture, [nose.astype(np.int32)], colours.ROBOT, cv2.LINE_AA)
    return picture


def _column(direction: int, count: int, width: int) -> int:
    """The pixel column on which a direction is centred; 0 is in the middle, 1 to its left."""
    return round(width * (0.5 - direction / count)) % width


def _wrapped(middle: int, half: int, width: int) -> list[tuple[int, int]]:
    """Columns about a middle one, which may reach around the picture's ends."""
    left, right = middle - half, middle + half
    parts = [(max(left, 0), min(right, width))]
    if left < 0:
        parts.append((width + left, width))
    if right > width:
        parts.append((0, right - width))
    return parts
