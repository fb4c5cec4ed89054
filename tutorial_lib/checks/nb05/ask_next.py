"""The check of the search along trajectories, in notebook 05."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import calling, mask
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.nb05.trajectories import MIXED, ONE, TWO, random_reach, stepped
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.viz.figures.edge_tables import edge_table
from tutorial_lib.viz.figures.panels import side_by_side

_BESIDE = ((1, 1), (-1, -1), (0, 1), (0, -1))


def ask_next(reach: Array, before: Indices, after: Indices, p_edge: float) -> NDArray[np.bool_]:
    """(A, V) pairs not evaluated yet that lie beside a sure one along their trajectories.

    Args:
        reach: (A, V) RE, NaN where not evaluated.
        before: (V,) the vertex before each on its trajectory, -1 for none.
        after: (V,) the vertex after each.
        p_edge: RE above which a pair is sure.
    """
    return _queried(reach, before, after, p_edge)


def _queried(
    reach: Array, before: Indices, after: Indices, p_edge: float, fault: str = ""
) -> NDArray[np.bool_]:
    """The rule with a `fault`, if one is named."""
    found = np.zeros(reach.shape, dtype=bool)
    p_edge = {"always 0.5": 0.5, "always 0.99": 0.99}.get(fault, p_edge)
    sure = {"equal": reach >= p_edge, "all": ~np.isnan(reach), "unsure": reach <= p_edge}.get(
        fault, reach > p_edge
    )
    pairs = {"diagonal": _BESIDE[:2], "across": _BESIDE[2:], "one direction": _BESIDE[::2]}
    pairs |= {f"without {i}": (*_BESIDE[:i], *_BESIDE[i + 1 :]) for i in range(4)}
    pairs |= {"straight": (*_BESIDE[:2], (1, 0), (-1, 0))}
    if fault == "not low":
        sure = ~(reach <= p_edge)
    if fault == "best of each":
        best = np.where(np.isnan(reach), -1.0, reach).argmax(axis=1)
        sure &= np.arange(reach.shape[1]) == best[:, None]
    if fault == "first only":
        sure &= np.cumsum(sure).reshape(sure.shape) == 1
    steps = pairs.get(fault, _BESIDE)
    if fault == "rows":
        steps = (*_BESIDE, (1, 0), (-1, 0))
    if fault == "crossed":
        steps = ((1, -1), (-1, 1), *_BESIDE[2:])
    rows, columns = np.nonzero(sure)
    for along, across in steps:
        beside = stepped(columns, across, before, after)
        if fault == "by number":
            beside = columns + across
        ahead = rows + along
        exist = (ahead >= 0) & (ahead < len(reach)) & (beside < reach.shape[1])
        if fault == "no column 0":
            exist &= beside > 0
        if fault == "no row 0":
            exist &= ahead > 0
        if fault == "no last row":
            exist &= ahead < len(reach) - 1
        if fault == "no last column":
            exist &= beside < reach.shape[1] - 1
        if fault == "wraps":
            exist = ahead < len(reach)
        elif fault == "row wraps":
            exist = (ahead < len(reach)) & (beside >= 0)
        elif fault != "column wraps":
            exist &= beside >= 0
        found[ahead[exist], beside[exist]] = True
    if fault == "all unknown":
        return np.isnan(reach)
    if fault == "or":
        return found | np.isnan(reach)
    if fault == "known":
        return found & ~np.isnan(reach)
    if fault == "nothing":
        return np.zeros_like(found)
    return found if fault == "again" else found & np.isnan(reach)


def _holes(reach: Array, share: float, seed: int) -> Array:
    """RE of which a share was not evaluated."""
    rng = np.random.default_rng(seed)
    return np.where(rng.random(reach.shape) < share, np.nan, reach)


_FEW = np.full((5, 6), np.nan)
_FEW[2, 1], _FEW[0, 4], _FEW[4, 5] = 0.95, 0.4, 0.9
_CASES = {
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
_FAULTS = {
    "query no pair twice: only where reach is not a number": "again",
    "only neighbours of pairs that are sure are worth it: reach > p_edge": "all",
    "the neighbours of pairs that are sure are worth it, not of the others": "unsure",
    "yours never queries anything. Is np.isnan used? Nothing is == np.nan, not even np.nan": (
        "nothing"
    ),
    "not all that is unknown is worth a query, only what lies beside a sure pair": "all unknown",
    "a pair must be both unknown and beside a sure one: &, not |": "or",
    "query what is not a number yet, not what is known already": "known",
    "nan is not sure: it is neither above nor below p_edge, so ask reach > p_edge": "not low",
    "every sure pair counts, not only the best one of each anchor": "best of each",
    "every sure pair counts, not only the first one": "first only",
    "of the four neighbours (i + 1, after[v]) is missing": "without 0",
    "of the four neighbours (i - 1, before[v]) is missing": "without 1",
    "of the four neighbours (i, after[v]) is missing": "without 2",
    "of the four neighbours (i, before[v]) is missing": "without 3",
    "two of the four neighbours are of the same anchor: (i, after[v]) and (i, before[v])": (
        "straight"
    ),
    "p_edge is an argument, and not always 0.5": "always 0.5",
    "p_edge is an argument, and not always 0.99": "always 0.99",
    "column 0 is a vertex, too": "no column 0",
    "row 0 is an anchor, too": "no row 0",
    "the last row is an anchor, too": "no last row",
    "the last column is a vertex, too": "no last column",
    "greater than p_edge, not equal to it": "equal",
    "the vertices before and after the same vertex, for the same anchor, are worth it, too": (
        "diagonal"
    ),
    "when both move on by one they look alike again: query anchor +- 1 and the vertex after or "
    "before": "across",
    "look in both directions along the trajectories": "one direction",
    "the same vertex for the next anchor is none of the four neighbours": "rows",
    "both move in the same direction: the next anchor and the vertex after": "crossed",
    "the next vertex along a trajectory is after[v], not v + 1": "by number",
    "-1 is no vertex: where after or before is -1 there is nothing to query": "column wraps",
    "-1 is no anchor: before the first one there is nothing to query": "row wraps",
    "-1 is no vertex, and no anchor; beyond an end there is nothing to query": "wraps",
}


@check(ask_next, (_holes(random_reach(6, 7, 13), 0.7, 14), *MIXED, 0.6))
def check_ask_next(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """Tables of which little, nothing or everything is known, and vertices in no order."""
    faults = with_faults(_queried, _FAULTS)
    words = "beyond an end of a trajectory there is nothing to query"
    return compare(
        "ask_next",
        student,
        _CASES,
        ask_next,
        faults,
        invoke=calling({IndexError: words}),
        form=_pairs,
        difference=_why,
        broken=_broken,
        draw=_tables,
    )


def _broken(got: NDArray[np.bool_], want: NDArray[np.bool_], *_: object) -> str:
    """Which part of the rule is broken."""
    if (want & ~got).any():
        return "all four neighbours of every sure pair are asked next, where nobody has asked yet"
    return "only the four neighbours of pairs that are sure now are asked next, none beyond them"


def _why(
    got: NDArray[np.bool_],
    want: NDArray[np.bool_],
    reach: Array,
    before: Indices,
    after: Indices,
    p_edge: float,
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


def _pairs(what: str, got: object, reach: Array, *_: object) -> NDArray[np.bool_]:
    return mask(what, got, reach.shape)


def _tables(want: NDArray[np.bool_], got: NDArray[np.bool_]) -> NDArray[np.uint8]:
    tables = [edge_table(_FEW, fresh, names=("a", "v"), blank=True) for fresh in (want, got)]
    return side_by_side(tables, ["target", "yours"], gap=30)
