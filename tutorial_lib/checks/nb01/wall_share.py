"""The check of a column of the camera, in notebook 01."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.checks.nb01.wall_faults import FAULTS, wall_share
from tutorial_lib.geometry import Array
from tutorial_lib.viz.figures.panels import side_by_side

_TOLERANCE = 2e-3
_DRAWN = ((0.6, 1.0, 1.7, 3.1, 6.0), 16)


def _topics() -> list[Topic]:
    rng = np.random.default_rng(5)
    depths, rows = _DRAWN
    return [
        Topic(
            "a wall at 1.7 m, 16 rows",
            "compare with the picture: which rows does the wall reach, from which slope to which?",
            [(1.7, rows)],
        ),
        Topic(
            "a wall at 6 m, 16 rows",
            "far away the wall covers a few rows only; the others are 0",
            [(6.0, rows)],
        ),
        Topic(
            "a wall at 0.6 m, 16 rows",
            "a near wall reaches beyond the image; a covered row is 1, no more",
            [(0.6, rows)],
        ),
        Topic(
            "16 rows, other depths",
            "the depth is an argument: twice as far, half the slopes",
            [*((depth, rows) for depth in depths), (0.2, rows), (30.0, rows)],
        ),
        Topic(
            "other numbers of rows",
            "the number of rows is an argument: it sets the height of a row, h, and the shape",
            [(2.0, count) for count in (64, 4, 7, 1)],
        ),
        Topic(
            "30 random columns",
            "the simple cases are right; does a part of your rule hold for some depths only?",
            [(float(rng.uniform(0.2, 9)), int(rng.integers(1, 70))) for _ in range(30)],
        ),
    ]


@check(wall_share, (2.0, 16))
def check_wall_share(student: Callable[..., Array]) -> NDArray[np.uint8]:
    """Columns of an image, with exact shares."""
    judge_topics(
        "wall_share",
        student,
        _topics(),
        wall_share,
        FAULTS,
        form=_form,
        same=_same,
        difference=_difference,
        draw=_picture,
    )
    return _picture(student)


def _form(what: str, answer: object, depth: float, rows: int) -> Array:
    return numbers(what, answer, (rows,))


def _same(got: Array, want: Array, *case: object) -> bool:
    return close(got, want, tolerance=_TOLERANCE)


def _difference(got: Array, want: Array, depth: float, rows: int) -> str:
    if np.isnan(got).any():
        return "some of it is not a number"
    if (got > 2).any():
        return f"a share of a whole row is 1, and {got.max():.4g} came back; no grey levels here"
    if ((got < -_TOLERANCE) | (got > 1 + _TOLERANCE)).any():
        return "shares lie between 0 and 1; clip them"
    row = int(np.abs(got - want).argmax())
    return f"at {depth:.2g} m, row {row} of {rows} is {got[row]:.3g}, but {want[row]:.3g} is right"


def _picture(student: Callable[..., Array]) -> NDArray[np.uint8]:
    """Target and yours, one column of pixels for each depth, with their names."""
    depths, rows = _DRAWN
    blocks = []
    for name, function in (("target", wall_share), ("yours", student)):
        shares = [_form(name, function(depth, rows), depth, rows) for depth in depths]
        grey = np.nan_to_num(np.clip(np.stack(shares, axis=1), 0, 1))
        pixels = (235 - 175 * grey).astype(np.uint8)
        block = cv2.resize(pixels, None, fx=32, fy=12, interpolation=cv2.INTER_NEAREST)
        blocks.append(np.repeat(block[..., None], 3, axis=2))
    return side_by_side(blocks, ["target", "yours"])
