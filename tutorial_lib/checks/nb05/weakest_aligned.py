"""The check of aligned sequences, in notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import calling, numbers
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import close, compare, with_faults
from tutorial_lib.checks.nb05.trajectories import JOINED, MIXED, ONE, TWO, random_reach, stepped
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.viz.figures.edge_tables import edge_table
from tutorial_lib.viz.figures.panels import side_by_side


def weakest_aligned(reach: Array, before: Indices, after: Indices, steps: int) -> Array:
    """The least RE (A, V) over aligned sequences around each pair (Meng 2020, III-G).

    Args:
        reach: (A, V) RE from each anchor of a trajectory, in order, to each vertex.
        before: (V,) the vertex before each on its own trajectory, -1 for none.
        after: (V,) the vertex after each.
        steps: anchors on either side.
    """
    least = np.array(reach, dtype=float)
    count = len(least)
    for direction in (-1, 1):
        columns = np.arange(least.shape[1])
        for step in range(direction, direction * (steps + 1), direction):
            columns = stepped(columns, direction, before, after)
            rows = np.arange(max(0, -step), min(count, count - step))
            beside = np.asarray(reach)[np.ix_(rows + step, columns)]
            there = np.where(columns >= 0, beside, 1.0)
            least[rows] = np.minimum(least[rows], there)
    return least


_CASES = {
    "one trajectory beside another": (random_reach(5, 5, 1), *ONE, 2),
    "one anchor before and after": (random_reach(5, 5, 2), *ONE, 1),
    "no neighbours": (random_reach(4, 6, 3), *TWO, 0),
    "two trajectories on the map": (random_reach(6, 6, 4), *TWO, 2),
    "vertices in no order": (random_reach(5, 7, 5), *MIXED, 2),
    "trajectories that run into another": (random_reach(5, 5, 23), *JOINED, 2),
    "one anchor": (random_reach(1, 7, 6), *MIXED, 2),
    "three anchors on either side": (random_reach(8, 7, 31), *MIXED, 3),
    "sequences longer than the trajectories": (random_reach(4, 5, 32), *ONE, 9),
    "more vertices than anchors": (random_reach(3, 7, 33), *MIXED, 1),
    "RE with many digits": (np.random.default_rng(35).random((5, 6)), *TWO, 2),
    "one vertex": (random_reach(4, 1, 34), np.array([-1]), np.array([-1]), 2),
}


@check(weakest_aligned, (random_reach(4, 6, 7), *TWO, 2))
def check_weakest_aligned(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """Tables with longer and shorter sequences, several trajectories, vertices in no order."""
    faults = with_faults(_misaligned, _FAULTS)
    return compare(
        "weakest_aligned",
        student,
        _CASES,
        weakest_aligned,
        faults,
        invoke=calling({IndexError: "where a trajectory ends the sequence ends, too"}),
        form=_per_pair,
        same=partial(close, tolerance=1e-9),
        difference=_why,
        broken=_broken,
        draw=_tables,
    )


def _broken(got: Array, want: Array, *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken at the first pair that is wrong."""
    i, v = (int(n) for n in np.argwhere(~np.isclose(got, want, rtol=0, atol=1e-9))[0])
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
    i, v = (int(n) for n in np.argwhere(~np.isclose(got, want, rtol=0, atol=1e-9))[0])
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


def _misaligned(reach: Array, before: Indices, after: Indices, steps: int, fault: str) -> Array:
    """The rule with a `fault`, pair by pair."""
    steps = {"one step": min(steps, 1), "three": steps + 1, "none": 0}.get(fault, steps)
    steps = max(steps - 1, 0) if fault == "one less" else steps
    steps = {"always two": 2, "always one": 1}.get(fault, steps)
    fold = {"mean": np.mean, "product": np.prod, "greatest": np.max}.get(fault, np.min)
    directions = ((-1, before), (1, after))
    if fault == "crossed":
        directions = ((1, before), (-1, after))
    if fault in ("only after", "only before"):
        directions = directions[1:] if fault == "only after" else directions[:1]
    if fault == "of neighbours":
        return _of_neighbours(reach, directions, steps)
    found = np.empty_like(reach)
    for pair in np.ndindex(*reach.shape):
        values = [] if fault == "not itself" else [reach[pair]]
        if fault == "together":
            found[pair] = _on_both_sides(reach, pair, directions, steps)
            continue
        start = pair
        for step, beside in directions:
            if fault == "goes on from the end":
                found_here, start = _from(reach, start, step, beside, steps)
                values += found_here
                continue
            found_here = _along(reach, pair, step, beside, steps, fault)
            values += found_here[-1:] if fault == "farthest" else found_here
        if fault == "end is 0" and len(values) < 2 * steps + 1:
            values.append(0.0)
        found[pair] = fold(values) if values else 1.0
    return found


def _from(
    reach: Array, start: tuple[int, ...], step: int, beside: Indices, steps: int
) -> tuple[list[float], tuple[int, ...]]:
    """RE of the pairs to one side, and where a finger is that was moved beyond the end."""
    (row, column), values = start, []
    for _ in range(steps):
        row, column = row + step, int(beside[column])
        if not 0 <= row < len(reach) or column < 0:
            break
        values.append(reach[row, column])
    return values, (row, column)


def _on_both_sides(
    reach: Array, pair: tuple[int, ...], directions: tuple[tuple[int, Indices], ...], steps: int
) -> float:
    """The least RE where a sequence ends on both sides as soon as it ends on one."""
    sides = [_along(reach, pair, step, beside, steps, "") for step, beside in directions]
    shorter = min(map(len, sides))
    return min([reach[pair], *(value for side in sides for value in side[:shorter])])


def _of_neighbours(reach: Array, directions: tuple[tuple[int, Indices], ...], steps: int) -> Array:
    """Repeatedly, the least of each pair and of what its neighbour has found."""
    least = reach.copy()
    for step, beside in directions:
        for _ in range(steps):
            padded = np.pad(least, ((1, 1), (0, 1)), constant_values=np.inf)
            least = np.minimum(least, padded[1 + step : 1 + step + len(least)][:, beside])
    return least


def _along(
    reach: Array, pair: tuple[int, ...], step: int, beside: Indices, steps: int, fault: str
) -> list[float]:
    """RE of the pairs to one side of one pair."""
    (row, column), values = pair, []
    for _ in range(steps):
        row = row if fault == "row stays" else row + step
        if fault == "by number":
            column += step
            column = column if 0 <= column < reach.shape[1] else -1
        elif fault != "column stays":
            column = int(beside[column])
        if fault == "wraps" and -len(reach) <= row < len(reach):
            values.append(reach[row, column])
            continue
        if fault == "no vertex 0" and column == 0:
            break
        if fault == "column wraps" and 0 <= row < len(reach):
            values.append(reach[row, column])
            continue
        if fault == "row wraps" and -len(reach) <= row < len(reach) and column >= 0:
            values.append(reach[row, column])
            continue
        if fault == "no 0" and (row == 0 or column == 0):
            break
        if not 0 <= row < len(reach) or column < 0:
            if fault == "goes on":
                continue
            break
        values.append(reach[row, column])
    return values


_FAULTS = {
    "the least of them counts, not their mean": "mean",
    "the least of them counts, not their product": "product",
    "the least of them counts, not the greatest": "greatest",
    "steps is an argument; yours always looks two anchors to either side": "always two",
    "steps is an argument; yours always looks one anchor to either side": "always one",
    "all pairs on the way count, not only the farthest on either side": "farthest",
    "anchor 0 and vertex 0 exist; only -1 is none": "no 0",
    "vertex 0 exists; only -1 is none": "no vertex 0",
    "-1 is no vertex: to numpy it is the last one; there the sequence ends": "column wraps",
    "-1 is no anchor: to numpy it is the last one; before row 0 the sequence ends": "row wraps",
    "in the second direction both fingers start again from the pair itself": (
        "goes on from the end"
    ),
    "a sequence ends on its own side only; the other one may be longer": "together",
    "yours goes one anchor less far than steps says: range(steps) has steps of them": "one less",
    "the anchors before count, too": "only after",
    "the anchors after count, too": "only before",
    "before goes with the anchor before, after with the one after: both move in the same "
    "direction": "crossed",
    "only one anchor on either side counts in yours; go on for as many as steps says": "one step",
    "yours goes one anchor farther than steps says": "three",
    "the neighbours on either side count as well": "none",
    "the vertex moves along its trajectory, too: before and after": "column stays",
    "the anchor moves along its trajectory, too: row - 1 and row + 1": "row stays",
    "the next vertex along a trajectory is after[v], not v + 1": "by number",
    "-1 is no vertex, and no anchor: there the sequence ends": "wraps",
    "after a -1 the sequence has ended: break, and do not go on from there": "goes on",
    "look along the trajectories from each pair itself; the least that a neighbour has found may "
    "lie on another one, where a trajectory runs into it": "of neighbours",
    "where a trajectory ends the sequence is shorter; what does not exist is not 0": "end is 0",
    "the pair itself counts, too": "not itself",
}


def _tables(want: Array, got: Array) -> NDArray[np.uint8]:
    reach = _CASES["one trajectory beside another"][0]
    tables = [edge_table(least, least > 0.5, names=("a", "v")) for least in (reach, want, got)]
    return side_by_side(tables, ["RE", "target", "yours"], gap=24)
