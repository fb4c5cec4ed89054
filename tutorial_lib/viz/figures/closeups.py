"""Close-ups: a part of the plan, and what two images have in common."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import flag, floats, instance, number
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import LARGEST, picture_of, pixels_of, places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.panels import camera_picture


def closeup(
    view: PlanView, picture: Picture, points: ArrayLike, margin: float = 0.8, square: bool = False
) -> Picture:
    """The part of a plan that holds `points` (P, 2) and `margin` metres around them.

    A `square` one is as wide as it is high. What lies beyond the plan is white.
    """
    picture = picture_of("picture", picture)
    margin, square = number("margin", margin, least=0.0), flag("square", square)
    points = places_of("points", points, (..., 2), empty=False).reshape(-1, 2)
    pixels = instance("view", view, PlanView).pixels(points)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    if square:
        middle, half = (low + high) / 2, (high - low).max() / 2
        low, high = middle - half, middle + half
    low = np.floor(low - margin * view.scale).astype(int)
    size = np.ceil(high + margin * view.scale).astype(int) - low
    if square:
        size[:] = size.max()
    width, height = size.tolist()
    if not 0 < width <= LARGEST or not 0 < height <= LARGEST:
        raise InputError(f"margin, points: a picture of {width} x {height} pixels; give others")
    cut = np.full((height, width, 3), colours.PAPER, np.uint8)
    rows, columns = picture.shape[:2]
    left, top = np.maximum(low, 0)
    right, bottom = np.minimum(low + size, (columns, rows))
    if right > left and bottom > top:
        cut[top - low[1] : bottom - low[1], left - low[0] : right - low[0]] = picture[
            top:bottom, left:right
        ]
    return cut


def matches_picture(
    current: NDArray[np.uint8],
    target: NDArray[np.uint8],
    shares: ArrayLike,
    truth: ArrayLike,
    side: int = 416,
) -> Picture:
    """Which columns of one image match which columns of the other.

    Rows of the square are the current image's columns, from its left at the top to its right;
    columns are the target's. The images stand along its sides.

    Args:
        current: (H, W, 3).
        target: (H, W, 3).
        shares: (R, C) how well column r matches column c; the better, the darker.
        truth: (T, 2) true matches, as shares from 0 to 1 of the width of both images.
        side: pixels of the square.
    """
    shares = floats("shares", shares, ("R", "C"), empty=False)
    truth = floats("truth", truth, ("T", 2), least=0.0, most=1.0)
    side = pixels_of("side", side, least=2)
    current, target = picture_of("current", current), picture_of("target", target)
    dark = np.clip(shares, 0.0, 1.0)[..., None] ** 0.6
    tones = colours.PAPER + dark * (np.array(colours.ROBOT) - colours.PAPER)
    square = cv2.resize(tones.astype(np.uint8), (side, side), interpolation=cv2.INTER_NEAREST)
    for across, along in truth:
        centre = round(16 * side * along), round(16 * side * across)
        cv2.circle(square, centre, 24, colours.LASER, cv2.FILLED, cv2.LINE_AA, 4)
    cv2.rectangle(square, (0, 0), (side - 1, side - 1), colours.FAINT, 1)
    above = camera_picture(target, side)
    beside = np.ascontiguousarray(camera_picture(current, side).transpose(1, 0, 2))
    edge, gap = len(above), 6
    picture = np.full((side + edge + gap, side + edge + gap, 3), colours.PAPER, np.uint8)
    picture[:edge, edge + gap :] = above
    picture[edge + gap :, :edge] = beside
    picture[edge + gap :, edge + gap :] = square
    return picture
