"""The check of a column of the camera, in notebook 01."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.geometry import Array
from tutorial_lib.viz.figures.panels import side_by_side
from tutorial_lib.world.sensors import EYE, WALL_HEIGHT, Camera

_ABOVE = WALL_HEIGHT - EYE
_TOLERANCE = 2e-3
_DRAWN = ((0.6, 1.0, 1.7, 3.1, 6.0), 16)


def wall_share(depth: float, rows: int) -> Array:
    """(rows,) the share of each pixel of a column that a wall at `depth` covers, from the top."""
    return _shares(_ABOVE / depth, -EYE / depth, rows)


def _overlap(top: float, bottom: float, rows: int, slope: float = Camera().slope) -> Array:
    """How much (rows,) of each row's range of slopes lies between two slopes, unclipped."""
    height = 2 * slope / rows
    upper = slope - height * np.arange(rows)
    return (np.minimum(top, upper) - np.maximum(bottom, upper - height)) / height


def _uppers(rows: int) -> Array:
    return Camera().slope - _height(rows) * np.arange(rows)


def _shares(top: float, bottom: float, rows: int) -> Array:
    return np.clip(_overlap(top, bottom, rows), 0, 1)


def _height(rows: int) -> float:
    return 2 * Camera().slope / rows


def _cells(first: float, height: float, depth: float, rows: int) -> Array:
    """Shares of rows that begin at a slope and have a height."""
    upper = first - height * np.arange(rows)
    common = np.minimum(_ABOVE / depth, upper) - np.maximum(-EYE / depth, upper - height)
    return np.clip(common / height, 0, 1)


def _angles(depth: float, rows: int) -> Array:
    top, bottom = np.arctan(_ABOVE / depth), -np.arctan(EYE / depth)
    return np.clip(_overlap(top, bottom, rows, np.arctan(Camera().slope)), 0, 1)


def _centres(depth: float, rows: int) -> Array:
    middle = Camera().slope - _height(rows) * (np.arange(rows) + 0.5)
    return ((middle < _ABOVE / depth) & (middle > -EYE / depth)).astype(float)


_FAULTS = {
    "some pixels are partly covered; give the share, not 0 or 1": _centres,
    "some pixels are partly covered; do not round the share to 0 or 1": (
        lambda depth, rows: np.round(wall_share(depth, rows))
    ),
    "every pixel that the wall touches counts as covered; give the share": (
        lambda depth, rows: np.ceil(wall_share(depth, rows))
    ),
    "upside down: row 0 is the top of the image, and 0.75 m of the wall are above the eye": (
        lambda depth, rows: wall_share(depth, rows)[::-1]
    ),
    "that is the share of floor and ceiling; the wall's is 1 minus it": (
        lambda depth, rows: 1 - wall_share(depth, rows)
    ),
    "the eye is 0.25 m above the floor, not half way up the wall": (
        lambda depth, rows: _shares(0.5 / depth, -0.5 / depth, rows)
    ),
    "the wall rises 0.75 m above the eye, not 1 m": (
        lambda depth, rows: _shares(WALL_HEIGHT / depth, -EYE / depth, rows)
    ),
    "the eye is 0.25 m above the floor: the wall ends 0.25 m below it, not 0.75 m": (
        lambda depth, rows: _shares(_ABOVE / depth, -_ABOVE / depth, rows)
    ),
    "the eye is 0.25 m above the floor: the wall rises 0.75 m above it, not 0.25 m": (
        lambda depth, rows: _shares(EYE / depth, -EYE / depth, rows)
    ),
    "the upper end of the wall is not divided by the depth": (
        lambda depth, rows: _shares(_ABOVE, -EYE / depth, rows)
    ),
    "the lower end of the wall is not divided by the depth": (
        lambda depth, rows: _shares(_ABOVE / depth, -EYE, rows)
    ),
    "a pixel that is partly covered counts as well; give the share, not only whole pixels": (
        lambda depth, rows: np.floor(wall_share(depth, rows))
    ),
    "each row has a share of its own; do not divide them by their sum": (
        lambda depth, rows: wall_share(depth, rows) / wall_share(depth, rows).sum()
    ),
    "a far wall covers no row completely; do not divide by the largest share": (
        lambda depth, rows: wall_share(depth, rows) / wall_share(depth, rows).max()
    ),
    "the image ends at the slope tan 30 degrees (`slope`), half of its field of view of 60": (
        lambda depth, rows: np.clip(
            _overlap(_ABOVE / depth, -EYE / depth, rows, np.tan(np.pi / 3)), 0, 1
        )
    ),
    "the image ends at the slope tan 30 degrees (`slope`), not at 1": (
        lambda depth, rows: np.clip(_overlap(_ABOVE / depth, -EYE / depth, rows, 1.0), 0, 1)
    ),
    "the image ends at the slope tan 30 degrees (`slope`), not at 30 degrees in radians": (
        lambda depth, rows: np.clip(_overlap(_ABOVE / depth, -EYE / depth, rows, np.pi / 6), 0, 1)
    ),
    "the part of the wall below the horizon is lost: it ends at the slope -0.25 / depth": (
        lambda depth, rows: _shares(_ABOVE / depth, 0.0, rows)
    ),
    "the part of the wall above the horizon is lost: it ends at the slope 0.75 / depth": (
        lambda depth, rows: _shares(0.0, -EYE / depth, rows)
    ),
    "divide the heights by the depth; as they are they hold for a depth of 1 m only": (
        lambda depth, rows: _shares(_ABOVE, -EYE, rows)
    ),
    "the heights are multiplied by the depth; divide them": (
        lambda depth, rows: _shares(_ABOVE * depth, -EYE * depth, rows)
    ),
    "shares lie between 0 and 1; rows that the wall does not reach come out below 0: clip": (
        lambda depth, rows: _overlap(_ABOVE / depth, -EYE / depth, rows)
    ),
    "shares lie between 0 and 1; rows that the wall covers come out above 1: the lower end of "
    "the overlap is the larger of the two lower ends": (
        lambda depth, rows: np.maximum(
            (np.minimum(_ABOVE / depth, _uppers(rows)) + EYE / depth) / _height(rows), 0
        )
    ),
    "divide the overlap by the height of a row, h, to get a share": (
        lambda depth, rows: wall_share(depth, rows) * _height(rows)
    ),
    "a row is h = 2s / rows high, since the image reaches from s down to -s": (
        lambda depth, rows: _cells(Camera().slope, _height(rows) / 2, depth, rows)
    ),
    "rows divide the range of slopes evenly, not the range of angles": _angles,
    "everything is one row too low: row 0 begins at the slope s itself": (
        lambda depth, rows: _cells(Camera().slope - _height(rows), _height(rows), depth, rows)
    ),
    "everything is one row too high: row 0 reaches from s down to s - h": (
        lambda depth, rows: _cells(Camera().slope + _height(rows), _height(rows), depth, rows)
    ),
    "everything is half a row too low: a row reaches from its upper edge down by h": (
        lambda depth, rows: _cells(Camera().slope - _height(rows) / 2, _height(rows), depth, rows)
    ),
    "everything is half a row too high: a row reaches from its upper edge down by h": (
        lambda depth, rows: _cells(Camera().slope + _height(rows) / 2, _height(rows), depth, rows)
    ),
    "rows lie h = 2s / rows apart; np.linspace(s, -s, rows) puts them 2s / (rows - 1) apart": (
        lambda depth, rows: np.clip(
            (
                np.minimum(_ABOVE / depth, _spread(rows))
                - np.maximum(-EYE / depth, _spread(rows) - _height(rows))
            )
            / _height(rows),
            0,
            1,
        )
    ),
    "the number of rows is an argument; a row is not always 2s / 16 high": (
        lambda depth, rows: _cells(Camera().slope, _height(16), depth, rows)
    ),
}


def _spread(rows: int) -> Array:
    return np.linspace(Camera().slope, -Camera().slope, rows)


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
        _FAULTS,
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
