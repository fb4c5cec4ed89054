"""The check of cycle detection, in notebook 07."""

import copy
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, calling, case, exercise, parts
from tutorial_lib.checks.framework.answers import returned

Graph = dict[int, dict[int, float]]
"""RE of the edge from v to w: graph[v][w]."""


def around_cycles(
    graph: Graph, visited: Sequence[int], cycle: int, bias: float
) -> tuple[bool, Graph]:
    """Whether a robot goes round in circles, and a graph that leads it elsewhere; see there."""
    came = [vertex for vertex, _ in groupby(visited)]
    visits = Counter(came)
    found = max(visits.values(), default=0) >= cycle
    biased = {
        v: {w: p * bias ** max(visits[w] - 1, 0) for w, p in out.items()}
        for v, out in graph.items()
    }
    return found, biased


_SMALL: Graph = {
    0: {1: 0.99, 2: 0.9},
    1: {2: 0.98, 3: 0.97},
    2: {0: 0.99, 3: 0.95},
    3: {4: 0.9, 1: 0.96},
    4: {},
}
CASES = {
    "round and round": (_SMALL, [0, 1, 2, 0, 1, 2, 0], 3, 0.5),
    "straight on": (_SMALL, [0, 1, 3, 4], 3, 0.5),
    "several steps at each vertex": (_SMALL, [0, 0, 0, 1, 1, 3, 3, 3], 3, 0.5),
    "twice at one vertex": (_SMALL, [0, 1, 2, 0], 3, 0.5),
    "a cycle that it has left": (_SMALL, [1, 2, 1, 2, 1, 3, 4], 3, 0.8),
    "no visit yet": (_SMALL, [], 3, 0.5),
    "no visit yet, where a single one would be a cycle": (_SMALL, [], 1, 0.5),
    "twice is a cycle": (_SMALL, [2, 3, 2], 2, 0.9),
    "one vertex for long, then others": (_SMALL, [4, 4, 4, 4, 3, 1], 4, 0.5),
    "four times": (_SMALL, [0, 1, 0, 1, 0, 2, 0], 4, 0.7),
    "a bias of 0": (_SMALL, [0, 1, 2, 0, 1], 3, 0.0),
    "a bias of 1": (_SMALL, [0, 1, 2, 0, 1], 3, 1.0),
    "a vertex left and entered anew at the end": (_SMALL, [3, 1, 2, 0, 1], 2, 0.5),
    "an empty map": ({}, [], 3, 0.5),
}
MISTAKES = """
a visit is an arrival: the same vertex several times in a row is one visit
    [vertex for vertex, _ in groupby(visited)] -> visited
a vertex may be visited several times, with others in between; yours counts each once
    [vertex for vertex, _ in groupby(visited)] -> set(visited)
`cycle` visits are a cycle already: >=, not >
    >= cycle -> > cycle
`cycle` visits are a cycle, not one less
    >= cycle -> >= cycle - 1
it is the visits of one vertex that make a cycle, not all visits together
    max(visits.values(), default=0) >= cycle -> len(came) >= cycle
any vertex that was visited often makes a cycle, not only the last one
    max(visits.values(), default=0) >= cycle -> bool(came) and visits[came[-1]] >= cycle
edges are biased from the second visit on, whether or not it is a cycle yet
    max(visits[w] - 1, 0) -> (max(visits[w] - 1, 0) * found)
the edges to a vertex that was visited are biased, not those that leave it
    visits[w] -> visits[v]
the first visit is free: bias ** (n - 1) for n visits
    max(visits[w] - 1, 0) -> visits[w]
each visit but the first counts: bias ** (n - 1); yours biases once
    max(visits[w] - 1, 0) -> (visits[w] > 1)
the bias begins with the second visit, not with the one that makes a cycle
    visits[w] - 1 -> visits[w] - cycle + 1
edges are biased from two visits on; yours waits until there are `cycle` visits
    max(visits[w] - 1, 0) -> (visits[w] - 1 if visits[w] >= max(cycle, 1) else 0)
bias ** (n - 1) for n visits: once for two visits, twice for three
    max(visits[w] - 1, 0) -> (visits[w] if visits[w] > 1 else 0)
where i is 0, visited[i - 1] is the last of the list; the first one is always a visit
    [vertex for vertex, _ in groupby(visited)]
        -> [v for i, v in enumerate(visited) if v != visited[i - 1]]
vertex 0 is a vertex: `not last` is True for it as well; compare with None
    [vertex for vertex, _ in groupby(visited)]
        -> [v for u, v in zip([None, *visited], visited, strict=False) if not u or u != v]
the first of the list is a visit, too; yours counts from the second on
    groupby(visited)] -> groupby(visited)][1:]
vertex 0 is a vertex like the others: a list may begin with a visit of it
    visits = -> came = came[1:] if came[:1] == [0] else came; visits =
multiply by bias for each further visit: bias ** (n - 1), not bias / n
    bias ** max(visits[w] - 1, 0) -> (bias / visits[w] if visits[w] > 1 else 1)
edges to vertices that were visited stay, with less probability; there may be no other path
    p * bias ** max(visits[w] - 1, 0) for w, p in out.items()
        -> p for w, p in out.items() if visits[w] < 2
an edge stays also where its RE becomes 0
    for w, p in out.items() -> for w, p in out.items() if p * bias ** max(visits[w] - 1, 0) > 0
the last of the list is a visit, too
    groupby(visited)] -> groupby(visited)][:-1]
compare with the vertex just before, not with the two before
    [vertex for vertex, _ in groupby(visited)]
        -> [v for i, v in enumerate(visited) if v not in visited[max(i - 2, 0) : i]]
a power of the bias, bias ** (n - 1), not a multiple of it
    bias ** max(visits[w] - 1, 0) -> (bias * (visits[w] - 1) if visits[w] > 1 else 1)
a vertex that was not visited keeps its RE: max(n - 1, 0)
    max(visits[w] - 1, 0) -> (visits[w] - 1)
bias is an argument, not always 0.5
    bias ** -> 0.5 **
cycle is an argument, not always 3
    >= cycle -> >= 3
every visit but the first counts, also beyond the third
    max(visits[w] - 1, 0) -> min(max(visits[w] - 1, 0), 2)
multiply RE by the bias; a difference may be negative
    p * bias ** max(visits[w] - 1, 0) -> p - bias * max(visits[w] - 1, 0)
the graph that you return has the same RE as before; bias the edges to visited vertices
    p * bias ** max(visits[w] - 1, 0) -> p
"""


_HINTS: dict[type[Exception], str] = {
    KeyError: "a dictionary has no such key; a Counter returns 0 for what it has not seen",
    ValueError: "max() of nothing needs default=0: there may be no visit; bias may be 0",
}


def _invoke(what: str, student: Callable[..., Any], *case: Any) -> Any:  # noqa: ANN401
    given = copy.deepcopy(case)
    got = calling(_HINTS)(what, partial(student, *given))
    if given != case:
        words = "make a new one, with new inner dictionaries"
        if given[0] == case[0]:
            raise WrongAnswer(f"{what}: your function changes its argument visited; make a copy")
        raise WrongAnswer(f"{what}: your function changes the map, which is needed again; {words}")
    if _shared(got, given[0]):
        words = "also where nothing changes: the robot may go on to change what it got"
        raise WrongAnswer(
            f"{what}: the graph that came back is the map itself, or shares inner dictionaries "
            f"with it; make new ones, {words}"
        )
    return returned(what, got)


def _shared(got: object, graph: Graph) -> bool:
    """Whether the graph of an answer is the given one, at least in part."""
    if not (isinstance(got, tuple | list) and len(got) == 2 and isinstance(got[1], dict)):
        return False
    own = {id(graph), *map(id, graph.values())}
    return not own.isdisjoint({id(got[1]), *map(id, got[1].values())})


def _formed(what: str, got: object, graph: Graph, *_: object) -> tuple[bool, Graph]:
    found, biased = parts(what, got, 2, "return whether it is a cycle, and the biased graph")
    if not isinstance(found, bool | np.bool_):
        raise WrongAnswer(f"{what}: {found!r} came back; return True in a cycle, False otherwise")
    if not isinstance(biased, dict) or not all(isinstance(out, dict) for out in biased.values()):
        raise WrongAnswer(f"{what}: return the graph as a dictionary of dictionaries")
    if biased.keys() != graph.keys():
        raise WrongAnswer(f"{what}: the graph that came back {_vertices(biased, graph)}")
    return bool(found), biased


def _vertices(mine: Graph, graph: Graph) -> str:
    """Which vertices it lacks, or has and should not."""
    missing = [v for v in graph if v not in mine]
    if not missing:
        return f"has vertices that the map has not: {[v for v in mine if v not in graph]}"
    names = ", ".join(map(str, missing))
    bare = "" if any(graph[v] for v in missing) else ", from which no edge leads"
    return f"lacks {names}{bare}; keep all vertices, also as empty dictionaries"


def _difference(mine: Graph, right: Graph) -> tuple[int, int] | None:
    """The first edge that differs."""
    for v, out in right.items():
        for w in {**out, **mine[v]}:
            one, other = mine[v].get(w), out.get(w)
            if one is None or other is None or not np.isclose(one, other, rtol=0, atol=1e-9):
                return v, w
    return None


def _broken(got: tuple[bool, Graph], want: tuple[bool, Graph], graph: Graph, *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    if got[0] != want[0]:
        return "it is a cycle where one vertex, whichever, was entered `cycle` times or more"
    if any(got[1][v].keys() != out.keys() for v, out in graph.items()):
        return "every edge stays, and none is added: edges only become less probable"
    v, w = _difference(got[1], want[1]) or (0, 0)
    if want[1][v][w] == graph[v][w]:
        return "an edge to a vertex that was visited once, or never, keeps its RE as it is"
    return "each edge to a vertex of n visits has RE * bias ** (n - 1), wherever it begins"


def _why(got: tuple[bool, Graph], want: tuple[bool, Graph], *case: Any) -> str:  # noqa: ANN401
    """What is wrong."""
    _, visited, cycle, _ = case
    if got[0] != want[0]:
        words = "it is a cycle" if want[0] else "it is no cycle"
        return f"after {visited} with cycle = {cycle} {words}; yours says {got[0]}"
    v, w = _difference(got[1], want[1]) or (0, 0)
    mine, right = got[1][v].get(w), want[1][v].get(w)
    return f"after {visited} the edge from {v} to {w} has {right}, yours {mine}"


check_around_cycles = exercise(
    around_cycles,
    CASES,
    MISTAKES,
    about="Cycles, straight paths, and long stays at a vertex.",
    example=case(_SMALL, [0, 1, 2, 0, 1, 2, 0], 3, 0.5),
    invoke=_invoke,
    form=_formed,
    same=lambda got, want, *_: got[0] == want[0] and _difference(got[1], want[1]) is None,
    difference=_why,
    broken=_broken,
)
