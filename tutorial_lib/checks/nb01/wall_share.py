"""The check of a column of the camera, in notebook 01."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.world.sensors import EYE, WALL_HEIGHT, Camera


def wall_share(depth: float, rows: int) -> Array:
    """(rows,) the share of each pixel of a column that a wall at `depth` covers, from the top."""
    return _shares((WALL_HEIGHT - EYE) / depth, -EYE / depth, rows)


@check(wall_share, (2.0, 16))
def check_wall_share(student: Callable[..., Array]) -> NDArray[np.uint8]:
    """Columns of an image, with exact shares."""
    depths, rows = np.array([0.6, 1.0, 1.7, 3.1, 6.0]), 16
    answers = []
    for depth in depths:
        got = student(depth, rows)
        answers.append(got if np.shape(got) == (rows,) else np.full(rows, np.nan))
    picture = _columns([wall_share(depth, rows) for depth in depths], answers)
    for depth in depths:
        want = wall_share(depth, rows)
        halves = _shares(0.5 / depth, -0.5 / depth, rows)
        mistakes = {
            "some pixels are partly covered; give the share, not 0 or 1": np.round(want),
            "upside down: row 0 is the top of the image": want[::-1],
            "the eye is 0.25 m above the floor, not half way up the wall": halves,
            "divide the heights by the depth": _shares(WALL_HEIGHT - EYE, -EYE, rows),
            "the wall rises 0.75 m above the eye, not 1 m": _shares(
                WALL_HEIGHT / depth, -EYE / depth, rows
            ),
        }
        got = student(depth, rows)
        values = np.asarray(got, dtype=float) if got is not None else want
        if values.shape == want.shape and ((values < -1e-6) | (values > 1 + 1e-6)).any():
            raise WrongAnswer("wall_share: shares lie between 0 and 1; clip them", picture)
        expect_close(f"wall_share at {depth} m", got, want, 2e-3, mistakes, picture)
    return picture


def _shares(top: float, bottom: float, rows: int) -> Array:
    slope = Camera().slope
    height = 2 * slope / rows
    upper = slope - height * np.arange(rows)
    return np.clip((np.minimum(top, upper) - np.maximum(bottom, upper - height)) / height, 0, 1)


def _columns(target: list[Array], yours: list[Array]) -> NDArray[np.uint8]:
    """Target and yours, one column of pixels for each depth, with their names."""
    blocks = []
    for name, shares in (("target", target), ("yours", yours)):
        grey = np.nan_to_num(np.clip(np.stack(shares, axis=1), 0, 1))
        pixels = (235 - 175 * grey).astype(np.uint8)
        block = cv2.resize(pixels, None, fx=32, fy=12, interpolation=cv2.INTER_NEAREST)
        block = cv2.copyMakeBorder(block, 26, 6, 6, 6, cv2.BORDER_CONSTANT, value=255)
        cv2.putText(block, name, (6, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 45, 1, cv2.LINE_AA)
        blocks.append(block)
    return np.repeat(np.concatenate(blocks, axis=1)[..., None], 3, axis=2)
