"""The check of the exploration loop, in notebook 09."""

from collections.abc import Callable
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, calling, case, edited, exercise, kind, parts
from tutorial_lib.checks.framework.explanation import Hints
from tutorial_lib.checks.framework.wording import times
from tutorial_lib.checks.nb09.add_ghosts import add_ghosts
from tutorial_lib.checks.nb09.global_policy import global_policy
from tutorial_lib.checks.nb09.small_places import BUILDINGS, Building, Ghost, PlacesRobot

Explored = tuple[bool, nx.Graph, set[Ghost]]
"""Whether the goal was reached, the graph, and the ghosts that are left."""
_EDGES = "each new node gets edges to those beside it"


def explore(robot: Any) -> Explored:  # noqa: ANN401
    """Explore until the goal is found, nothing is left, or no steps are; see the exercise.

    Args:
        robot: a `PlacesRobot`, or one of the real task.
    """
    graph, ghosts, scores, arrived = nx.Graph(), set(), {}, False
    while robot.steps > 0:
        if robot.sees_goal():
            found = robot.to_goal()
            if found:
                return True, graph, ghosts
        here = robot.node()
        if here is None or arrived:
            here, beside = len(graph), robot.beside()
            graph.add_node(here)
            for other, pose in beside.items():
                graph.add_edge(here, other, metres=float(np.hypot(pose[0], pose[1])))
            ghosts = add_ghosts(ghosts, here, robot.explorable(), beside)
            scores |= {(here, k): float(score) for k, score in enumerate(robot.scores())}
            robot.remember(here)
        node, ghost = global_policy(graph, here, ghosts, scores)
        if ghost is None:
            break
        if node != here:
            robot.to_node(node)
            arrived = False
            continue
        arrived = robot.to_ghost(ghost)
        ghosts = ghosts - {ghost}
    return False, graph, ghosts


MISTAKES = """
look for the goal in every round: a robot that looks only at the start passes it
    if robot.sees_goal(): -> if not graph and robot.sees_goal():
the goal may also be seen on the way, at a node: call sees_goal() in every round
    if robot.sees_goal(): -> if arrived and robot.sees_goal():
the goal may also be seen on the way, from a node that is known: call sees_goal() in every round
    if robot.sees_goal(): -> if (arrived or not graph) and robot.sees_goal():
the goal may also be seen from a node that is known: call sees_goal() in every round, not only where
a node is new
    if robot.sees_goal(): -> if (arrived or robot.node() is None) and robot.sees_goal():
call sees_goal(), and to_goal() where it is seen
    if robot.sees_goal(): -> if False:
to_node() drives to the next node alone; then a new round begins, which looks for the goal from
there
    robot.to_node(node) -> [robot.to_node(v) for v in nx.shortest_path(graph, here, ghost[0])[1:]]
the first node has ghosts: keep the new set, ghosts = add_ghosts(...), and ask global_policy without
a goal
    ghosts = add_ghosts( -> add_ghosts(
the robot has reached the goal only if to_goal() returned True
    found = robot.to_goal() -> found = robot.to_goal() or True
the robot has still just arrived at a ghost where it then took something for the goal: that place
becomes a node
    found = robot.to_goal() -> found, arrived = robot.to_goal(), False
to_goal() returns False where something was mistaken for the goal; then go on exploring
    if found: -> if True:
    return True, graph, ghosts -> return found, graph, ghosts
the last step counts as well: go on while robot.steps is above 0
    robot.steps > 0 -> robot.steps > 1
the score alone chooses the ghost, as in the paper: no weight for global_policy
    here, ghosts, scores) -> here, ghosts, scores, weight=1.0)
the score alone chooses the ghost, as in the paper: call global_policy without a weight
    here, ghosts, scores) -> here, ghosts, scores, weight=0.3)
the loop ends when robot.steps is 0
    robot.steps > 0 -> True
a ghost that was reached becomes a node even where F_L still has the robot in the old one
    here is None or arrived -> here is None
a ghost that was reached becomes a node, whatever node F_L takes it for
    graph, ghosts, scores, arrived = nx -> last = -1; graph, ghosts, scores, arrived = nx
    here is None or arrived -> here is None or (arrived and here == last)
    node, ghost = -> last = here; node, ghost =
remove the ghost to which the robot was sent, not the others of its node
    ghosts = ghosts - {ghost} -> ghosts = {other for other in ghosts if other[0] != here}
the ghosts of earlier nodes stay: give add_ghosts the ghosts so far
    add_ghosts(ghosts, -> add_ghosts(set(),
the scores of earlier nodes stay: add the new ones to them
    scores |= -> scores = dict.fromkeys(ghosts, 0.0) |
ask for scores() only where a node is new: at a known node the robot looks another way than it did
then, and directions are counted from there
    node, ghost =
        -> scores |= {(here, k): float(s) for k, s in enumerate(robot.scores())}; node, ghost =
give add_ghosts the nodes beside the new one, robot.beside(); where they stand there is no ghost
    robot.explorable(), beside) -> robot.explorable(), {})
the new node gets an edge to every node beside it, not only to the last one
    graph, ghosts, scores, arrived = nx -> last = -1; graph, ghosts, scores, arrived = nx
    in beside.items(): -> in [item for item in beside.items() if item[0] == last]:
    node, ghost = -> last = here; node, ghost =
an edge has the metres between its nodes, np.hypot of x and y
    float(np.hypot(pose[0], pose[1])) -> 1.0
the best ghost of the whole graph is next, however far away: not that of the node where the robot
is, and no weight of the metres in global_policy
    node, ghost = -> own = {one for one in ghosts if one[0] == here} or ghosts; node, ghost =
    (graph, here, ghosts, scores) -> (graph, here, own, scores)
remove the ghost after the drive, reached or not, or the robot will want to go there again
    ghosts = ghosts - {ghost} -> pass
remove the ghost even where to_ghost returned False: it cannot be reached
    ghosts = ghosts - {ghost} -> ghosts = ghosts - {ghost} if arrived else ghosts
"""
OTHERS = {
    "to_goal() returned False: go on below, in this round, with the node and its ghosts": edited(
        explore, [("if found:", "if not found:\n                continue\n            if found:")]
    ),
}


def _play(explores: Callable[..., Any], building: Building) -> tuple[Any, list[tuple[object, ...]]]:
    """What comes back, and where the robot was driven."""
    robot = PlacesRobot(building)
    found = explores(robot)
    robot.demand_untouched()
    return found, robot.log


def _without_key(error: KeyError) -> str:
    if isinstance(error.args[0], int | np.integer):
        return f"no edges lead to this node; {_EDGES}"
    return "scores needs an entry (node, direction) for every ghost, from robot.scores()"


_HINTS: Hints = {
    KeyError: _without_key,
    TypeError: "node() may return None; a ghost is a pair (node, direction)",
    nx.NodeNotFound: "the graph lacks a node; add_node each new one, also the first, and make "
    "one wherever node() is None, not only at the start",
    nx.NetworkXNoPath: f"no path leads there; {_EDGES}",
}
_SAID = {
    "'int' object is not callable": "robot.steps is a number, without parentheses",
    "cannot unpack non-iterable int": "beside() returns a dictionary: go through its .items()",
    "unsupported operand type(s) for -: 'set' and 'tuple'": "a set of one ghost is {ghost}",
    "hypot": "the distance of a pose is np.hypot(pose[0], pose[1]); pose[2] is a heading",
}


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


check_explore = exercise(
    explore,
    {name: case(building) for name, building in BUILDINGS.items()},
    MISTAKES,
    about="Corridors, dead ends, loops, mistakes, ghosts out of reach, and too few steps.",
    example=case(PlacesRobot(BUILDINGS["a loop"])),
    others=OTHERS,
    calls=10,
    endless="explore: your loop has not ended after {seconds:g} seconds. It ends when the goal is "
    "reached, when no ghost is left, and when robot.steps is 0",
    run=_play,
    invoke=calling(_HINTS, _SAID, _play),
    form=_formed,
    same=lambda got, want, *_: got == want,
    difference=_why,
    broken=_broken,
)
