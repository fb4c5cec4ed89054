"""The check of the insertion of a trajectory into a map, in notebook 05."""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import Mask, WrongAnswer, calling, case, exercise, kind, mistakes_of
from tutorial_lib.checks.nb05.small_map import SmallMap
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping import edge_rules
from tutorial_lib.topology.mapping.vertices import Indices


def through(grown: SmallMap, own: Indices, path: list[int], i: int) -> tuple[Array, Array]:
    """RE (V,) to each vertex from what is before anchor i, and from each to the anchor after."""
    before, after = path[i - 1] if i else own[0], own[min(i + 1, len(own) - 1)]
    return grown.reach[before, grown.vertices], grown.reach[grown.vertices, after]


def insert(
    grown: SmallMap,
    own: Indices,
    scores: Array,
    p_reuse: float,
    through: Callable[..., tuple[Array, Array]] = through,
    ahead_of: Callable[..., Mask] = edge_rules.ahead_of,
    reusable: Callable[..., int] = edge_rules.reusable,
) -> None:
    """Insert a trajectory into a map (Meng 2020, III-E); see the exercise."""
    path, reused = [], []
    for i, anchor in enumerate(own.tolist()):
        into, onward = through(grown, own, path, i)
        allowed = ahead_of(grown.trajectory, grown.place, reused)[grown.vertices]
        found = reusable(into, onward, allowed, p_reuse)
        if found >= 0:
            reused.append(grown.vertices[found])
        path.append(anchor if found < 0 else grown.vertices[found])
    new = [vertex for vertex in path if vertex in own]
    ends = [-1, *path, -1]
    for place, vertex in enumerate(path):
        if vertex in new:
            grown.trajectory[vertex], grown.place[vertex] = len(grown.paths), place
            grown.before[vertex], grown.after[vertex] = ends[place], ends[place + 2]
    grown.vertices, grown.paths = [*grown.vertices, *new], [*grown.paths, path]
    for vertex in new:
        others = [other for other in grown.vertices if other != vertex]
        grown.edge_reach[vertex, others] = scores[vertex, others]
        grown.edge_reach[others, vertex] = scores[others, vertex]
    for source, target in pairwise(path):
        if source != target:
            grown.driven[source, target] = True
            known = grown.edge_reach[source, target]
            grown.edge_reach[source, target] = max(known, grown.reach[source, target])


@dataclass(frozen=True, eq=False)
class Story:
    """Trajectories to insert one after the other."""

    reach: Array
    scores: Array
    trajectories: list[Indices]
    p_reuse: float


def _along(places: list[list[float]], p_reuse: float, seed: int, less: float = 0.0) -> Story:
    """Trajectories along a corridor: RE falls with the metres ahead, and faster behind.

    As edges, as with sequences, RE is lower by `less`; higher if that is negative.
    """
    rng, metres = np.random.default_rng(seed), np.concatenate(places)
    ahead = metres - metres[:, None]
    far = np.where(ahead >= 0, ahead, -3 * ahead)
    reach = (np.exp(-0.05 * far**2) * rng.uniform(0.97, 1.0, far.shape)).round(4)
    np.fill_diagonal(reach, 1.0)
    scores = np.clip(reach - less * rng.random(far.shape), 0.0, 1.0).round(4)
    bounds = np.cumsum([0, *map(len, places)])
    own = [np.arange(first, last) for first, last in pairwise(bounds)]
    return Story(reach, scores, own, p_reuse)


def _random(seed: int) -> Story:
    """RE at random, and trajectories of different lengths."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(2, 6, 4)
    reach = rng.uniform(0.0, 1.0, (lengths.sum(), lengths.sum())).round(3)
    scores = (reach * rng.uniform(0.5, 1.0, reach.shape)).round(3)
    numbers = rng.permutation(lengths.sum())
    own = np.split(numbers, np.cumsum(lengths)[:-1])
    return Story(reach, scores, own, float(rng.choice([0.3, 0.5, 0.7])))


_TWICE = [[0.0, 1.0, 2.0, 3.0], [0.1, 1.1, 2.1, 3.1]]
STORIES = {
    "one trajectory": _along(_TWICE[:1], 0.9, 1),
    "the same path twice": _along(_TWICE, 0.9, 2),
    "nothing may be reused": _along(_TWICE, 1.0, 3),
    "a part in common": _along([[0, 1, 2, 3], [9, 8, 2, 3, 4, 5], [1, 2, 3, 4]], 0.9, 4),
    "scores below reach": _along([[0, 1, 2, 3], [0.5, 1.5, 2.5, 7], [1, 2, 3, 4, 8]], 0.85, 5, 0.4),
    "some scores above reach": _along([[0, 1, 2, 3], [0.2, 1.2, 5, 6]], 0.85, 9, -0.3),
    "back and there again": _along([[0, 1, 2, 3], [3, 2, 1, 0], [0, 1, 2, 3]], 0.8, 6),
    "many anchors close together": _along([[0, 0.5, 1, 1.5], [0, 0.1, 0.2, 0.3, 0.4, 1.4]], 0.9, 7),
    "anchors so close that RE is above 0.99": _along(
        [[0, 0.2, 0.4, 0.6], [0.1, 0.3, 0.5, 0.7]], 0.975, 18
    ),
} | {f"RE at random ({seed})": _random(seed) for seed in range(6)}
CASES = {
    f"{name}, after trajectory {number}": case(story, number)
    for name, story in STORIES.items()
    for number in range(1, len(story.trajectories) + 1)
}
MISTAKES = """
reuse asks reach; scores are for the edges
    allowed = -> seen = SmallMap(**{**vars(grown), "reach": scores}); allowed =
    reusable(into, -> reusable(through(seen, own, path, i)[0],
reuse asks reach onward, too; scores are for the edges
    allowed = -> seen = SmallMap(**{**vars(grown), "reach": scores}); allowed =
    reusable(into, onward, -> reusable(into, through(seen, own, path, i)[1],
the edge back has the RE back, scores[other, vertex]; RE is not symmetric
    = scores[others, vertex] -> = scores[vertex, others]
new vertices are joined with the old ones, too
    other in grown.vertices if -> other in new if
edge_reach of a driven step is at least reach; where scores has more, that stays
    max(known, grown.reach[source, target]) -> grown.reach[source, target]
a driven step has the RE in reach, if scores has not more; it is not sure
    max(known, grown.reach[source, target]) -> 1.0
only new vertices are joined; those that were reused have their edges already
    for vertex in new: -> for vertex in path:
every step of the path is driven, also between vertices that were there
    = True -> = source in new or target in new
your trajectory never reuses a vertex: call reusable for each anchor
    found = reusable(into, onward, allowed, p_reuse) -> found = -1
never backwards: ask ahead_of which vertices may be taken
    ahead_of(grown.trajectory, grown.place, reused) -> np.ones(len(grown.reach), dtype=bool)
ahead_of needs all vertices that were reused so far, not only the last one
    grown.place, reused) -> grown.place, reused[-1:])
join in both directions: from the new vertices and to them
    grown.edge_reach[others, vertex] = scores[others, vertex] -> pass
the new vertices are joined with each other, too
    other != vertex -> other not in new
new vertices are joined with all others, not only along the trajectory
    for vertex in new: -> for vertex in ():
edges have the RE in scores; only driven steps take at least that in reach
    = scores[vertex, others] -> = grown.reach[vertex, others]
    = scores[others, vertex] -> = grown.reach[others, vertex]
driven steps lead over the vertices of the path, not over anchors that were replaced
    grown.driven[source, target] = -> grown.driven[own[:-1], own[1:]] =
a trajectory is driven in one direction only
    = True -> = grown.driven[target, source] = True
a driven step that is no new pair needs its RE in edge_reach, too: at least reach
    max(known, grown.reach[source, target]) -> known
the place counts all anchors of the trajectory, also those that were replaced
    = len(grown.paths), place -> = len(grown.paths), new.index(vertex)
the path is right, but the map did not grow: add the new vertices
    new = -> grown.paths = [*grown.paths, path]; return; new =
p_reuse is an argument, and not always 0.99
    allowed, p_reuse) -> allowed, 0.99)
"""
THROUGH = """
the first anchor may be replaced, too: into is RE from the anchor itself
    return grown -> return (i > 0) * grown
the last anchor may be replaced, too: onward is RE to the anchor itself
    return grown -> return (i < len(own) - 1) * grown
into leads from what stands on the path before, not from the anchor itself
    reach[before, -> reach[own[i],
into is RE to the vertex: row what stands on the path before, column the vertex
    reach[before, grown.vertices] -> reach[grown.vertices, before]
the last anchor is its own successor; yours leads on to the first one
    own[min(i + 1, len(own) - 1)] -> own[(i + 1) % len(own)]
if the anchor before was replaced, the robot stands on the vertex that replaced it: take RE from
that one, not from the anchor
    path[i - 1] if -> own[i - 1] if
onward is RE from the vertex to the anchor after: row the vertex, column the anchor
    reach[grown.vertices, after] -> reach[after, grown.vertices]
onward leads to the anchor after, own[i + 1], not to the anchor itself
    own[min(i + 1, len(own) - 1)] -> own[i]
"""
"""Mistakes of the RE by which vertices are judged."""
_TABLES = {
    "trajectory": "the trajectory that a new vertex was made for is the number of paths before",
    "place": "the place of a vertex is its index along the trajectory, dropped anchors counted",
    "before": "before is the vertex before on the path, reused or not; -1 at the start",
    "after": "after is the vertex after on the path, reused or not; -1 at the end",
}


@cache
def _by_rule(rule: Callable[..., Any], story: Story, number: int) -> SmallMap:
    """The map after so many of a story's trajectories, kept for all answers that are checked."""
    if not number:
        return SmallMap.empty(story.reach)
    grown = copy.deepcopy(_by_rule(rule, story, number - 1))
    rule(grown, story.trajectories[number - 1], story.scores, story.p_reuse)
    return grown


def _play(inserts: Callable[..., Any], story: Story, number: int) -> SmallMap:
    """A student's map of a story's first trajectories, whose form is looked at after each."""
    grown = SmallMap.empty(story.reach.copy())
    for own in story.trajectories[:number]:
        given = own.copy(), story.scores.copy()
        back = inserts(grown, *given, story.p_reuse)
        _demand_form(grown, back, story, own, given)
    return grown


def _demand_form(
    grown: SmallMap, back: object, story: Story, own: Indices, given: tuple[Indices, Array]
) -> None:
    """Demand a map of the right form, whose table and trajectory did not change."""
    if back is not None and back is not grown:
        raise WrongAnswer(f"{kind(back)} came back; change the map that is given, return nothing")
    if not all(map(np.array_equal, (grown.reach, *given), (story.reach, own, story.scores))):
        words = "reach, scores and own are needed again"
        raise WrongAnswer(f"{words}: write into the other tables only")
    try:
        grown.vertices = [int(v) for v in grown.vertices]
        grown.paths = [[int(v) for v in path] for path in grown.paths]
    except (TypeError, ValueError):
        raise WrongAnswer("vertices and paths stay lists of whole numbers") from None
    for name in (*_TABLES, "edge_reach", "driven"):
        table, shape = getattr(grown, name), getattr(SmallMap.empty(story.reach), name).shape
        if not isinstance(table, np.ndarray) or table.shape != shape:
            raise WrongAnswer(f"{name} must stay an array of shape {shape}")


_EMPTY = (
    "a map may be empty, and an anchor's neighbours may not exist. Or is it ahead_of? It takes the "
    "tables of all N anchors and answers for all; of its answer the vertices' entries count"
)
_CALLING = calling({IndexError: _EMPTY, ValueError: _EMPTY}, run=_play)


def _invoke(what: str, *given: Any) -> SmallMap:  # noqa: ANN401
    return _CALLING(what.partition(", after")[0], *given)  # that is said of maps alone


def _chosen(got: SmallMap, want: SmallMap, story: Story, number: int) -> str:
    """Why another vertex, or none, stands on the path for the first anchor that is wrong."""
    if len(got.paths) != len(want.paths) or len(got.paths[-1]) != len(want.paths[-1]):
        return ""
    own, path = story.trajectories[number - 1], want.paths[-1]
    i = _first_other(got.paths[-1], path)
    if i == len(path):
        return ""
    before, taken = _by_rule(insert, story, number - 1), got.paths[-1][i]
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
    return f"{words}, and onward from it to {end} {onward:.3f}; p_reuse is {story.p_reuse:g}"


def _first_other(mine: list[int], right: list[int]) -> int:
    """The first place at which two paths of the same length differ; their length if none."""
    return int(np.append(np.not_equal(mine, right), True).argmax())


def _difference(got: SmallMap, want: SmallMap) -> str:
    """The first difference of two maps; empty if there is none."""
    if len(got.paths) != len(want.paths):
        shown = f"the map has {len(got.paths)} paths, but {len(want.paths)} is right"
        return f"{shown}: append the new path to those that are there"
    if got.paths[:-1] != want.paths[:-1]:
        return "paths of earlier trajectories stay as they are; append the new one"
    if got.paths != want.paths:
        mine, right = got.paths[-1], want.paths[-1]
        shown = f"your new path is {mine}, but {right} is right"
        if len(mine) == len(right):
            return f"{shown}: look at anchor {_first_other(mine, right)} of the trajectory"
        return f"{shown}: it has a vertex for each anchor, reused or not"
    extra = sorted(set(got.vertices) - set(want.vertices))
    lost = sorted(set(want.vertices) - set(got.vertices))
    if extra:
        return f"{extra} became vertices, though they were replaced"
    if lost:
        return f"{lost} must be vertices"
    if len(got.vertices) != len(want.vertices):
        return "a vertex stands in vertices twice"
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
    if want.driven[i, j] and (i, j) not in pairwise(want.paths[-1]):
        return f"{shown}: the edges between vertices that were there before stay as they are"
    if want.driven[i, j]:
        return f"{shown}: on a driven step at least reach[{i}, {j}]"
    return f"{shown}: each new vertex is joined with all others by scores, in both directions"


def _example() -> tuple:
    """A trajectory to insert into a map of 90 vertices."""
    large = _along([np.linspace(0, 40, 90).tolist(), np.linspace(5, 30, 17).tolist()], 0.9, 8)
    grown, (first, second) = SmallMap.empty(large.reach), large.trajectories
    grown.vertices, grown.paths = first.tolist(), [first.tolist()]
    grown.trajectory[first], grown.place[first] = 0, first
    grown.before[first[1:]], grown.after[first[:-1]] = first[:-1], first[1:]
    return grown, second, large.scores, large.p_reuse


check_insert = exercise(
    insert,
    CASES,
    MISTAKES,
    about="Trajectories that pass the same places, part, stand still, turn back, or meet nothing.",
    example=_example(),
    others={
        w: partial(insert, through=wrong) for w, wrong in mistakes_of(through, THROUGH).items()
    },
    calls=600,
    endless="insert: your function has not ended after {seconds:g} seconds. Does it add to a list "
    "while it goes through that list?",
    run=_by_rule,
    invoke=_invoke,
    same=lambda got, want, *_: not _difference(got, want),
    difference=lambda *_: "",
    broken=lambda got, want, *case: _difference(got, want) + _chosen(got, want, *case),
)
