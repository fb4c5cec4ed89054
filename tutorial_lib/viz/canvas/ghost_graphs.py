"""Graphs with ghost nodes, and what a robot has seen, drawn as the floor plan is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.geometry import Array, to_local
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label, text_size
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

GHOST = colours.PERSON
"""Of ghost nodes, in all pictures."""
UNSEEN = (206, 209, 214)
"""Of what no ray has reached yet."""
_TINTS = np.array([UNSEEN, colours.PAPER, colours.SOLID], np.uint8)  # unknown, free, occupied
_NODE, _RING = 6.0, (7.0, 4.5)  # pixels


def draw_ghost_graph(
    view: PlanView,
    picture: Picture,
    nodes: ArrayLike,
    edges: Sequence[tuple[int, int]],
    ghosts: ArrayLike,
    hosts: Sequence[int],
    scores: Sequence[float] = (),
) -> None:
    """Draw nodes as dots, and ghosts as rings that hang on them, with their scores.

    Args:
        view: of the plan.
        picture: to draw on.
        nodes: (V, 2).
        edges: between nodes.
        ghosts: (G, 2).
        hosts: (G,) the node on which each ghost hangs.
        scores: (G,) written beside the ghosts; none unless given.
    """
    nodes = np.asarray(nodes, dtype=float).reshape(-1, 2)
    ghosts = np.asarray(ghosts, dtype=float).reshape(-1, 2)
    for ghost, host in zip(ghosts, hosts, strict=True):
        view.polyline(picture, np.stack([nodes[host], ghost]), GHOST, 1)
    for first, second in edges:
        view.polyline(picture, nodes[[first, second]], colours.INK, 2)
    view.points(picture, nodes, colours.INK, _NODE)
    for radius, colour in zip(_RING, (GHOST, colours.PAPER), strict=True):
        view.points(picture, ghosts, colour, radius)
    for ghost, score in zip(ghosts, scores, strict=False):
        column, row = np.round(view.pixels(ghost)).astype(int).tolist()
        text = f"{score:.2f}".removeprefix("0")
        wide, high = text_size(text, 0.45)
        left, top = max(column + 9, 0), max(row + 4 - high, 0)
        picture[top : top + high + 2, left : left + wide + 1] = colours.PAPER
        label(picture, text, left, top + high, 0.45)


def draw_seen(
    view: PlanView, grid: NDArray[np.uint8], corner: Array, resolution: float, frame: ArrayLike
) -> Picture:
    """An occupancy grid as a picture of the view's size.

    Args:
        view: of the plan.
        grid: (S, S) cells of 0 unknown, 1 free, 2 occupied; rows run along y, columns along x.
        corner: (2,) x and y of the first cell in the grid's frame, metres.
        resolution: metres of a cell.
        frame: (3,) pose of the grid's frame in the view.
    """
    rows, columns = np.indices(view.size)
    off = np.stack([columns, rows], axis=-1) + 0.5 - view.pixels([0.0, 0.0])
    points = to_local(np.asarray(frame, dtype=float), off * [1, -1] / view.scale)
    cells = np.floor((points - corner) / resolution).astype(int)
    inside = ((cells >= 0) & (cells < len(grid))).all(axis=-1)
    cells = np.clip(cells, 0, len(grid) - 1)
    return _TINTS[np.where(inside, grid[cells[..., 1], cells[..., 0]], 0)]
