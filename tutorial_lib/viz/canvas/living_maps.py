"""A map that mends itself, drawn on the floor plan: what it believes, and what it has pruned."""

from collections import defaultdict
from collections.abc import Iterable

import networkx as nx
import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.validation import instance, number
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import pairs_of, places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.topomaps import draw_edges
from tutorial_lib.world.materials import Colour

_STEPS = 10  # shades of belief
_SURE, _DOUBTED, _PRUNED = 1.2, 2.4, 2.0  # pixels of an edge's width
_DASH = 0.25  # metres of a dash, and of the gap after it


def belief_colour(probability: float) -> Colour:
    """Grey for an edge that surely exists, vermilion for one that is doubted.

    The scale of `probability_colours` would not do: its middle vanishes on a pale floor, and its
    blue is the robot's.

    >>> belief_colour(1.0) == colours.FAINT, belief_colour(0.0) == colours.LASER
    (True, True)
    """
    share = number("probability", probability, least=0.0, most=1.0)
    mixed = (1 - share) * np.array(colours.LASER) + share * np.array(colours.FAINT)
    red, green, blue = mixed.round().astype(int).tolist()
    return red, green, blue


def draw_living_map(
    view: PlanView,
    picture: Picture,
    poses: ArrayLike,
    graph: nx.DiGraph,
    pruned: Iterable[tuple[int, int]] = (),
) -> None:
    """Draw the edges in the colour of what is believed of them; the pruned ones are dashed.

    Args:
        view: of the plan.
        picture: to draw on.
        poses: (V, 3) where the images of the map were taken.
        graph: its vertices are images; its edges have a `probability`.
        pruned: edges that are not in the graph now.
    """
    instance("view", view, PlanView)
    instance("graph", graph, nx.DiGraph)
    poses = places_of("poses", poses, ("V", 3))
    shades = defaultdict(list)
    for source, target, probability in graph.edges(data="probability"):
        share = number("graph: probability", probability, least=0.0, most=1.0)
        shades[round(share * _STEPS)].append((source, target))
    for shade in sorted(shades, reverse=True):  # what is doubted lies on top
        share = shade / _STEPS
        width = _SURE if share > 0.5 else _DOUBTED
        draw_edges(view, picture, poses, shades[shade], belief_colour(share), width)
    for source, target in pairs_of(pruned, len(poses), "poses", "pruned"):
        ends = poses[[source, target], :2]
        view.polyline(picture, ends, colours.PAPER, _PRUNED + 2)  # or edges beside it fill the gaps
        for dash in _dashes(*ends):
            view.polyline(picture, dash, colours.INK, _PRUNED)


def _dashes(first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Pieces (D, 2, 2) of the line between two points (2,)."""
    count = max(1, round(float(np.linalg.norm(last - first)) / (2 * _DASH)))
    begins = np.arange(count)[:, None] / count
    ends = begins + 0.5 / count
    return np.stack([first + begins * (last - first), first + ends * (last - first)], axis=1)
