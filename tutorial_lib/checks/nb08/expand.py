"""The check of expansion from unused images, in notebook 08."""

from typing import Any

import networkx as nx

from tutorial_lib.checks.engine import WrongAnswer, calling, exercise
from tutorial_lib.checks.framework.answers import returned

Edge = tuple[int, int]


def expand(
    graph: nx.DiGraph, unused: list[int], joins: dict[int, list[Edge]], here: int, goal: int
) -> list[int]:
    """The unused images that the first path needs, in its order; see the exercise."""
    trial = graph.copy()
    for image in unused:
        trial.add_edges_from(joins[image])
        if nx.has_path(trial, here, goal):
            path = nx.shortest_path(trial, here, goal)
            return [vertex for vertex in path if vertex not in graph]
    return []


_TWO = nx.DiGraph([(0, 1), (1, 2), (3, 4), (4, 5)])


def _case(joins: dict[int, list[Edge]]) -> tuple[Any, ...]:
    """Images that are unused, in this order, and the edges of each, between two parts of a map."""
    return _TWO, list(joins), joins, 0, 5


CASES = {
    "one image joins two parts": _case({10: [(2, 10), (10, 3)]}),
    "one that does not help comes first": _case({10: [(1, 10), (10, 0)], 11: [(2, 11), (11, 3)]}),
    "two images in a row": _case({10: [(2, 10)], 11: [(10, 11), (11, 4)]}),
    "the second begins the path": _case(
        {10: [(10, 3)], 11: [(1, 11), (11, 1)], 12: [(2, 12), (12, 10)]}
    ),
    "images after the first path are not tried": _case(
        {10: [(2, 10)], 11: [(10, 11), (11, 3)], 12: [(0, 12), (12, 5)]}
    ),
    "no image helps": _case({10: [(10, 3)], 11: [(11, 0), (2, 11)]}),
    "edges that lead the wrong way": _case({10: [(3, 10), (10, 2)], 11: [(2, 11), (11, 5)]}),
    "nothing is unused": _case({}),
    "fewer edges, but more images": _case({10: [(0, 10)], 12: [(10, 12), (2, 12), (12, 3)]}),
    "a shorter path over what was tried before": _case(
        {10: [(0, 10)], 11: [(2, 11)], 12: [(11, 12), (10, 12), (12, 3)]}
    ),
}
MISTAKES = """
only images on the path are kept; yours keeps all that were tried
    [vertex for vertex in path if vertex not in graph] -> unused[: unused.index(image) + 1]
only the new images are asked for; the path's other vertices are in the map already
    [vertex for vertex in path if vertex not in graph] -> path
the path may need images that were tried before; yours keeps only the last
    [vertex for vertex in path if vertex not in graph] -> [image]
stop at the first path; yours tries all images before it looks
    for image in unused: -> for image in unused[-1:]:
    trial.add_edges_from(joins[image]) -> [trial.add_edges_from(joins[i]) for i in unused]
images that were tried stay in the trial, so that others can be joined to them
    trial.add_edges_from(joins[image]) -> (trial := graph.copy()).add_edges_from(joins[image])
edges are directed: a path must lead along them
    nx.has_path(trial, here, goal) -> nx.has_path(trial.to_undirected(), here, goal)
    nx.shortest_path(trial, here, goal) -> nx.shortest_path(trial.to_undirected(), here, goal)
the path leads from here to the goal, not back
    nx.has_path(trial, here, goal) -> nx.has_path(trial, goal, here)
    nx.shortest_path(trial, here, goal) -> nx.shortest_path(trial, goal, here)
"""


def _formed(what: str, got: Any, *_: object) -> list[int]:  # noqa: ANN401 - whatever students return
    got = returned(what, got)
    try:
        return [int(image) for image in got]
    except (TypeError, ValueError) as error:
        raise WrongAnswer(f"{what}: return a list of images") from error


def _broken(got: list[int], want: list[int], *_: Any) -> str:  # noqa: ANN401
    if got and not want:
        return "where no path can be found, nothing is kept"
    if want and not got:
        return "there is a path, over images that you tried"
    return "kept are those images that are on the first path that is found, and no others"


check_expand = exercise(
    expand,
    CASES,
    MISTAKES,
    about="Two parts of a map, and images that join them, or do not.",
    example=CASES["two images in a row"],
    calls=20,
    invoke=calling(
        {
            nx.NodeNotFound: "is `here`, or the goal, in your graph? Begin with a copy of the map",
            nx.NetworkXNoPath: "ask nx.has_path before you ask for a path",
        }
    ),
    form=_formed,
    same=lambda got, want, *_: sorted(got) == sorted(want),
    difference=lambda got, want, *_: f"{got} is kept, but {want} is right",
    broken=_broken,
)
