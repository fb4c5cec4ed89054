"""The check of the global policy, in notebook 09."""

from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, calling, case, exercise, keeping, parts

Ghost = tuple[int, int]
Choice = tuple[int, Ghost | None]
"""The next node, and the ghost to which the robot is going."""
_FAR = 20.0  # metres at which a score is 0


def global_policy(
    graph: nx.Graph,
    here: int,
    ghosts: set[Ghost],
    scores: dict[Ghost, float],
    goal: int | None = None,
    weight: float = 0.0,
) -> Choice:
    """Where a robot goes next; see the exercise."""
    metres = nx.single_source_dijkstra_path_length(graph, here, weight="metres")

    def value(ghost: Ghost) -> float:
        cost = metres[ghost[0]]
        return scores[ghost] - weight * cost / _FAR

    if goal is None and not ghosts:
        return here, None
    if goal is None:
        ghost = max(sorted(ghosts), key=value)
        end = ghost[0]
    else:
        ghost, end = None, goal
    path = nx.shortest_path(graph, here, end, weight="metres")
    return path[min(1, len(path) - 1)], ghost


def _graph(*edges: tuple[int, int, float]) -> nx.Graph:
    graph = nx.Graph()
    graph.add_node(0)
    graph.add_weighted_edges_from(edges, weight="metres")
    return graph


def _case(
    graph: nx.Graph,
    here: int,
    ghosts: set[Ghost],
    scores: dict[Ghost, float] | None = None,
    goal: int | None = None,
    weight: float = 0.0,
) -> tuple[Any, ...]:
    """A case with all that the rule takes, some of the scores other than usual."""
    return graph, here, ghosts, _SCORES | (scores or {}), goal, weight


def _costs(
    graph: nx.Graph, here: int, scores: dict[Ghost, float], weight: float = 1.0
) -> tuple[Any, ...]:
    """A case in which all scores are those of ghosts; travelling costs, unless `weight` is 0."""
    return graph, here, set(scores), scores, None, weight


def _random(seed: int) -> tuple[Any, ...]:
    rng = np.random.default_rng([seed, 39])
    count = int(rng.integers(4, 9))
    edges = [(v, int(rng.integers(v)), float(rng.uniform(1, 4))) for v in range(1, count)]
    edges += [
        (int(v), int(w), float(rng.uniform(1, 6))) for v, w in rng.integers(count, size=(4, 2))
    ]
    graph = _graph(*[edge for edge in edges if edge[0] != edge[1]])
    scores = {(v, k): float(rng.uniform(0.3, 0.95)) for v in range(count) for k in range(12)}
    ghosts = {ghost for ghost in scores if rng.random() < 0.2}
    goal = int(rng.integers(count)) if seed % 3 == 0 else None
    return graph, int(rng.integers(count)), ghosts, scores, goal, float(rng.choice([0.0, 1.0, 3.0]))


_ROW = _graph((0, 1, 3.0), (1, 2, 3.0), (2, 3, 3.0))
_ROUND = _graph((0, 1, 2.0), (1, 2, 2.0), (2, 3, 2.0), (0, 3, 9.0))
_SCORES = {
    (v, k): round(0.3 + 0.01 * ((7 * v + 5 * k) % 23), 2) for v in range(4) for k in range(12)
}
CASES = {
    "one node": case(
        _graph(), 0, {(0, 1), (0, 2)}, {(0, 1): 0.6, (0, 2): 0.8, (0, 3): 0.9}, None, 0.0
    ),
    "ghosts along a row": _case(_ROW, 3, {(0, 4), (3, 1)}, {(0, 4): 0.9}),
    "the best ghost is that of the robot's node": _case(_ROW, 2, {(2, 5), (0, 1)}, {(2, 5): 0.8}),
    "the best score is that of no ghost": _case(_ROW, 1, {(0, 0), (3, 3)}, {(2, 2): 0.99}),
    "a long edge, and three short ones": _case(_ROUND, 0, {(3, 0)}),
    "the goal is in another node": _case(_ROW, 0, {(0, 4)}, goal=3),
    "the goal is at the end of a long edge, and of three short ones": _case(
        _ROUND, 0, {(1, 2)}, goal=3
    ),
    "scores of 0 and below": _costs(_ROW, 1, {(0, 1): -0.4, (3, 1): -0.2}, 0.0),
    "the goal is in node 0": _case(_ROW, 2, {(3, 4)}, goal=0),
    "the goal is in the robot's node": _case(_ROW, 2, {(0, 4)}, goal=2),
    "no ghost is left": _case(_ROW, 1, set()),
    "no ghost is left, but the goal is localised": _case(_ROW, 3, set(), goal=0),
    "travelling costs": _costs(_ROW, 0, {(0, 1): 0.7, (3, 1): 0.9}),
    "travelling costs too little to matter": _costs(_ROW, 0, {(0, 1): 0.7, (3, 1): 0.9}, 0.2),
    "travelling costs a little more than the better score gains": _costs(
        _ROW, 0, {(0, 1): 0.4, (3, 1): 0.84}
    ),
    "travelling costs a little less than the better score gains": _costs(
        _ROW, 0, {(0, 1): 0.4, (3, 1): 0.86}
    ),
    "travelling costs, by edges the other one is nearer": _costs(
        _graph((0, 1, 9.0), (0, 2, 2.0), (2, 3, 2.0)), 0, {(1, 1): 0.8, (3, 1): 0.75}
    ),
    "travelling costs, from the other end of the row": _costs(_ROW, 3, {(0, 1): 0.8, (2, 1): 0.75}),
    "travelling costs more than every score": _costs(
        _graph((0, 1, 30.0)), 0, {(1, 1): 0.4, (1, 2): 0.5}, 3.0
    ),
    "travelling costs, and a long edge is no short cut": _costs(
        _ROUND, 0, {(3, 1): 0.8, (1, 1): 0.55}
    ),
    "travelling costs, and a fraction of a metre decides": _costs(
        _graph((0, 1, 1.9), (0, 2, 1.0)), 0, {(1, 1): 0.8, (2, 1): 0.77}
    ),
    "travelling costs, and the third best score is here": _costs(
        _ROW, 0, {(3, 1): 0.9, (2, 1): 0.88, (0, 1): 0.7}
    ),
    "travelling costs half as much": _costs(_ROW, 0, {(0, 1): 0.5, (3, 1): 0.7}, 0.5),
    "travelling costs twice as much": _costs(_ROW, 0, {(0, 1): 0.1, (3, 1): 0.9}, 2.0),
    "the goal over short edges, and travelling costs": _case(
        _ROUND, 0, {(1, 2)}, goal=3, weight=1.0
    ),
    "the ghost over short edges, and travelling costs": _costs(_ROUND, 0, {(3, 1): 0.9}),
    "a fraction of a metre decides, and it would be rounded away": _costs(
        _graph((0, 1, 3.4), (0, 2, 2.6)), 0, {(1, 1): 0.72, (2, 1): 0.70}
    ),
    "both more than 20 m away": _costs(
        _graph((0, 1, 24.0), (0, 2, 34.0)), 0, {(1, 1): 0.5, (2, 1): 0.8}
    ),
    **{f"at random ({seed})": _random(seed) for seed in range(9)},
}
MISTAKES = """
once the goal is localised in a node the robot goes there; yours goes on exploring
    metres = nx -> goal = None; metres = nx
node 0 is a node: `if goal:` is False for it; compare with None
    metres = nx -> goal = goal or None; metres = nx
return None for the ghost where the goal is localised
    = None, goal -> = max(sorted(ghosts), key=value) if ghosts else None, goal
the highest score is the best; yours takes the lowest
    return scores[ghost] -> return -scores[ghost]
the score decides, not the distance to the ghost alone
    return scores[ghost] -> return -cost
only what is in `ghosts` can be chosen: scores also has directions that were explored, or never were
ghosts
    goal is None and not ghosts -> False
    sorted(ghosts) -> scores
all ghosts of the graph count, not only those of the node where the robot is
    sorted(ghosts) -> [one for one in sorted(ghosts) if one[0] == here] or sorted(ghosts)
the path is the shortest in metres, not the one of the fewest edges: weight='metres'
    end, weight="metres") -> end)
the path to the node of the goal is the shortest in metres, too: weight='metres'
    end, weight="metres" -> end, weight="metres" if goal is None else None
the path to a ghost is the shortest in metres, too: weight='metres'
    end, weight="metres" -> end, weight=None if goal is None else "metres"
the metres are not rounded: a fraction may decide
    cost = metres[ghost[0]] -> cost = round(metres[ghost[0]])
the cost goes on growing beyond 20 m
    cost = metres[ghost[0]] -> cost = min(metres[ghost[0]], _FAR)
a ghost may have a score of 0 or below; it is a ghost all the same
    goal is None and not ghosts -> goal is None and all(scores[ghost] <= 0 for ghost in ghosts)
the difference of score and cost, not their ratio
    scores[ghost] - weight * cost / _FAR -> scores[ghost] / (1.0 + weight * cost / _FAR)
the score counts fully, whatever the weight: only the cost is multiplied by it
    return scores[ghost] -> return (1.0 - weight) * scores[ghost]
return the next node on the path, not its end
    path[min(1, len(path) - 1)] -> path[-1]
return the next node on the path: the first one is the robot's own
    path[min(1, len(path) - 1)] -> path[0]
return the second node of the path, not the last but one
    path[min(1, len(path) - 1)] -> path[max(len(path) - 2, 0)]
the cost of travelling is taken away from the score; yours adds it
    - weight * cost -> + weight * cost
the distance in metres is divided by 20, as in the score itself
    / _FAR -> / 1.0
a ghost costs the metres of the path to its node, not its edges: weight='metres' there, too
    dijkstra_path_length(graph, here, weight="metres") -> shortest_path_length(graph, here)
the metres to a ghost are those from `here`, not from node 0
    path_length(graph, here -> path_length(graph, 0
a ghost costs the metres of the shortest path in metres, not those of the one of the fewest edges
    metres = nx.single_source_dijkstra_path_length(graph, here, weight="metres")
        -> few = nx.single_source_shortest_path(graph, here); metres = FEW
    FEW -> {node: nx.path_weight(graph, path, "metres") for node, path in few.items()}
where all values are below 0, one is the greatest nevertheless: a search that starts from 0 finds
none
    goal is None and not ghosts -> goal is None and max(map(value, ghosts), default=0.0) <= 0
`weight` itself multiplies the distance, even where it is below 1
    weight * cost -> (weight >= 1) * cost
`weight` may be more than 1
    weight * cost -> min(weight, 1.0) * cost
`weight` says how much travelling counts; in yours it changes nothing
    weight * cost -> 0.0 * cost
`weight` says how much travelling counts; yours always counts it
    weight * cost -> 1.0 * cost
"""
_HINTS: dict[type[Exception], str] = {
    KeyError: "scores[ghost] is the score of a ghost, a pair (node, direction)",
    ValueError: "max() of nothing: there may be no ghost left",
    TypeError: "a ghost is a pair (node, direction), and goal may be None",
    IndexError: "where the robot is at the end of the path already, the path has one node; "
    "and there may be no ghost left",
}


def _formed(what: str, got: object, graph: nx.Graph, *_: object) -> Choice:
    node, ghost = parts(what, got, 2, "return the next node, and the ghost or None")
    if isinstance(node, bool) or not isinstance(node, int | np.integer) or node not in graph:
        raise WrongAnswer(f"{what}: {node!r} is no node of the graph; return a node and a ghost")
    if ghost is not None and not (isinstance(ghost, tuple) and len(ghost) == 2):
        raise WrongAnswer(f"{what}: {ghost!r} is no ghost; return (node, direction), or None")
    return int(node), ghost


def _broken(got: Choice, want: Choice, *case: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    _, _, ghosts, _, goal, weight = case
    if goal is not None:
        return "with a goal the path leads to its node, and no ghost is at its end"
    if not ghosts:
        return "with neither a goal nor ghosts the robot stays: here, None"
    if got[1] is None:
        return "without a goal the best ghost is returned, also while its node is still far"
    if got[1] != want[1]:
        if weight:
            return (
                "the ghost with the greatest score - weight * metres / 20, with the metres of the "
                "whole shortest path to its node"
            )
        return "the ghost with the greatest score of all in `ghosts`, with its digits as they are"
    return "the next node on the path that is shortest in metres, even where weight is 0"


def _why(got: Choice, want: Choice, graph: nx.Graph, here: int, *_: object) -> str:
    """Which part is wrong."""
    if got[1] != want[1]:
        return f"from node {here} the robot goes to {_name(want[1])}; yours to {_name(got[1])}"
    return f"from node {here} the next node is {want[0]}, yours {got[0]}"


def _name(ghost: Ghost | None) -> str:
    return "no ghost" if ghost is None else f"ghost {ghost}"


check_global_policy = exercise(
    global_policy,
    CASES,
    MISTAKES,
    about="Goals and ghosts near and far, none of either, and costs of travelling.",
    example=_random(4),
    calls=300,
    invoke=keeping(global_policy, "it is needed again in the next step", calling(_HINTS)),
    form=_formed,
    difference=_why,
    broken=_broken,
)
