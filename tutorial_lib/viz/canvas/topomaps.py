"""Topological maps drawn on the floor plan, which they do not know (Meng 2020, Figs. 4 and 8)."""

import colorsys
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import flag, instance, integers, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import pairs_of, places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.world.materials import Colour

_MANY = 10**9  # trajectories; more have no hues that differ
_GOLDEN = 0.618034  # of the circle of hues from one trajectory to the next
_ASIDE = 0.05  # metres to the right of its line that an edge is drawn, so that opposite ones differ
_HEAD = 0.62  # share of an edge at which its arrowhead lies


def hue(number: int) -> Colour:
    """A colour for each trajectory; consecutive ones differ clearly."""
    number = whole("number", number, least=-_MANY, most=_MANY)
    red, green, blue = colorsys.hsv_to_rgb((0.58 + number * _GOLDEN) % 1.0, 0.75, 0.8)
    return round(255 * red), round(255 * green), round(255 * blue)


def draw_topomap(view: PlanView, picture: Picture, topomap: TopoMap, poses: ArrayLike) -> None:
    """Draw a map: an arrowhead for each vertex, in the colour of its trajectory, and its edges.

    Args:
        view: of the plan.
        picture: to draw on.
        topomap: the map.
        poses: (V, 3) where its vertices were recorded, see `experiments.vertex_poses`.
    """
    if not all(hasattr(topomap, part) for part in ("graph", "trajectory", "alive")):
        raise InputError(f"topomap: {topomap!r}; give a map of V vertices")
    poses = places_of("poses", poses, (len(topomap.trajectory), 3))
    draw_edges(view, picture, poses, topomap.graph.edges, colours.FAINT)
    for vertex in topomap.alive:
        view.arrow(picture, poses[vertex], hue(int(topomap.trajectory[vertex])), 4.0)


def draw_edges(
    view: PlanView,
    picture: Picture,
    poses: Array,
    edges: Iterable[tuple[int, int]],
    colour: Colour,
    width: float = 1.2,
    heads: bool = False,
) -> None:
    """Draw edges between vertices at poses (V, 3), each a little to the right of its line."""
    instance("view", view, PlanView)
    poses = places_of("poses", poses, ("V", 3))
    heads = flag("heads", heads)
    edges = pairs_of(edges, len(poses), "poses")
    for source, target in edges:
        first, last = poses[source, :2], poses[target, :2]
        along = last - first
        length = float(np.linalg.norm(along))
        if not length:
            continue
        along = along / length
        aside = _ASIDE * np.array([along[1], -along[0]])
        view.polyline(picture, np.stack([first + aside, last + aside]), colour, width)
        if heads:
            middle = first + _HEAD * length * along + aside
            view.arrow(picture, [*middle, np.arctan2(along[1], along[0])], colour, 3.0 + width)


def draw_plan(
    view: PlanView,
    picture: Picture,
    poses: ArrayLike,
    vertices: ArrayLike,
    here: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    colour: Colour = colours.PATH,
) -> None:
    """Draw a path over vertices at poses (V, 3), from the robot and to the goal where given."""
    instance("view", view, PlanView)
    poses = places_of("poses", poses, ("V", 3))
    vertices = integers(
        f"vertices of {len(poses)} poses", vertices, ("P",), least=0, most=len(poses) - 1
    )
    ends = {"here": here, "goal": goal}
    here, goal = (None if one is None else places_of(n, one, (3,)) for n, one in ends.items())
    places = [one for one in (here, *poses[vertices], goal) if one is not None]
    for first, last in pairwise(places):
        view.polyline(picture, np.stack([first[:2], last[:2]]), colour, 3.0)
    for vertex in vertices:
        view.arrow(picture, poses[vertex], colour, 6.0)
    if goal is not None:
        view.goal(picture, goal[:2])
