"""A graph with ghost nodes on the plan, or on white where the plan is hidden."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label, text_size
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

_NODE, _GHOST = 0.22, 0.26
"""Metres of the discs of nodes, and of the rings of ghosts."""
_LOW, _HIGH = (222, 232, 240), colours.ROBOT
"""Colours of the lowest and of the highest score."""


def draw_ghost_graph(
    view: PlanView,
    picture: Picture,
    nodes: ArrayLike,
    edges: Iterable[tuple[int, int]],
    ghosts: Sequence[tuple[int, ArrayLike, float]] = (),
    chosen: ArrayLike | None = None,
) -> None:
    """Draw nodes with their numbers, edges, and ghosts, the darker the higher their score.

    Args:
        view: of the plan.
        picture: is drawn on.
        nodes: (V, 2) places, or (V, 3) poses.
        edges: pairs of nodes.
        ghosts: for each the node on which it hangs, its place (2,) and its score.
        chosen: (2,) the place to which the robot is going; a green ring.
    """
    places = np.asarray(nodes, dtype=float)[:, :2]
    for first, second in edges:
        view.polyline(picture, places[[first, second]], colours.INK, 3.0)
    for (_, place, _), tone in zip(ghosts, score_colours([g[2] for g in ghosts]), strict=True):
        view.disc(picture, place, _GHOST + 0.05, colours.FAINT)
        view.disc(picture, place, _GHOST, tone)
    for node, place, _ in ghosts:
        gap = np.asarray(place, dtype=float) - places[node]
        far = float(np.linalg.norm(gap))
        if far > _NODE + _GHOST:
            ends = places[node] + gap * np.array([[_NODE], [far - _GHOST]]) / far
            view.polyline(picture, ends, colours.FAINT, 1.0)
    if chosen is not None:
        for radius in (0.42, 0.5):
            view.ring(picture, chosen, radius, colours.GOAL)
    for number, place in enumerate(places):
        view.disc(picture, place, _NODE + 0.04, colours.PAPER)
        view.disc(picture, place, _NODE, colours.INK)
        wide, high = text_size(str(number), 0.5)
        corner = view.pixels(place) + np.array([-wide / 2, high / 2])
        label(picture, str(number), *np.round(corner).astype(int).tolist(), 0.5, colours.PAPER)


def score_colours(scores: Sequence[float]) -> list[tuple[int, int, int]]:
    """A colour for each score, from pale for the lowest to blue for the highest of them."""
    values = np.asarray(scores, dtype=float)
    if not len(values):
        return []
    low, span = float(values.min()), float(np.ptp(values))
    share = (values - low) / span if span > 0 else np.ones(len(values))
    mixed = np.array(_LOW) + share[:, None] * (np.array(_HIGH) - np.array(_LOW))
    return [(int(red), int(green), int(blue)) for red, green, blue in mixed.round()]
