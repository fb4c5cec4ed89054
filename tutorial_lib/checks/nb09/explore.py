"""The check of the exploration loop, in notebook 09."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.framework.explanation import explained
from tutorial_lib.checks.framework.wording import kind, times
from tutorial_lib.checks.nb09.add_ghosts import add_ghosts
from tutorial_lib.checks.nb09.explore_words import FAULTS
from tutorial_lib.checks.nb09.global_policy import global_policy
from tutorial_lib.checks.nb09.small_buildings import BUILDINGS, Building
from tutorial_lib.checks.nb09.small_places import Ghost, PlacesRobot

Explored = tuple[bool, nx.Graph, set[Ghost]]
"""Whether the goal was reached, the graph, and the ghosts that are left."""
_EDGES = "each new node gets edges to those beside it"


def explore(robot: Any) -> Explored:  # noqa: ANN401
    """Explore until the goal is found, nothing is left, or no steps are; see the exercise.

    Args:
        robot: a `PlacesRobot`, or one of the real task.
    """
    return _explored(robot)


def _explored(robot: Any, fault: str = "") -> Explored:  # noqa: ANN401
    """The loop, with a `fault` if one is named."""
    graph, ghosts, scores = nx.Graph(), set[Ghost](), dict[Ghost, float]()
    arrived, last, there, first = False, 0, -1, True
    while robot.steps > (fault == "last step unused") or fault == "no end":
        looks = {
            "looks once": first,
            "looks at ghosts": arrived,
            "looks at first and at ghosts": first or arrived,
            "looks at new": arrived or robot.node() is None,
            "never looks": False,
        }.get(fault, True)
        first = False
        if looks and robot.sees_goal():
            if robot.to_goal() or fault == "believes":
                return True, graph, ghosts
            if fault == "tries again":
                continue
            if fault == "gives up":
                return False, graph, ghosts
            arrived = {"forgets arrival": False, "invents arrival": True}.get(fault, arrived)
        here = robot.node()
        new = here is None or (arrived and fault != "only where lost")
        new &= fault != "only in the last" or here is None or here == last
        if new:
            here = len(graph)
            beside = robot.beside()
            graph.add_node(here)
            for other, pose in beside.items():
                if fault != "last edge" or other == last:
                    metres = 1.0 if fault == "no metres" else float(np.hypot(pose[0], pose[1]))
                    graph.add_edge(here, other, metres=metres)
            known = set[Ghost]() if fault == "forgets" else ghosts
            near = {} if fault == "stale" else beside
            ghosts = add_ghosts(known, here, robot.explorable(), near)
            if fault == "forgets scores":
                scores = dict.fromkeys(ghosts, 0.0)
            scores |= {(here, k): float(s) for k, s in enumerate(robot.scores())}
            robot.remember(here)
        if fault == "scores anew":
            scores |= {(here, k): float(s) for k, s in enumerate(robot.scores())}
        last = here
        travel = 1.0 if fault == "weighs" else 0.3 if fault == "weighs a little" else 0.0
        node, ghost = global_policy(graph, here, ghosts, scores, weight=travel)
        if ghost is None:
            break
        there = ghost[0]
        if fault == "best of this node" and (mine := [g for g in ghosts if g[0] == here]):
            node, ghost, there = here, max(mine, key=scores.__getitem__), here
        if node != here:
            robot.to_node(node)
            arrived = False
            continue
        if fault != "straight to it" or there == here:
            arrived = robot.to_ghost(ghost) or (fault == "stays arrived" and arrived)
        if fault == "all of the node":
            ghosts = {other for other in ghosts if other[0] != here}
        if fault != "keeps it" and not (fault == "keeps what is blocked" and not arrived):
            ghosts = ghosts - {ghost}
    return False, graph, ghosts


def _play(explores: Callable[..., Any], building: Building) -> tuple[Any, list[tuple[object, ...]]]:
    """What comes back, and where the robot was driven."""
    robot = PlacesRobot(building)
    found = explores(robot)
    robot.demand_untouched()
    return found, robot.log


def _invoke(what: str, student: Callable[..., Any], building: Building) -> Any:  # noqa: ANN401
    hints = {
        KeyError: "scores needs an entry (node, direction) for every ghost, from robot.scores()",
        TypeError: "node() may return None; a ghost is a pair (node, direction)",
        nx.NodeNotFound: "the graph lacks a node; add_node each new one, also the first, and make "
        "one wherever node() is None, not only at the start",
        nx.NetworkXNoPath: f"no path leads there; {_EDGES}",
    }
    said = {
        "'int' object is not callable": "robot.steps is a number, without parentheses",
        "cannot unpack non-iterable int": "beside() returns a dictionary: go through its .items()",
        "unsupported operand type(s) for -: 'set' and 'tuple'": "a set of one ghost is {ghost}",
        "hypot": "the distance of a pose is np.hypot(pose[0], pose[1]); pose[2] is a heading",
    }
    try:
        return _play(student, building)
    except WrongAnswer as wrong:
        raise WrongAnswer(f"{what}: {wrong}") from None
    except NotImplementedError:
        raise
    except Exception as error:
        if isinstance(error, KeyError) and isinstance(error.args[0], int | np.integer):
            hints[KeyError] = "no edges lead to this node; " + _EDGES
        raise WrongAnswer(f"{what}: {explained(error, hints, said)}") from error


@check(
    explore,
    (PlacesRobot(BUILDINGS["a loop"]),),
    calls=10,
    endless="explore: your loop has not ended after {seconds:g} seconds. It ends when the goal is "
    "reached, when no ghost is left, and when robot.steps is 0",
)
def check_explore(student: Callable[..., Any]) -> None:
    """Corridors, dead ends, loops, mistakes, ghosts out of reach, and too few steps."""
    faults = with_faults(_explored, FAULTS)
    compare(
        "explore",
        student,
        {name: (building,) for name, building in BUILDINGS.items()},
        partial(_play, explore),
        {words: partial(_play, rule) for words, rule in faults.items()},
        invoke=_invoke,
        form=_formed,
        same=_same,
        difference=_why,
        broken=_broken,
    )


def _formed(what: str, got: tuple[Any, list[Any]], *_: object) -> tuple[Any, ...]:
    words = "return whether the goal was reached, the graph, and the set of ghosts"
    reached, graph, ghosts = parts(what, got[0], 3, words)
    if not isinstance(reached, bool | np.bool_):
        raise WrongAnswer(f"{what}: {reached!r} came back; return True if the goal was reached")
    if not isinstance(graph, nx.Graph) or graph.is_directed() or graph.is_multigraph():
        raise WrongAnswer(f"{what}: {kind(graph)} came back; return the graph, nx.Graph()")
    for v, w, metres in graph.edges(data="metres"):
        if metres is None:
            raise WrongAnswer(
                f'{what}: edge ({v}, {w}) has no "metres": add_edge(v, w, metres=...)'
            )
    if not isinstance(ghosts, set | frozenset):
        raise WrongAnswer(f"{what}: {kind(ghosts)} came back; return the set of ghosts")
    edges = {
        (min(v, w), max(v, w)): round(float(metres), 6)
        for v, w, metres in graph.edges(data="metres")
    }
    return bool(reached), sorted(graph.nodes), edges, set(ghosts), got[1]


def _same(got: tuple[Any, ...], want: tuple[Any, ...], *_: object) -> bool:
    return got == want


def _broken(got: tuple[Any, ...], want: tuple[Any, ...], *_: object) -> str:
    """Which part of the rule is broken where it first goes another way."""
    for mine, right in zip(got[4], want[4], strict=False):
        if mine != right:
            return _RULES[right[0]]
    if len(got[4]) != len(want[4]):
        return "go on until to_goal() returns True, no ghost is left, or robot.steps is 0"
    if got[0] != want[0]:
        return "return True where to_goal() returned True, and nowhere else"
    if got[1:3] != want[1:3]:
        return "a new node gets an edge to each node in beside(), with the metres to its pose"
    return "return the ghosts that add_ghosts made and to which the robot was never sent"


_RULES = {
    "to_goal": "where the robot sees the goal it drives there, before all else, in every round",
    "to_node": "the best ghost of all hangs on another node: first drive to the next node, by "
    "global_policy with the scores of all nodes, each as it was there when that node was new",
    "to_ghost": "the best ghost of all hangs on this node: drive to it, by global_policy with the "
    "scores of all nodes, each as it was there when that node was new",
}
"""For each drive, when it is right."""


def _why(got: tuple[Any, ...], want: tuple[Any, ...], *_: object) -> str:
    """Where an exploration first goes another way."""
    for number, (mine, right) in enumerate(zip(got[4], want[4], strict=False), 1):
        if mine != right:
            return f"drive {number} of yours is {_spoken(mine)}, but {_spoken(right)} is right"
    if len(got[4]) != len(want[4]):
        return f"yours drives {times(len(got[4]))}, but {times(len(want[4]))} is right"
    if got[0] != want[0]:
        return f"it returns {got[0]}, but {want[0]} is right"
    if got[1] != want[1]:
        return f"the nodes are {got[1]}, but {want[1]} is right"
    if got[2] != want[2]:
        edge = sorted(set(got[2].items()) ^ set(want[2].items()))[0][0]
        mine, right = got[2].get(edge), want[2].get(edge)
        if right is None:
            return f"edge {edge} is one too many: the nodes were not beside each other"
        if mine is None:
            return f"edge {edge} is missing: {_EDGES}, with the metres to them"
        words = "the metres of a pose are np.hypot(pose[0], pose[1]), as they are"
        return f"edge {edge} has {mine:g} m, but {right:g} m is right: {words}"
    return f"the ghosts left are {sorted(got[3])}, but {sorted(want[3])} is right"


def _spoken(drive: tuple[object, ...]) -> str:
    name, argument = drive
    return f"{name}({'' if argument is None else argument})"
