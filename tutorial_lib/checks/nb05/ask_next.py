"""The check of the search along trajectories, in notebook 05."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import Mask, calling, case, exercise, mask
from tutorial_lib.checks.nb05.trajectories import MIXED, ONE, TWO, random_reach
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.viz.figures.edge_tables import edge_table
from tutorial_lib.viz.figures.panels import side_by_side


def ask_next(reach: Array, before: Indices, after: Indices, p_edge: float) -> Mask:
    """(A, V) pairs not evaluated yet that lie beside a sure one along their trajectories."""
    found = np.zeros(reach.shape, dtype=bool)
    rows, columns = np.nonzero(reach > p_edge)
    for step, beside in ((1, after), (-1, before), (0, after), (0, before)):
        row, column = rows + step, beside[columns]
        there = (row >= 0) & (row < len(reach)) & (column >= 0)
        found[row[there], column[there]] = True
    return found & np.isnan(reach)


def _holes(reach: Array, share: float, seed: int) -> Array:
    """RE of which a share was not evaluated."""
    rng = np.random.default_rng(seed)
    return np.where(rng.random(reach.shape) < share, np.nan, reach)


_FEW = np.full((5, 6), np.nan)
_FEW[2, 1], _FEW[0, 4], _FEW[4, 5] = 0.95, 0.4, 0.9
CASES = {
    "three pairs known": (_FEW, *TWO, 0.8),
    "nothing known": (np.full((3, 6), np.nan), *TWO, 0.8),
    "everything known": (random_reach(4, 6, 8), *TWO, 0.5),
    "RE equals p_edge": (np.where(_FEW == 0.95, 0.8, _FEW), *TWO, 0.8),
    "vertices in no order": (_holes(random_reach(6, 7, 9), 0.7, 10), *MIXED, 0.6),
    "a larger one": (_holes(random_reach(9, 7, 11), 0.8, 12), *MIXED, 0.5),
    "another p_edge": (_holes(random_reach(9, 7, 15), 0.6, 16), *MIXED, 0.9),
    "more vertices than anchors": (_holes(random_reach(2, 7, 17), 0.6, 18), *MIXED, 0.3),
    "one anchor": (_holes(random_reach(1, 6, 19), 0.5, 20), *TWO, 0.2),
    "one long trajectory": (_holes(random_reach(7, 5, 21), 0.6, 22), *ONE, 0.4),
}
MISTAKES = """
query no pair twice: only where reach is not a number
    found & np.isnan(reach) -> found
only neighbours of pairs that are sure are worth it: reach > p_edge
    reach > p_edge -> ~np.isnan(reach)
the neighbours of pairs that are sure are worth it, not of the others
    reach > p_edge -> reach <= p_edge
yours never queries anything. Is np.isnan used? Nothing is == np.nan, not even np.nan
    np.isnan(reach) -> (reach == np.nan)
not all that is unknown is worth a query, only what lies beside a sure pair
    found & np.isnan(reach) -> np.isnan(reach)
a pair must be both unknown and beside a sure one: &, not |
    found & -> found |
query what is not a number yet, not what is known already
    & np.isnan -> & ~np.isnan
nan is not sure: it is neither above nor below p_edge, so ask reach > p_edge
    reach > p_edge -> ~(reach <= p_edge)
every sure pair counts, not only the best one of each anchor
    reach > p_edge -> (reach > p_edge) & (reach == np.fmax.reduce(reach, axis=1, keepdims=True))
every sure pair counts, not only the first one
    np.nonzero(reach > p_edge) -> np.argwhere(reach > p_edge)[:1].T
of the four neighbours (i + 1, after[v]) is missing
    (1, after), (-1, before), -> (-1, before),
of the four neighbours (i - 1, before[v]) is missing
    (1, after), (-1, before), -> (1, after),
of the four neighbours (i, after[v]) is missing
    (0, after), (0, before) -> (0, before),
of the four neighbours (i, before[v]) is missing
    (0, after), (0, before) -> (0, after),
two of the four neighbours are of the same anchor: (i, after[v]) and (i, before[v])
    (0, after), (0, before) -> (1, np.arange(len(after))), (-1, np.arange(len(after)))
p_edge is an argument, and not always 0.5
    > p_edge -> > 0.5
p_edge is an argument, and not always 0.99
    > p_edge -> > 0.99
column 0 is a vertex, too
    column >= 0 -> column > 0
row 0 is an anchor, too
    row >= 0 -> row > 0
the last row is an anchor, too
    < len(reach) -> < len(reach) - 1
the last column is a vertex, too
    (column >= 0) -> (column >= 0) & (column < len(after) - 1)
greater than p_edge, not equal to it
    reach > p_edge -> reach >= p_edge
the vertices before and after the same vertex, for the same anchor, are worth it, too
    (-1, before), (0, after), (0, before) -> (-1, before)
when both move on by one they look alike again: query anchor +- 1 and the vertex after or before
    (1, after), (-1, before), (0, after) -> (0, after)
look in both directions along the trajectories
    (-1, before), (0, after), (0, before) -> (0, after)
the same vertex for the next anchor is none of the four neighbours
    (0, before) -> (0, before), (1, np.arange(len(after))), (-1, np.arange(len(after)))
both move in the same direction: the next anchor and the vertex after
    (1, after), (-1, before) -> (1, before), (-1, after)
the next vertex along a trajectory is after[v], not v + 1
    found = -> before, after = (np.arange(len(after)) + step for step in (-1, 1)); found =
    (column >= 0) -> (column >= 0) & (column < len(after))
-1 is no vertex: where after or before is -1 there is nothing to query
    & (column >= 0) -> & True
-1 is no anchor: before the first one there is nothing to query
    row >= 0 -> True
-1 is no vertex, and no anchor; beyond an end there is nothing to query
    row >= 0 -> True
    & (column >= 0) -> & True
"""


def _broken(got: Mask, want: Mask, *_: object) -> str:
    """Which part of the rule is broken."""
    if (want & ~got).any():
        return "all four neighbours of every sure pair are asked next, where nobody has asked yet"
    return "only the four neighbours of pairs that are sure now are asked next, none beyond them"


def _why(
    got: Mask, want: Mask, reach: Array, before: Indices, after: Indices, p_edge: float
) -> str:
    """The first pair about which an answer is wrong."""
    i, v = (int(n) for n in np.argwhere(got != want)[0])
    if got[i, v] and not np.isnan(reach[i, v]):
        return f"({i}, {v}) was evaluated already: {reach[i, v]:g}; query no pair twice"
    if got[i, v]:
        return f"({i}, {v}) is not beside any pair above {p_edge:g}; yours queries it"
    for row, column in np.argwhere(reach > p_edge):
        steps = {(row + 1, after[column]), (row - 1, before[column])}
        steps |= {(row, after[column]), (row, before[column])}
        if (i, v) in steps:
            return f"({i}, {v}) is beside the sure pair ({row}, {column}); yours does not query it"
    return f"({i}, {v}) must be queried"


def _tables(want: Mask, got: Mask) -> NDArray[np.uint8]:
    tables = [edge_table(_FEW, fresh, names=("a", "v"), blank=True) for fresh in (want, got)]
    return side_by_side(tables, ["expected", "yours"], gap=30)


check_ask_next = exercise(
    ask_next,
    CASES,
    MISTAKES,
    about="Tables of which little, nothing or everything is known, and vertices in no order.",
    example=case(_holes(random_reach(6, 7, 13), 0.7, 14), *MIXED, 0.6),
    invoke=calling({IndexError: "beyond an end of a trajectory there is nothing to query"}),
    form=lambda what, got, reach, *_: mask(what, got, reach.shape),
    difference=_why,
    broken=_broken,
    draw=_tables,
)
