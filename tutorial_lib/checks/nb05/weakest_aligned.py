"""The check of aligned sequences, in notebook 05."""

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, calling, case, close, edited, exercise, numbers
from tutorial_lib.checks.nb05.trajectories import JOINED, MIXED, ONE, TWO, random_reach
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.viz.figures.edge_tables import edge_table
from tutorial_lib.viz.figures.panels import side_by_side, stacked


def weakest_aligned(reach: Array, before: Indices, after: Indices, steps: int) -> Array:
    """The least RE (A, V) over aligned sequences around each pair (Meng 2020, III-G)."""
    values = [reach]
    for direction, beside in ((-1, before), (1, after)):
        rows, columns = np.indices(reach.shape)
        there = np.ones(reach.shape, dtype=bool)
        for _ in range(steps):
            rows, columns = rows + direction, beside[columns]
            there = there & (rows >= 0) & (rows < len(reach)) & (columns >= 0)
            values.append(np.where(there, reach[rows % len(reach), columns], np.nan))
    return np.nanmin(values, axis=0)


CASES = {
    "one trajectory beside another": (random_reach(5, 5, 1), *ONE, 2),
    "one anchor before and after": (random_reach(5, 5, 2), *ONE, 1),
    "no neighbours": (random_reach(4, 6, 3), *TWO, 0),
    "two trajectories on the map": (random_reach(6, 6, 4), *TWO, 2),
    "vertices in no order": (random_reach(5, 7, 5), *MIXED, 2),
    "trajectories that run into another": (random_reach(5, 5, 23), *JOINED, 2),
    "one anchor": (random_reach(1, 7, 6), *MIXED, 2),
    "three anchors on either side": (random_reach(8, 7, 31), *MIXED, 3),
    "sequences longer than the trajectories": (random_reach(4, 5, 32), *ONE, 9),
    "six anchors on either side": (random_reach(14, 7, 36), *MIXED, 6),
    "more vertices than anchors": (random_reach(3, 7, 33), *MIXED, 1),
    "RE with many digits": (np.random.default_rng(35).random((5, 6)), *TWO, 2),
    "one vertex": (random_reach(4, 1, 34), np.array([-1]), np.array([-1]), 2),
}
MISTAKES = """
the least of them counts, not their mean
    np.nanmin -> np.nanmean
the least of them counts, not their product
    np.nanmin -> np.nanprod
the least of them counts, not the greatest
    np.nanmin -> np.nanmax
steps is an argument; yours always looks two anchors to either side
    range(steps) -> range(2)
steps is an argument; yours always looks one anchor to either side
    range(steps) -> range(1)
all pairs on the way count, not only the farthest on either side
    values = [reach] -> values = {0: reach}
    values.append( -> values[direction] = (
    np.nan) -> values.get(direction, np.nan))
    nanmin(values -> nanmin([*values.values()]
anchor 0 and vertex 0 exist; only -1 is none
    rows >= 0 -> rows > 0
    columns >= 0 -> columns > 0
vertex 0 exists; only -1 is none
    columns >= 0 -> columns > 0
-1 is no vertex: to numpy it is the last one; there the sequence ends
    columns >= 0 -> True
-1 is no anchor: to numpy it is the last one; before row 0 the sequence ends
    rows >= 0 -> rows >= -len(reach)
in the second direction both fingers start again from the pair itself
    rows, columns = np.indices(reach.shape) -> pass
    values = [reach] -> values, (rows, columns) = [reach], np.indices(reach.shape)
    rows + direction, beside[columns]
        -> np.where(there, (rows + direction, beside[columns]), (rows, columns))
a sequence ends on its own side only; the other one may be longer
    return -> sides = np.reshape(values[1:], (2, steps, *reach.shape)); return
    nanmin(values -> nanmin([reach, *(sides[0] + 0 * sides[1]), *(sides[1] + 0 * sides[0])]
yours goes one anchor less far than steps says: range(steps) has steps of them
    range(steps) -> range(steps - 1)
the anchors before count, too
    (-1, before), (1, after) -> (1, after),
the anchors after count, too
    (-1, before), (1, after) -> (-1, before),
before goes with the anchor before, after with the one after: both move in the same direction
    (-1, before), (1, after) -> (1, before), (-1, after)
only one anchor on either side counts in yours; go on for as many as steps says
    range(steps) -> range(min(steps, 1))
yours goes one anchor farther than steps says
    range(steps) -> range(steps + 1)
the neighbours on either side count as well
    range(steps) -> range(0)
the vertex moves along its trajectory, too: before and after
    beside[columns] -> columns
the anchor moves along its trajectory, too: row - 1 and row + 1
    rows + direction -> rows
the next vertex along a trajectory is after[v], not v + 1
    values = [reach] -> values, number = [reach], np.arange(len(before))
    (-1, before), (1, after) -> (-1, number - 1), (1, np.append(number[1:], -1))
-1 is no vertex, and no anchor: there the sequence ends
    rows >= 0 -> rows >= -len(reach)
    columns >= 0 -> True
after a -1 the sequence has ended: break, and do not go on from there
    there = there & -> there =
where a trajectory ends the sequence is shorter; what does not exist is not 0
    np.nan) -> 0.0)
the pair itself counts, too
    values = [reach] -> values = [np.ones_like(reach)]
"""
_BACK, _AHEAD = (
    edited(weakest_aligned, [("(-1, before), (1, after)", one)])
    for one in ("(-1, before),", "(1, after),")
)


def _of_neighbours(reach: Array, before: Indices, after: Indices, steps: int) -> Array:
    """Repeatedly, the least of each pair and of what its neighbour has found."""
    for one_way in [_BACK] * steps + [_AHEAD] * steps:
        reach = one_way(reach, before, after, 1)
    return reach


def _first_wrong(got: Array, want: Array) -> list[int]:
    return np.argwhere(~np.isclose(got, want, rtol=0, atol=1e-9))[0].tolist()


def _broken(got: Array, want: Array, *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken at the first pair that is wrong."""
    i, v = _first_wrong(got, want)
    if got[i, v] < want[i, v]:
        return (
            "yours counts a pair that is not aligned: both fingers move together, one row and one "
            "vertex along its trajectory, and compare with reach as it was"
        )
    return (
        "yours leaves out an aligned pair: the least RE of all of them counts, on both sides up "
        "to `steps` away, on each until that side ends"
    )


def _why(got: Array, want: Array, reach: Array, before: Indices, after: Indices, steps: int) -> str:
    """The first pair that is wrong, and what counts for it."""
    if np.isnan(got).any():
        return "some of it is not a number; every pair has at least its own RE"
    i, v = _first_wrong(got, want)
    pairs = {(i, v): reach[i, v]}
    for step, beside in ((-1, before), (1, after)):
        row, column = i + step, beside[v]
        for _ in range(steps):
            if not 0 <= row < len(reach) or column < 0:
                break
            pairs[row, int(column)] = reach[row, column]
            row, column = row + step, beside[column]
    shown = ", ".join(f"{pair}: {value:.2f}" for pair, value in sorted(pairs.items()))
    words = f"the least of the aligned pairs is {want[i, v]:.2f} ({shown})"
    return f"for anchor {i} and vertex {v} {words}; yours has {got[i, v]:.2f}"


def _per_pair(what: str, got: object, reach: Array, *_: object) -> Array:
    values = numbers(what, got, reach.shape)
    if isinstance(got, np.ndarray) and got.dtype.kind in "iu":
        raise WrongAnswer(f"{what}: your array holds whole numbers, and cuts RE off; dtype=float")
    return values


def _tables(want: Array, got: Array) -> NDArray[np.uint8]:
    reach = CASES["one trajectory beside another"][0]
    given, *both = (edge_table(one, one > 0.5, names=("a", "v")) for one in (reach, want, got))
    below = side_by_side(both, ["expected", "yours"])
    return stacked([given, below], ["RE", ""], gap=0)


check_weakest_aligned = exercise(
    weakest_aligned,
    CASES,
    MISTAKES,
    about="Tables with longer and shorter sequences, several trajectories, vertices in no order.",
    example=case(random_reach(4, 6, 7), *TWO, 2),
    others={
        "look along the trajectories from each pair itself; the least that a neighbour has found "
        "may lie on another one, where a trajectory runs into it": _of_neighbours,
    },
    invoke=calling({IndexError: "where a trajectory ends the sequence ends, too"}),
    form=_per_pair,
    same=partial(close, tolerance=1e-9),
    difference=_why,
    broken=_broken,
    draw=_tables,
)
