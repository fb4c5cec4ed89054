"""The right shares of a column of the camera, and mistakes with them, in notebook 01."""

import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.world.sensors import EYE, WALL_HEIGHT, Camera

_ABOVE = WALL_HEIGHT - EYE


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


def _in_angles(depth: float, rows: int) -> Array:
    """Rows at even angles, each with its own range of slopes."""
    edges = np.tan(np.linspace(1, -1, rows + 1) * np.arctan(Camera().slope))
    common = np.minimum(_ABOVE / depth, edges[:-1]) - np.maximum(-EYE / depth, edges[1:])
    return np.clip(common / (edges[:-1] - edges[1:]), 0, 1)


def _halves(depth: float, rows: int) -> Array:
    """The upper and the lower half, of whole rows each."""
    above = np.clip(_ABOVE / depth / _height(rows) - np.arange(rows // 2), 0, 1)
    below = np.clip(EYE / depth / _height(rows) - np.arange(rows - rows // 2), 0, 1)
    return np.concatenate([above[::-1], below])


def _centres(depth: float, rows: int) -> Array:
    middle = Camera().slope - _height(rows) * (np.arange(rows) + 0.5)
    return ((middle < _ABOVE / depth) & (middle > -EYE / depth)).astype(float)


FAULTS = {
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
    "the upper end of the wall lies at 0.75 / depth, not at 0.75 or at the top of the image": (
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
    "rows divide the range of slopes evenly; these lie at even angles": _in_angles,
    "where the number of rows is odd, the horizon runs through the middle of a row": _halves,
    "an overlap below 0 means that the row is not reached: make it 0, not positive": (
        lambda depth, rows: np.clip(np.abs(_overlap(_ABOVE / depth, -EYE / depth, rows)), 0, 1)
    ),
    "the wall ends at its foot, at the slope -0.25 / depth; the rows below it show the floor": (
        lambda depth, rows: _shares(_ABOVE / depth, -np.inf, rows)
    ),
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
    "the number of rows is an argument; a row is not always 2s / 64 high": (
        lambda depth, rows: _cells(Camera().slope, _height(64), depth, rows)
    ),
    "a row is h = 2s / rows high, not 2s / (rows - 1)": (
        lambda depth, rows: _cells(Camera().slope, _height(max(rows - 1, 1)), depth, rows)
    ),
    "the wall's foot lies below the horizon, at the slope -0.25 / depth: a minus is missing": (
        lambda depth, rows: _shares(_ABOVE / depth, EYE / depth, rows)
    ),
    "divide the overlap by the height of a row, h = 2s / rows; times rows is not the same": (
        lambda depth, rows: wall_share(depth, rows) * _height(rows) * rows
    ),
    "the row that the wall's foot cuts is covered in part, too, as the one of its upper end is": (
        lambda depth, rows: _shares(_ABOVE / depth, -np.inf, rows) * (wall_share(depth, rows) > 0)
    ),
    "a row of which the wall covers a few hundredths has that share; leave none out": (
        lambda depth, rows: np.where(wall_share(depth, rows) < 0.05, 0, wall_share(depth, rows))
    ),
}


def _spread(rows: int) -> Array:
    return np.linspace(Camera().slope, -Camera().slope, rows)
