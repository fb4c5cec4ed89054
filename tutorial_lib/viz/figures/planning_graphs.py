"""Small graphs with RE on their edges, for planning by hand."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, with_methods
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.charts import chart, from_figure

_PLACES = {
    "here": (0.05, 0.5),
    "A": (0.42, 0.93),
    "B": (0.32, 0.64),
    "C": (0.72, 0.55),
    "D": (0.46, 0.37),
    "E": (0.56, 0.06),
    "goal": (0.95, 0.5),
}


def graph_picture(graph: Mapping[Any, Mapping[Any, float]], path: Sequence[Any] = ()) -> Picture:
    """A small graph with RE beside its edges; those of `path` stand out.

    Args:
        graph: for each vertex of the example by hand, its successors with the RE of each edge.
        path: vertices in order.
    """
    from matplotlib.patches import FancyArrowPatch

    edges_of = with_methods("graph", graph, "items", "get")
    if not all(isinstance(edges, Mapping) for edges in edges_of.values()):
        raise InputError("graph: give for each vertex its successors, {vertex: {successor: RE}}")
    path = instance("path", path, Sequence)
    lost = {*graph, *(v for edges in graph.values() for v in edges), *path} - set(_PLACES)
    if lost:
        raise InputError(
            f"graph, path: no place for {min(map(str, lost))}; give {', '.join(_PLACES)}"
        )
    figure, (axis,) = chart(6.4, 0.62 * 6.4)
    axis.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.02))
    axis.axis("off")
    taken = set(pairwise(path))
    for source, edges in graph.items():
        for target, probability in edges.items():
            both = source in graph.get(target, {})
            colour = colours.unit(colours.PATH if (source, target) in taken else colours.FAINT)
            arrow = FancyArrowPatch(
                _PLACES[source],
                _PLACES[target],
                connectionstyle=f"arc3,rad={-0.18 if both else 0.0}",
                arrowstyle="-|>",
                mutation_scale=14,
                shrinkA=14,
                shrinkB=14,
                linewidth=3.0 if (source, target) in taken else 1.2,
                color=colour,
            )
            axis.add_patch(arrow)
            beside = _beside(_PLACES[source], _PLACES[target], both)
            under = {"boxstyle": "round,pad=0.1", "color": "white", "alpha": 0.8}
            axis.text(*beside, f"{probability:g}", bbox=under, **_words(11))
    for vertex, (x, y) in _PLACES.items():
        if vertex in graph:
            on = vertex in path
            tone = _tone(vertex, on)
            box = {"boxstyle": "round,pad=0.35", "color": colours.unit(tone)}
            ink = colours.INK if tone == colours.PATH else colours.PAPER
            axis.text(x, y, str(vertex), **_words(13), color=colours.unit(ink), bbox=box)
    return from_figure(figure)


def _beside(
    first: tuple[float, float], last: tuple[float, float], both: bool
) -> tuple[float, float]:
    """Where the RE of an edge is written."""
    aside = 0.11 if both else 0.0
    along = (last[0] - first[0], last[1] - first[1])
    x = first[0] + 0.5 * along[0] - aside * along[1]
    return x, first[1] + 0.5 * along[1] + aside * along[0]


def _tone(vertex: object, on: bool) -> tuple[int, int, int]:
    if vertex in ("here", "goal"):
        return colours.ROBOT if vertex == "here" else colours.GOAL
    return colours.PATH if on else colours.SOLID


def _words(size: int) -> dict[str, Any]:
    return {"ha": "center", "va": "center", "fontsize": size}
