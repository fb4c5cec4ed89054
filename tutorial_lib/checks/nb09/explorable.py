"""The check of explorable directions, in notebook 09."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import Mask, calling, exercise, mask
from tutorial_lib.checks.nb09.small_maps import CELL, path_lengths, small_map
from tutorial_lib.viz.figures.directions import map_picture
from tutorial_lib.viz.figures.panels import side_by_side

_DIRECTIONS = 12
_DETOUR = 1.05


def explorable(free: Mask, radius: float) -> Mask:
    """Whether each direction (12,) of a local map leads to explorable area; see the exercise."""
    lengths, middle = path_lengths(free), len(free) // 2
    bearings = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
    reach = radius / CELL
    left, ahead = reach * np.sin(bearings), reach * np.cos(bearings)
    rows, columns = middle + np.rint(left).astype(int), middle + np.rint(ahead).astype(int)
    return lengths[rows, columns] <= _DETOUR * radius


def _random(seed: int, radius: float) -> tuple[Mask, float]:
    """Walls at random, none of them at the robot."""
    rng = np.random.default_rng([seed, 9])
    walls = []
    for _ in range(7):
        x, y = rng.uniform(-radius, radius, 2)
        wide, high = rng.permuted([rng.uniform(0.4, 2.0), 0.2])
        if np.hypot(x + wide / 2, y + high / 2) > 1.2:
            walls.append((x, y, x + wide, y + high))
    return small_map(*walls, radius=radius), radius


def _walled(*walls: tuple[float, float, float, float]) -> tuple[Mask, float]:
    """A map that is free but for walls, and a radius of 3 m."""
    return small_map(*walls), 3.0


_ROOM = ((2.0, -3.5, 2.2, -0.5), (2.0, 0.6, 2.2, 3.5), (-3.5, 2.2, 3.5, 2.4), (-1.2, -3, -1, 1))
CASES = {
    "a room with a door ahead": _walled(*_ROOM),
    "nothing in the way": _walled(),
    "walls all around": _walled(
        (-1, -1, 1, -0.8), (-1, 0.8, 1, 1), (-1, -1, -0.8, 1), (0.8, -1, 1, 1)
    ),
    "a wall on the left": _walled((-3.5, 1.0, 3.5, 1.2)),
    "a wall behind, and one on the right": _walled(
        (-1.2, -1.5, -1.0, 1.5), (-0.4, -1.4, 2.0, -1.2)
    ),
    "a pillar to go around": _walled((1.5, -0.3, 1.7, 0.3), (-1.7, -0.9, -1.5, 0.9)),
    "points that lie in walls": _walled((2.7, -1.0, 3.2, 1.0), (-0.4, 2.8, 0.4, 3.2)),
    "two metres": (small_map((0.8, -1.5, 1.0, 0.5), radius=2.0), 2.0),
    "two metres on a large map": (small_map((2.5, -3.0, 2.7, 3.0), (-1, -3, -0.8, 0.5)), 2.0),
    **{f"a radius between two cells ({seed})": _random(seed, 2.36) for seed in range(8)},
    **{f"a radius between two cells ({seed})": _random(seed, 2.94) for seed in range(8, 16)},
    **{f"at random ({seed})": _random(seed, 3.0 - 0.5 * (seed % 2)) for seed in range(8)},
}
MISTAKES = """
the path decides, not the point alone: it may be free and lie behind a wall
    lengths[rows, columns] <= _DETOUR * radius -> free[rows, columns]
a path that exists may be too long: compare its length with 1.05 * radius, both in metres
    lengths[rows, columns] <= _DETOUR * radius -> np.isfinite(lengths[rows, columns])
the path may be 1.05 times the radius long; yours allows no detour
    _DETOUR * -> 1.0 *
the path may be 1.05 times the radius long, not 1.5 times
    _DETOUR * -> 1.5 *
True is for paths that are short enough; yours is the other way round
    <= -> >
directions go counter-clockwise, and rows grow with y: row 0 is on the robot's right
    bearings = -> bearings = -
rows go with y (sine), columns with x (cosine)
    lengths[rows, columns] -> lengths[columns, rows]
bin 0 is centred on straight ahead; yours begins half a bin later
    reach = -> bearings = bearings + np.pi / _DIRECTIONS; reach =
bin 0 is straight ahead, along the columns; yours begins behind the robot
    reach = -> bearings = bearings + np.pi; reach =
bin 0 is straight ahead, along the columns; yours begins on the robot's left
    reach = -> bearings = bearings + np.pi / 2; reach =
np.linspace(0, 2 * np.pi, 12) has straight ahead twice, and its directions are 32.7 degrees apart;
endpoint=False leaves the last one out
    np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS -> np.linspace(0.0, 2 * np.pi, _DIRECTIONS)
np.cos and np.sin take radians; yours gives them degrees
    reach = -> bearings = np.rad2deg(bearings); reach =
a cell is CELL metres wide: divide metres by CELL
    radius / CELL -> radius
no direction is explorable in yours: the point is `radius` metres away, not at the map's edge, and
the length of the path to it is compared with 1.05 * radius, both in metres
    radius / CELL -> middle
the robot is in the middle of the map, cell (S // 2, S // 2), not in its corner
    len(free) // 2 -> 0
radius need not be a multiple of CELL: round the cells of the points, not the radius
    radius / CELL -> round(radius / CELL)
radius need not be a multiple of CELL: // and int cut it off, round the points
    radius / CELL -> int(radius / CELL)
compare with 1.05 * radius, as it is given, not rounded to cells
    _DETOUR * radius -> _DETOUR * (round(radius / CELL) * CELL)
take the nearest cell, np.rint; astype(int) alone cuts off, towards zero
    np.rint(left) -> np.trunc(left)
    np.rint(ahead) -> np.trunc(ahead)
take the nearest cell, np.rint, not the one above
    np.rint(left) -> np.ceil(left)
    np.rint(ahead) -> np.ceil(ahead)
the middle of S cells, S odd, is S // 2; yours is one cell off
    len(free) // 2 -> len(free) // 2 + 1
rows count from the middle, and so do columns: add S // 2 to both
    middle + np.rint(ahead) -> np.rint(ahead)
take the nearest cell, np.rint; S // 2 + ... cut off by astype(int) is rounded down
    middle + np.rint(left).astype(int) -> (middle + left).astype(int)
    middle + np.rint(ahead).astype(int) -> (middle + ahead).astype(int)
"""


def _draw(want: Mask, got: Mask) -> NDArray[np.uint8]:
    free, radius = next(iter(CASES.values()))
    pictures = [map_picture(free, chosen, radius / CELL) for chosen in (want, got)]
    return side_by_side(pictures, ["expected", "yours"])


def _why(got: Mask, want: Mask, free: Mask, radius: float) -> str:
    """Which direction is wrong, and how long the path to its point is."""
    first = int((got != want).argmax())
    row, column = _cell(free, radius, first)
    length = path_lengths(free)[row, column]
    return (
        f"direction {first}: {got[first]}, but {want[first]} is right; radius {radius:g} m, its "
        f"cell is ({row}, {column}), and the path there {length:.3g} m"
    )


def _cell(free: Mask, radius: float, direction: int) -> tuple[int, int]:
    """Row and column of a direction's point."""
    bearing, middle = direction * 2 * np.pi / _DIRECTIONS, len(free) // 2
    ahead, left = (round(radius * part(bearing) / CELL) for part in (np.cos, np.sin))
    return middle + left, middle + ahead


def _broken(got: Mask, want: Mask, free: Mask, radius: float) -> str:
    """Which part of the rule is broken in the first wrong direction."""
    length = path_lengths(free)[_cell(free, radius, int((got != want).argmax()))]
    where = "is it the right cell? Row: middle + radius * sine / CELL, column: cosine, rounded"
    if not np.isfinite(length):
        return f"no path leads to the point of this direction; {where}"
    if length <= _DETOUR * radius:
        return f"a path of at most 1.05 * radius leads to the point, and that is enough; {where}"
    return f"the path to the point is longer than 1.05 * radius, with no rounding; {where}"


_FAR = "is `radius` used, and in metres? The map has len(free) cells a side, of CELL metres each"
check_explorable = exercise(
    explorable,
    CASES,
    MISTAKES,
    about="Open places, walls, doors, detours, and another radius.",
    example=_walled(*_ROOM),
    calls=300,
    invoke=calling(
        {IndexError: f"an index is a whole number: np.rint(...).astype(int), and {_FAR}"}
    ),
    form=lambda what, got, *_: mask(what, got, (_DIRECTIONS,)),
    difference=_why,
    broken=_broken,
    draw=_draw,
)
