"""Checks of notebook 05: aligned sequences, and the search along trajectories."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.answers import called, explained, mask
from tutorial_lib.checks.check import WrongAnswer, check, expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.topology.vertices import Numbers
from tutorial_lib.viz.map_rules import table
from tutorial_lib.viz.panels import side_by_side

_BESIDE = ((1, 1), (-1, -1), (0, 1), (0, -1))


def _neighbours(*trails: list[int]) -> tuple[Numbers, Numbers]:
    """(V,) the vertex before and after each, -1 for none."""
    before, after = np.full((2, sum(map(len, trails))), -1)
    for trail in trails:
        before[trail[1:]], after[trail[:-1]] = trail[:-1], trail[1:]
    return before, after


def _reach(anchors: int, vertices: int, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(0.05, 1.0, (anchors, vertices)).round(2)


def weakest_aligned(reach: Array, before: Numbers, after: Numbers, steps: int) -> Array:
    """The least RE (A, V) over aligned sequences around each pair (Meng 2020, III-G).

    Args:
        reach: (A, V) RE from each anchor of a trajectory, in order, to each vertex.
        before: (V,) the vertex before each on its own trajectory, -1 for none.
        after: (V,) the vertex after each.
        steps: anchors on either side.
    """
    least = np.array(reach, dtype=float)
    count = len(least)
    for way in (-1, 1):
        columns = np.arange(least.shape[1])
        for step in range(way, way * (steps + 1), way):
            columns = _stepped(columns, way, before, after)
            rows = np.arange(max(0, -step), min(count, count - step))
            beside = np.asarray(reach)[np.ix_(rows + step, columns)]
            there = np.where(columns >= 0, beside, 1.0)
            least[rows] = np.minimum(least[rows], there)
    return least


def _stepped(columns: Numbers, step: int, before: Numbers, after: Numbers) -> Numbers:
    """The column one `step` of -1, 0 or 1 on along its trajectory; -1 beyond an end."""
    if not step:
        return columns
    return np.where(columns >= 0, (after if step > 0 else before)[columns], -1)


_ONE, _TWO = _neighbours([0, 1, 2, 3, 4]), _neighbours([0, 1, 2], [3, 4, 5])
_MIXED = _neighbours([4, 0, 6, 2], [1, 5, 3])
_ALIGNED = {
    "one drive beside another": (_reach(5, 5, 1), *_ONE, 2),
    "one anchor before and after": (_reach(5, 5, 2), *_ONE, 1),
    "no neighbours": (_reach(4, 6, 3), *_TWO, 0),
    "two drives on the map": (_reach(6, 6, 4), *_TWO, 2),
    "vertices numbered in no order": (_reach(5, 7, 5), *_MIXED, 2),
    "one anchor": (_reach(1, 7, 6), *_MIXED, 2),
}


@check(weakest_aligned, (_reach(4, 6, 7), *_TWO, 2))
def check_weakest_aligned(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """Six tables: longer and shorter sequences, several drives, numbers in no order."""
    answers = []
    for name, case in _ALIGNED.items():
        try:
            answers.append(called(student, *case))
        except IndexError as error:
            words = f"IndexError, {error}; where a trajectory ends the sequence ends, too"
            raise WrongAnswer(f"weakest_aligned, {name}: {words}") from None
    picture = _tables(answers[0])
    for (name, case), got in zip(_ALIGNED.items(), answers, strict=True):
        right = weakest_aligned(*case)
        mistakes = {words: partial(_misaligned, fault=f)(*case) for words, f in _FAULTS.items()}
        expect_close(f"weakest_aligned, {name}", got, right, 1e-9, mistakes, picture)
    return picture


def _misaligned(reach: Array, before: Numbers, after: Numbers, steps: int, fault: str) -> Array:
    """The rule with a `fault`, pair by pair."""
    steps = {"one step": min(steps, 1), "three": steps + 1, "none": 0}.get(fault, steps)
    fold = {"mean": np.mean, "product": np.prod, "greatest": np.max}.get(fault, np.min)
    ways = ((-1, before), (1, after))
    if fault == "crossed":
        ways = ((1, before), (-1, after))
    if fault in ("only after", "only before"):
        ways = ways[1:] if fault == "only after" else ways[:1]
    found = np.empty_like(reach)
    for pair in np.ndindex(*reach.shape):
        values = [] if fault == "not itself" else [reach[pair]]
        for step, beside in ways:
            values += _along(reach, pair, step, beside, steps, fault)
        if fault == "end is 0" and len(values) < 2 * steps + 1:
            values.append(0.0)
        found[pair] = fold(values) if values else 1.0
    return found


def _along(
    reach: Array, pair: tuple[int, ...], step: int, beside: Numbers, steps: int, fault: str
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
        if not 0 <= row < len(reach) or column < 0:
            break
        values.append(reach[row, column])
    return values


_FAULTS = {
    "the least of them counts, not their mean": "mean",
    "the least of them counts, not their product": "product",
    "the least of them counts, not the greatest": "greatest",
    "the anchors before count, too": "only after",
    "the anchors after count, too": "only before",
    "before goes with the anchor before, after with the one after: both move the same way": (
        "crossed"
    ),
    "only one anchor on either side counts in yours; go on for as many as steps says": "one step",
    "yours goes one anchor farther than steps says": "three",
    "the neighbours on either side count as well": "none",
    "the vertex moves along its trajectory, too: before and after": "column stays",
    "the anchor moves along its trajectory, too: row - 1 and row + 1": "row stays",
    "the next vertex along a trajectory is after[v], not v + 1": "by number",
    "-1 is no vertex, and no anchor: there the sequence ends": "wraps",
    "where a trajectory ends the sequence is shorter; what does not exist is not 0": "end is 0",
    "the pair itself counts, too": "not itself",
}


def _tables(got: object) -> NDArray[np.uint8]:
    reach = _ALIGNED["one drive beside another"][0]
    pictures, titles = [table(reach, reach > 0.5, names=("a", "v"))], ["RE"]
    for title, least in (
        ("target", weakest_aligned(*_ALIGNED["one drive beside another"])),
        ("yours", got),
    ):
        if isinstance(least, np.ndarray) and least.shape == reach.shape:
            pictures.append(table(least, least > 0.5, names=("a", "v")))
            titles.append(title)
    return side_by_side(pictures, titles, gap=24)


def ask_next(told: Array, before: Numbers, after: Numbers, p_edge: float) -> NDArray[np.bool_]:
    """(A, V) pairs that nobody asked about, beside one along their trajectories that is sure.

    Args:
        told: (A, V) RE, not a number where nobody asked.
        before: (V,) the vertex before each on its trajectory, -1 for none.
        after: (V,) the vertex after each.
        p_edge: RE from which on a pair is sure.
    """
    return _asked(told, before, after, p_edge)


def _asked(
    told: Array, before: Numbers, after: Numbers, p_edge: float, fault: str = ""
) -> NDArray[np.bool_]:
    """The rule with a `fault`, if one is named."""
    found = np.zeros(told.shape, dtype=bool)
    sure = {"equal": told >= p_edge, "all": ~np.isnan(told), "unsure": told <= p_edge}.get(
        fault, told > p_edge
    )
    pairs = {"diagonal": _BESIDE[:2], "across": _BESIDE[2:], "one way": _BESIDE[::2]}
    steps = pairs.get(fault, _BESIDE)
    if fault == "rows":
        steps = (*_BESIDE, (1, 0), (-1, 0))
    if fault == "crossed":
        steps = ((1, -1), (-1, 1), *_BESIDE[2:])
    rows, columns = np.nonzero(sure)
    for along, across in steps:
        beside = _stepped(columns, across, before, after)
        if fault == "by number":
            beside = columns + across
        ahead = rows + along
        exist = (ahead >= 0) & (ahead < len(told)) & (beside < told.shape[1])
        if fault == "wraps":
            exist = ahead < len(told)
        else:
            exist &= beside >= 0
        found[ahead[exist], beside[exist]] = True
    return found if fault == "again" else found & np.isnan(told)


def _holes(reach: Array, share: float, seed: int) -> Array:
    """RE of which a share was never asked about."""
    rng = np.random.default_rng(seed)
    return np.where(rng.random(reach.shape) < share, np.nan, reach)


_FEW = np.full((5, 6), np.nan)
_FEW[2, 1], _FEW[0, 4], _FEW[4, 5] = 0.95, 0.4, 0.9
_SEARCHES = {
    "three pairs known": (_FEW, *_TWO, 0.8),
    "nothing known": (np.full((3, 6), np.nan), *_TWO, 0.8),
    "everything known": (_reach(4, 6, 8), *_TWO, 0.5),
    "RE equals p_edge": (np.where(_FEW == 0.95, 0.8, _FEW), *_TWO, 0.8),
    "vertices numbered in no order": (_holes(_reach(6, 7, 9), 0.7, 10), *_MIXED, 0.6),
    "a larger one": (_holes(_reach(9, 7, 11), 0.8, 12), *_MIXED, 0.5),
}
_MISSED = {
    "ask about no pair twice: only where told is not a number": "again",
    "only neighbours of pairs that are sure are worth it: told > p_edge": "all",
    "the neighbours of pairs that are sure are worth it, not of the others": "unsure",
    "greater than p_edge, not equal to it": "equal",
    "the vertices before and after the same vertex, for the same anchor, are worth it, too": (
        "diagonal"
    ),
    "when both move on by one they look alike again: ask about anchor +- 1 and the vertex after "
    "or before": "across",
    "look in both directions along the trajectories": "one way",
    "the same vertex for the next anchor is none of the four neighbours": "rows",
    "both move the same way: the next anchor and the vertex after": "crossed",
    "the next vertex along a trajectory is after[v], not v + 1": "by number",
    "-1 is no vertex, and no anchor; beyond an end there is nothing to ask": "wraps",
}


@check(ask_next, (_holes(_reach(6, 7, 13), 0.7, 14), *_MIXED, 0.6))
def check_ask_next(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """Six tables: little known, nothing, everything, numbers in no order."""
    answers = []
    for name, case in _SEARCHES.items():
        what = f"ask_next, {name}"
        try:
            got = called(student, *case)
        except IndexError as error:
            words = f"IndexError, {error}; beyond an end of a trajectory there is nothing to ask"
            raise WrongAnswer(f"{what}: {words}") from None
        answers.append(mask(what, got, case[0].shape))
    right = [ask_next(*case) for case in _SEARCHES.values()]
    titles = ("target", "yours")
    both = [table(_FEW, fresh, names=("a", "v"), blank=True) for fresh in (right[0], answers[0])]
    picture = side_by_side(both, titles, gap=30)
    faults = {words: partial(_asked, fault=fault) for words, fault in _MISSED.items()}
    explained("ask_next", _SEARCHES, answers, ask_next, faults, picture)
    return picture
