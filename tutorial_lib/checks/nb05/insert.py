"""The check of the insertion of a trajectory into a map, in notebook 05."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.explanation import explained
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.checks.nb05.insert_faults import FAULTS
from tutorial_lib.checks.nb05.insert_maps import CASES, EXAMPLE, Case
from tutorial_lib.checks.nb05.small_map import SmallMap, insert, through
from tutorial_lib.topology.mapping import edge_rules

_TABLES = {
    "trajectory": "the trajectory that a new vertex was made for is the number of paths before",
    "place": "the place of a vertex is its index along the trajectory, dropped anchors counted",
    "before": "before is the vertex before on the path, reused or not; -1 at the start",
    "after": "after is the vertex after on the path, reused or not; -1 at the end",
}
_LISTS = "vertices and paths stay lists of whole numbers"


@check(
    insert,
    EXAMPLE,
    calls=600,
    endless="insert: your function has not ended after {seconds:g} seconds. Does it add to a list "
    "while it goes through that list?",
)
def check_insert(student: Callable[..., Any]) -> None:
    """Trajectories that pass the same places, part, stand still, turn back, or meet nothing."""
    for name, case in CASES.items():
        wanted = _by_rule(insert, name)
        try:
            got = _grown(student, case, f"insert, {name}")
        except (WrongAnswer, NotImplementedError):
            raise
        except Exception as error:
            words = "a map may be empty, and an anchor's neighbours may not exist"
            hints = {IndexError: words, ValueError: words}
            raise WrongAnswer(f"insert, {name}: {explained(error, hints)}") from None
        for number, (mine, right) in enumerate(zip(got, wanted, strict=True)):
            said = _difference(mine, right)
            if said:
                before = wanted[number - 1] if number else SmallMap.empty(case.reach)
                why = _known(student) or said + _chosen(mine, right, before, case, number)
                raise WrongAnswer(f"insert, {name}, after trajectory {number + 1}: {why}")


def _grown(function: Callable[..., Any], case: Case, what: str = "") -> list[SmallMap]:
    """The map after each of a case's trajectories."""
    grown, maps = SmallMap.empty(case.reach.copy()), []
    for own in case.trajectories:
        given = own.copy(), case.scores.copy()
        back = function(grown, *given, case.p_reuse)
        if what:
            _check_form(what, grown, back, case, own, given)
        maps.append(copy.deepcopy(grown))
    return maps


@cache
def _by_rule(rule: Callable[..., Any], name: str) -> list[SmallMap]:
    """The maps that a rule of the library makes of a case, for all answers that are checked."""
    return _grown(rule, CASES[name])


def _check_form(
    what: str, grown: SmallMap, back: object, case: Case, own: np.ndarray, given: tuple
) -> None:
    """Demand a map of the right form, whose table and trajectory did not change."""
    if back is not None and back is not grown:
        words = f"{kind(back)} came back; change the map that is given, return nothing"
        raise WrongAnswer(f"{what}: {words}")
    same = np.array_equal(grown.reach, case.reach) and np.array_equal(given[1], case.scores)
    if not same or not np.array_equal(given[0], own):
        words = "reach, scores and own are needed again: write into the other tables only"
        raise WrongAnswer(f"{what}: {words}")
    try:
        grown.vertices = [int(v) for v in grown.vertices]
        grown.paths = [[int(v) for v in path] for path in grown.paths]
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what}: {_LISTS}") from None
    for name in (*_TABLES, "edge_reach", "driven"):
        table, shape = getattr(grown, name), getattr(SmallMap.empty(case.reach), name).shape
        if not isinstance(table, np.ndarray) or table.shape != shape:
            raise WrongAnswer(f"{what}: {name} must stay an array of shape {shape}")


def _chosen(got: SmallMap, want: SmallMap, before: SmallMap, case: Case, number: int) -> str:
    """Why another vertex, or none, stands on the path for the first anchor that is wrong."""
    if len(got.paths) != len(want.paths) or len(got.paths[-1]) != len(want.paths[-1]):
        return ""
    pairs = list(zip(got.paths[-1], want.paths[-1], strict=True))
    i = next((i for i, (mine, right) in enumerate(pairs) if mine != right), None)
    if i is None:
        return ""
    own, path, taken = case.trajectories[number], want.paths[-1], pairs[i][0]
    if taken == own[i]:
        return "; a vertex of the map can take its place"
    if taken not in before.vertices:
        return f"; {taken} was no vertex of the map before this trajectory"
    reused = [vertex for vertex in path[:i] if vertex in before.vertices]
    if not edge_rules.ahead_of(before.trajectory, before.place, reused)[taken]:
        return f"; {taken} is not ahead of all that were reused: {reused}. Never backwards"
    at = before.vertices.index(taken)
    into, onward = (float(reach[at]) for reach in through(before, own, path, i))
    words = f"; RE from {path[i - 1] if i else own[0]} into {taken} is {into:.3f}"
    end = own[min(i + 1, len(own) - 1)]
    return f"{words}, and onward from it to {end} {onward:.3f}; p_reuse is {case.p_reuse:g}"


def _known(student: Callable[..., Any]) -> str:
    """What to say of the first known mistake that makes the same maps; empty if none does."""
    mine = [state for case in CASES.values() for state in _grown(student, case)]
    for words, fault in FAULTS.items():
        theirs = [state for name in CASES for state in _by_rule(fault, name)]
        if all(not _difference(one, other) for one, other in zip(mine, theirs, strict=True)):
            return words
    return ""


def _difference(got: SmallMap, want: SmallMap) -> str:
    """The first difference of two maps; empty if there is none."""
    if len(got.paths) != len(want.paths):
        shown = f"the map has {len(got.paths)} paths, but {len(want.paths)} is right"
        return f"{shown}: append the new path to those that are there"
    if got.paths != want.paths:
        mine, right = got.paths[-1], want.paths[-1]
        shown = f"the new path is {mine}, but {right} is right"
        if got.paths[:-1] != want.paths[:-1]:
            return "paths of earlier trajectories stay as they are; append the new one"
        if len(mine) == len(right):
            i = next(i for i, pair in enumerate(zip(mine, right, strict=True)) if len({*pair}) > 1)
            shown += f": look at anchor {i} of the trajectory"
        else:
            shown += ": it has a vertex for each anchor, reused or not"
        return shown
    if sorted(got.vertices) != sorted(want.vertices):
        extra = sorted(set(got.vertices) - set(want.vertices))
        lost = sorted(set(want.vertices) - set(got.vertices))
        if extra:
            return f"{extra} became vertices, though they were replaced"
        return f"{lost} must be vertices" if lost else "a vertex stands in vertices twice"
    for name, words in _TABLES.items():
        mine, right = getattr(got, name), getattr(want, name)
        wrong = np.flatnonzero(mine != right)
        if len(wrong):
            v = int(wrong[0])
            return f"{name}[{v}] is {mine[v]}, but {right[v]} is right: {words}"
    return _edges(got, want)


def _edges(got: SmallMap, want: SmallMap) -> str:
    """The first difference of two maps' edges; empty if there is none."""
    wrong = np.argwhere(got.driven != want.driven)
    if len(wrong):
        i, j = (int(n) for n in wrong[0])
        if want.driven[i, j]:
            return f"the trajectory goes from {i} to {j}, but driven[{i}, {j}] is not True"
        words = "no vertex leads to itself" if i == j else "mark the steps of the path, one by one"
        return f"driven[{i}, {j}] is True, but no trajectory goes there: {words}"
    mine = got.edge_reach
    wrong = np.argwhere(~np.isclose(mine, want.edge_reach, rtol=0, atol=1e-9))
    if not len(wrong):
        return ""
    i, j = (int(n) for n in wrong[0])
    shown = f"edge_reach[{i}, {j}] is {mine[i, j]:.3g}, but {want.edge_reach[i, j]:.3g} is right"
    if i == j:
        return f"{shown}: a vertex is joined with every other vertex, not with itself"
    if not {i, j} <= set(want.vertices):
        return f"{shown}: only vertices are joined, not anchors that were replaced"
    if want.driven[i, j]:
        return f"{shown}: on a driven step at least reach[{i}, {j}]"
    return f"{shown}: each new vertex is joined with all others by scores, in both directions"
