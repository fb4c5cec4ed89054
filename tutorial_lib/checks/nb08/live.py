"""The check of the query loop, in notebook 08."""

import math
from collections.abc import Callable
from numbers import Real
from typing import Any

import networkx as nx

from tutorial_lib.array_forms import quoted
from tutorial_lib.checks.engine import WrongAnswer, calling, case, exercise
from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.topology.maintenance import bayes

Edge = tuple[int, int]
PRUNE = 0.2
"""R_p of the exercise."""
FIRST = 0.9
"""Probability of all its edges at first."""
SUREST = 0.97
"""A belief is never surer than that."""
MOST = 60
"""Edges that a robot of the check drives in all, at most; then its battery is empty."""


def live(
    graph: nx.DiGraph,
    queries: list[Edge],
    drive: Callable[[int, int], bool],
    update: Callable[[float, bool], float],
    prune: float,
) -> list[bool]:
    """Whether each query arrived; the graph learns; see the exercise."""
    arrived = []
    for start, goal in queries:
        here, failed = start, set()
        while here != goal:
            left = nx.restricted_view(graph, [], failed)
            if not nx.has_path(left, here, goal):
                break
            ahead = nx.dijkstra_path(left, here, goal, weight="length")[1]
            edge = graph.edges[here, ahead]
            success = drive(here, ahead)
            before = edge["probability"]
            edge["probability"] = update(before, success)
            if success:
                here = ahead
            else:
                if edge["probability"] < prune:
                    graph.remove_edge(here, ahead)
                failed = failed | {(here, ahead)}
        arrived.append(here == goal)
    return arrived


class _EmptyError(Exception):
    """The robot has driven more edges than any right answer needs."""


def run(
    function: Callable[..., Any],
    lengths: dict[Edge, float],
    queries: list[Edge],
    fails: dict[Edge, set[int]],
    prune: float = PRUNE,
) -> tuple[Any, list[tuple[Edge, bool]], dict[Edge, float], dict[Edge, float]]:
    """Let a function live in a small building.

    Args:
        function: as `live`.
        lengths: metres of each edge.
        queries: starts and goals.
        fails: for some edges the attempts, counted from 1, that fail; 0 for all.
        prune: R_p.

    Returns:
        What it returned, what was driven, and of each edge that is left the probability, and the
        metres where they are no longer what they were.
    """
    graph = nx.DiGraph()
    for edge, metres in lengths.items():
        graph.add_edge(*edge, length=metres, probability=FIRST)
    driven: list[tuple[Edge, bool]] = []
    tries: dict[Edge, int] = {}

    def drive(source: int, target: int) -> bool:
        edge = (int(source), int(target))
        if edge not in lengths:
            raise WrongAnswer(f"you drive from {source} to {target}, and no edge leads there")
        if len(driven) >= MOST:
            raise _EmptyError
        tries[edge] = tries.get(edge, 0) + 1
        success = not ({0, tries[edge]} & fails.get(edge, set()))
        driven.append((edge, success))
        return success

    def update(prior: float, success: bool) -> float:
        return min(max(bayes(prior, 0.9, 0.05, success), 1 - SUREST), SUREST)

    try:
        answer = function(graph, list(queries), drive, update, prune)
    except _EmptyError:
        answer = "empty"
    left = {(int(a), int(b)): float(p) for a, b, p in graph.edges(data="probability")}
    metres = {(int(a), int(b)): m for a, b, m in graph.edges(data="length", default=math.nan)}
    changed = {
        e: metres[e]
        for e in sorted(lengths.keys() & metres.keys())
        if not (isinstance(metres[e], Real) and abs(metres[e] - lengths[e]) < 1e-6)
    }
    return answer, driven, left, changed


_ONCE = bayes(FIRST, 0.9, 0.05, False)  # what is left of an edge after one failure
_BOTH = {(0, 1): 1.0, (1, 2): 1.0, (2, 3): 1.0, (3, 2): 1.0, (2, 1): 1.0, (1, 0): 1.0}
_DETOUR = {(0, 1): 1.0, (1, 4): 1.0, (0, 2): 2.0, (2, 3): 2.0, (3, 4): 2.0, (1, 0): 1.0}
_WORMHOLE = {**_DETOUR, (0, 4): 0.5}
CASES = {
    "a corridor": case(_BOTH, [(0, 3), (3, 0)], {}),
    "a query that is there already": case(_BOTH, [(2, 2), (0, 1)], {}),
    "an edge that fails once": case(_DETOUR, [(0, 4), (0, 4)], {(1, 4): {1}}),
    "a wormhole": case(_WORMHOLE, [(0, 4)] * 5, {(0, 4): {0}}),
    "a door that is closed": case(_BOTH, [(0, 3), (0, 3), (0, 3), (0, 2)], {(2, 3): {0}}),
    "no path at all": case({**_BOTH, (9, 0): 1.0}, [(0, 9), (9, 3)], {}),
    "two edges that fail on the way": case(
        {**_DETOUR, (0, 3): 3.0}, [(0, 4)] * 4, {(0, 1): {0}, (0, 2): {1, 3}}
    ),
    "a detour that is longer by little": case(
        {(0, 1): 1.0, (1, 2): 1.0, (0, 3): 0.9, (3, 2): 1.2}, [(0, 2)] * 3, {(1, 2): {2}}
    ),
    "an edge of exactly R_p": case(_BOTH, [(0, 3), (0, 2)], {(2, 3): {0}}, _ONCE),
    "a high R_p, and successes": case(_BOTH, [(0, 3), (0, 2)], {}, 0.995),
    "back along an edge whose other direction failed": case(
        {(0, 1): 1.0, (1, 0): 1.0, (1, 4): 1.0, (0, 2): 1.0, (2, 1): 1.0, (0, 3): 5.0, (3, 4): 5.0},
        [(0, 4)],
        {(0, 1): {0}, (1, 4): {0}},
    ),
    "a place whose last edge is pruned": case(
        {(0, 1): 1.0, (1, 0): 1.0, (1, 9): 1.0}, [(0, 9)] * 4, {(1, 9): {0}}
    ),
    "an edge that is short and doubtful": case(
        {(0, 1): 1.0, (0, 2): 0.7, (2, 1): 0.7}, [(0, 1)] * 2, {(0, 1): {1}}
    ),
    "few edges, but long ones": case(
        {(0, 3): 9.0, (0, 1): 1.0, (1, 2): 1.0, (2, 3): 1.0}, [(0, 3)], {}
    ),
}
MISTAKES = """
an edge that failed is not tried again in the same query; yours is
    failed = failed | {(here, ahead)} -> pass
an edge that failed in one query may be tried again in the next
    here, failed = start, set() -> here, failed = start, (failed if arrived else set())
a failure leaves the robot where it was; yours goes on as if it had arrived
    if success: -> if True:
a success counts as well: it makes an edge surer
    update(before, success) -> before if success else update(before, False)
a failure makes an edge less probable, whether it is pruned or not
    update(before, success) -> update(before, True)
an edge whose probability falls below R_p is taken out of the graph
    graph.remove_edge(here, ahead) -> pass
an edge is pruned only if its probability fell below R_p, not at the first failure
    if edge["probability"] < prune: -> if True:
the path is the shortest in metres, not in edges
    weight="length" -> weight=None
plan anew from where the robot is; yours gives up at the first failure
    failed = failed | {(here, ahead)} -> break
lengths stay as they are; yours changes those of edges
    success = drive(here, ahead) -> success = drive(here, ahead); edge["length"] *= 1.01
a query without a path has not arrived, and the next one begins
    arrived.append(here == goal) -> arrived.append(True)
"""


def _formed(what: str, got: tuple, *_: object) -> tuple[list[bool], list, dict, dict]:
    answer, driven, left, changed = got
    if isinstance(answer, str):
        raise WrongAnswer(
            f"{what}: your robot has driven {MOST} edges and its battery is empty; does it try the "
            "same edge over and over?"
        )
    answer = returned(what, answer)
    try:
        return [bool(one) for one in answer], driven, left, changed
    except TypeError as error:
        raise WrongAnswer(f"{what}: return a list, True or False for each query") from error


def _same(got: tuple, want: tuple, *_: object) -> bool:
    near = got[2].keys() == want[2].keys() and all(
        abs(got[2][edge] - want[2][edge]) < 1e-6 for edge in want[2]
    )
    return got[0] == want[0] and got[1] == want[1] and near and not got[3]


def _difference(got: tuple, want: tuple, *_: object) -> str:
    for number, (mine, right) in enumerate(zip(got[1], want[1], strict=False), 1):
        if mine[0] != right[0]:
            return f"drive {number} leads along {mine[0]}, but {right[0]} is right"
    if len(got[1]) != len(want[1]):
        return f"{len(got[1])} edges are driven, but {len(want[1])} is right"
    if more := sorted(got[2].keys() - want[2].keys()):
        return f"{more[0]} is left"
    if gone := sorted(want[2].keys() - got[2].keys()):
        return f"{gone[0]} is gone"
    if got[0] != want[0]:
        return f"{got[0]} came back, but {want[0]} is right"
    if got[3]:
        edge, metres = next(iter(got[3].items()))
        return f"the length of {edge} has become {quoted(metres)}"
    edge = max(want[2], key=lambda one: abs(got[2][one] - want[2][one]))
    return f"the probability of {edge} is {got[2][edge]:.3g}, but {want[2][edge]:.3g} is right"


def _broken(got: tuple, want: tuple, *_: object) -> str:
    if got[3]:
        return "lengths stay as they are; yours changes those of edges"
    if len(got[0]) != len(want[0]):
        return "one answer for each query"
    for (mine, _), (right, _) in zip(got[1], want[1], strict=False):
        if mine[0] != right[0]:
            return "plan again from where the robot is: a failure leaves it where it was"
        if mine != right:
            break
    if got[1] != want[1]:
        return "drive the first edge of the shortest path over the edges that have not failed"
    if set(got[2].values()) == {FIRST}:
        return "the graph that you are given has to learn; yours is as it was"
    if got[2].keys() != want[2].keys():
        return "after a failure an edge below R_p is taken out, and no other"
    if got[0] != want[0]:
        return "a query has arrived if the robot is at its goal"
    return "each traversal updates its own edge once, and no other"


check_live = exercise(
    live,
    CASES,
    MISTAKES,
    about="Queries in small buildings, with doors that close and a wormhole.",
    example=(nx.path_graph(3, create_using=nx.DiGraph), [], lambda *_: True, lambda p, _: p, PRUNE),
    calls=10,
    endless="Your function has not ended after {seconds:g} seconds. Does a robot without a path "
    "look for one for ever?",
    run=run,
    invoke=calling(
        {
            nx.NodeNotFound: "leave out the edge that failed alone; its vertices stay",
            nx.NetworkXNoPath: "where no path is left, the query has not arrived",
            IndexError: "a robot that is at its goal has no next vertex",
        },
        run=run,
    ),
    form=_formed,
    same=_same,
    difference=_difference,
    broken=_broken,
)
