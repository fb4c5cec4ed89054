"""The check of a column of the camera, in notebook 01."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import case, close, exercise, hint, numbers, topics
from tutorial_lib.geometry import Array
from tutorial_lib.viz.figures.panels import side_by_side
from tutorial_lib.world.sensors import EYE, WALL_HEIGHT, Camera

_ABOVE, _SLOPE = WALL_HEIGHT - EYE, Camera().slope
_TOLERANCE = 2e-3


def wall_share(depth: float, rows: int) -> Array:
    """(rows,) the share of each pixel of a column that a wall at `depth` covers, from the top."""
    top, bottom = _ABOVE / depth, -EYE / depth
    height = 2 * _SLOPE / rows
    upper = _SLOPE - height * np.arange(rows)
    lower = upper - height
    overlap = np.minimum(top, upper) - np.maximum(bottom, lower)
    return np.clip(overlap / height, 0, 1)


_DEPTHS, _ROWS = (0.6, 1.0, 1.7, 3.1, 6.0), 16
_RNG = np.random.default_rng(5)
TOPICS = {
    "a wall at 1.7 m, 16 rows": hint(
        "compare with the picture: which rows does the wall reach, from which slope to which?",
        (1.7, _ROWS),
    ),
    "a wall at 6 m, 16 rows": hint(
        "far away the wall covers a few rows only; the others are 0", (6.0, _ROWS)
    ),
    "a wall at 0.6 m, 16 rows": hint(
        "a near wall reaches beyond the image; a covered row is 1, no more", (0.6, _ROWS)
    ),
    "16 rows, other depths": hint(
        "the depth is an argument: twice as far, half the slopes",
        *((depth, _ROWS) for depth in _DEPTHS),
        (0.2, _ROWS),
        (30.0, _ROWS),
    ),
    "other numbers of rows": hint(
        "the number of rows is an argument: it sets h and the shape; one row may hold all the wall",
        *((2.0, count) for count in (64, 4, 7, 1)),
    ),
    "30 random columns": hint(
        "the simple cases are right; does a part of your rule hold for some depths only?",
        *((float(_RNG.uniform(0.2, 9)), int(_RNG.integers(1, 70))) for _ in range(30)),
    ),
}
MISTAKES = """
some pixels are partly covered; give the share, not 0 or 1
    np.clip(overlap / height, 0, 1)
        -> ((upper - height / 2 < top) & (upper - height / 2 > bottom)).astype(float)
some pixels are partly covered; do not round the share to 0 or 1
    np.clip(overlap / height, 0, 1) -> np.round(np.clip(overlap / height, 0, 1))
every pixel that the wall touches counts as covered; give the share
    np.clip(overlap / height, 0, 1) -> np.ceil(np.clip(overlap / height, 0, 1))
upside down: row 0 is the top of the image, and 0.75 m of the wall are above the eye
    np.clip(overlap / height, 0, 1) -> np.clip(overlap / height, 0, 1)[::-1]
that is the share of floor and ceiling; the wall's is 1 minus it
    return -> return 1 -
the eye is 0.25 m above the floor, not half way up the wall
    _ABOVE / depth, -EYE / depth -> 0.5 / depth, -0.5 / depth
the wall rises 0.75 m above the eye, not 1 m
    _ABOVE / depth -> WALL_HEIGHT / depth
the eye is 0.25 m above the floor: the wall ends 0.25 m below it, not 0.75 m
    -EYE / depth -> -_ABOVE / depth
the eye is 0.25 m above the floor: the wall rises 0.75 m above it, not 0.25 m
    _ABOVE / depth -> EYE / depth
the upper end of the wall lies at 0.75 / depth, not at 0.75 or at the top of the image
    _ABOVE / depth -> _ABOVE
the lower end of the wall is not divided by the depth
    -EYE / depth -> -EYE
a pixel that is partly covered counts as well; give the share, not only whole pixels
    np.clip(overlap / height, 0, 1) -> np.floor(np.clip(overlap / height, 0, 1))
each row has a share of its own; do not divide them by their sum
    return -> share =
    0, 1) -> 0, 1); return share / share.sum()
a far wall covers no row completely; do not divide by the largest share
    return -> share =
    0, 1) -> 0, 1); return share / share.max()
the image ends at the slope tan 30 degrees (`slope`), half of its field of view of 60
    top, bottom = -> _SLOPE = np.tan(np.pi / 3); top, bottom =
the image ends at the slope tan 30 degrees (`slope`), not at 1
    top, bottom = -> _SLOPE = 1; top, bottom =
the image ends at the slope tan 30 degrees (`slope`), not at 30 degrees in radians
    top, bottom = -> _SLOPE = np.pi / 6; top, bottom =
the part of the wall below the horizon is lost: it ends at the slope -0.25 / depth
    -EYE / depth -> 0
the part of the wall above the horizon is lost: it ends at the slope 0.75 / depth
    _ABOVE / depth -> 0
divide the heights by the depth; as they are they hold for a depth of 1 m only
    _ABOVE / depth, -EYE / depth -> _ABOVE, -EYE
the heights are multiplied by the depth; divide them
    _ABOVE / depth, -EYE / depth -> _ABOVE * depth, -EYE * depth
shares lie between 0 and 1; rows that the wall does not reach come out below 0: clip
    np.clip(overlap / height, 0, 1) -> overlap / height
shares lie between 0 and 1; rows that the wall covers come out above 1: the lower end of
the overlap is the larger of the two lower ends
    np.maximum(bottom, lower) -> bottom
    np.clip(overlap / height, 0, 1) -> np.maximum(overlap / height, 0)
divide the overlap by the height of a row, h, to get a share
    0, 1) -> 0, 1) * height
a row is h = 2s / rows high, since the image reaches from s down to -s
    2 * _SLOPE -> _SLOPE
rows divide the range of slopes evenly, not the range of angles
    top, bottom = _ABOVE / depth, -EYE / depth
        -> _SLOPE = np.pi / 6; top, bottom = np.arctan(_ABOVE / depth), -np.arctan(EYE / depth)
rows divide the range of slopes evenly; these lie at even angles
    lower = upper - height -> edges = np.tan(np.linspace(1, -1, rows + 1) * np.arctan(_SLOPE))
    overlap = -> upper, lower, height = edges[:-1], edges[1:], edges[:-1] - edges[1:]; overlap =
where the number of rows is odd, the horizon runs through the middle of a row
    lower = upper - height -> upper = (rows // 2 - np.arange(rows)) * height; lower = upper - height
an overlap below 0 means that the row is not reached: make it 0, not positive
    overlap / height -> abs(overlap) / height
the wall ends at its foot, at the slope -0.25 / depth; the rows below it show the floor
    -EYE / depth -> -np.inf
everything is one row too low: row 0 begins at the slope s itself
    np.arange(rows) -> np.arange(1, rows + 1)
everything is one row too high: row 0 reaches from s down to s - h
    np.arange(rows) -> np.arange(-1, rows - 1)
everything is half a row too low: a row reaches from its upper edge down by h
    np.arange(rows) -> (np.arange(rows) + 0.5)
everything is half a row too high: a row reaches from its upper edge down by h
    np.arange(rows) -> (np.arange(rows) - 0.5)
rows lie h = 2s / rows apart; np.linspace(s, -s, rows) puts them 2s / (rows - 1) apart
    _SLOPE - height * np.arange(rows) -> np.linspace(_SLOPE, -_SLOPE, rows)
the number of rows is an argument; a row is not always 2s / 16 high
    2 * _SLOPE / rows -> 2 * _SLOPE / 16
the number of rows is an argument; a row is not always 2s / 64 high
    2 * _SLOPE / rows -> 2 * _SLOPE / 64
a row is h = 2s / rows high, not 2s / (rows - 1)
    2 * _SLOPE / rows -> 2 * _SLOPE / max(rows - 1, 1)
the wall's foot lies below the horizon, at the slope -0.25 / depth: a minus is missing
    -EYE -> EYE
divide the overlap by the height of a row, h = 2s / rows; times rows is not the same
    0, 1) -> 0, 1) * 2 * _SLOPE
the row that the wall's foot cuts is covered in part, too, as the one of its upper end is
    np.maximum(bottom, lower) -> np.where(upper > bottom, lower, upper)
one row may hold both ends of the wall: the share is then the wall's height over h
    np.maximum(bottom, lower) -> np.where(top < upper, lower, np.maximum(bottom, lower))
a row of which the wall covers a few hundredths has that share; leave none out
    overlap / height -> np.where(overlap < 0.05 * height, 0, overlap) / height
"""


def _form(what: str, answer: object, depth: float, rows: int) -> Array:
    return numbers(what, answer, (rows,))


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
    """What is expected and yours, one column of pixels for each depth, with their names."""
    blocks = []
    for name, function in (("expected", wall_share), ("yours", student)):
        shares = [_form(name, function(depth, _ROWS), depth, _ROWS) for depth in _DEPTHS]
        grey = np.nan_to_num(np.clip(np.stack(shares, axis=1), 0, 1))
        pixels = (235 - 175 * grey).astype(np.uint8)
        block = pixels.repeat(12, axis=0).repeat(32, axis=1)
        blocks.append(block[..., None].repeat(3, axis=2))
    return side_by_side(blocks, ["expected", "yours"])


check_wall_share = exercise(
    wall_share,
    topics(TOPICS),
    MISTAKES,
    about="Columns of an image, with exact shares.",
    example=case(2.0, 16),
    form=_form,
    same=partial(close, tolerance=_TOLERANCE),
    difference=_difference,
    draw=_picture,
)
