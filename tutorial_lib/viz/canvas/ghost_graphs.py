"""Graphs with ghost nodes, and what a robot has seen, drawn as the floor plan is."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.validation import flag, instance, instances, number, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import pairs_of, places_of, points_of
from tutorial_lib.viz.canvas.labels import label, text_size
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

UNSEEN = (206, 209, 214)
"""Of what no ray has reached yet."""
_TINTS = np.array([UNSEEN, colours.PAPER, colours.SOLID], np.uint8)  # unknown, free, occupied
_NODE, _GHOST = 0.22, 0.26
"""Metres of the discs of nodes, and of the rings of ghosts."""
GHOST = colours.PERSON
"""Of the ghost with the highest score."""
_LOW = (236, 226, 238)
"""Of that with the lowest."""


def draw_ghost_graph(
    view: PlanView,
    picture: Picture,
    nodes: ArrayLike,
    edges: Iterable[tuple[int, int]],
    ghosts: Sequence[tuple[int, ArrayLike, float]] = (),
    chosen: ArrayLike | None = None,
    written: bool = False,
) -> None:
    """Draw nodes with their numbers, edges, and ghosts, the darker the higher their score.

    Args:
        view: of the plan.
        picture: is drawn on.
        nodes: (V, 2) places, or (V, 3) poses.
        edges: pairs of nodes.
        ghosts: for each the node on which it hangs, its place (2,) and its score.
        chosen: (2,) the place to which the robot is going; an amber ring.
        written: whether the scores stand beside their ghosts.
    """
    places = points_of("nodes", nodes)
    written = flag("written", written)
    instance("view", view, PlanView)
    edges = pairs_of(edges, len(places), "nodes")
    ghosts = _checked(ghosts, len(places))
    for first, second in edges:
        view.polyline(picture, places[[first, second]], colours.INK, 3.0)
    for (_, place, _), tone in zip(ghosts, score_colours([g[2] for g in ghosts]), strict=True):
        view.disc(picture, place, _GHOST + 0.05, colours.FAINT)
        view.disc(picture, place, _GHOST, tone)
    for node, place, score in ghosts:
        gap = place - places[node]
        far = float(np.linalg.norm(gap))
        if far > _NODE + _GHOST:
            ends = places[node] + gap * np.array([[_NODE], [far - _GHOST]]) / far
            view.polyline(picture, ends, colours.FAINT, 1.0)
        if written:
            _write_score(view, picture, place, score)
    if chosen is not None:
        chosen = places_of("chosen", chosen, (2,))
        for radius in (0.42, 0.5):
            view.ring(picture, chosen, radius, colours.PATH)
    for node, place in enumerate(places):
        view.disc(picture, place, _NODE + 0.04, colours.PAPER)
        view.disc(picture, place, _NODE, colours.INK)
        wide, high = text_size(str(node), 0.5)
        corner = view.pixels(place) + np.array([-wide / 2, high / 2])
        column, row = np.round(corner).astype(int).tolist()
        label(picture, str(node), column, row, 0.5, colours.PAPER)


def _checked(
    ghosts: Sequence[tuple[int, ArrayLike, float]], nodes: int
) -> list[tuple[int, Array, float]]:
    """Ghosts on nodes that there are."""
    found = []
    for ghost in instances("ghosts", ghosts, Sequence):
        if len(ghost) != 3:
            raise InputError(f"ghosts: {ghost}; give a node, a place and a score of each")
        node = whole(f"ghosts on {nodes} nodes", ghost[0], least=0, most=nodes - 1)
        score = number("ghosts: score", ghost[2])
        found.append((node, places_of("ghosts: place", ghost[1], (2,)), score))
    return found


def _write_score(view: PlanView, picture: Picture, place: ArrayLike, score: float) -> None:
    """Write the score of a ghost to the right of it."""
    column, row = np.round(view.pixels(place)).astype(int).tolist()
    text = f"{score:.2f}".removeprefix("0")
    wide, high = text_size(text, 0.45)
    left, top = max(column + round(1.5 * _GHOST * view.scale), 0), max(row + 4 - high, 0)
    picture[top : top + high + 2, left : left + wide + 1] = colours.PAPER
    label(picture, text, left, top + high, 0.45)


def score_colours(scores: Sequence[float]) -> list[tuple[int, int, int]]:
    """A colour for each score, from pale for the lowest to blue for the highest of them."""
    values = np.asarray(scores, dtype=float)
    if not len(values):
        return []
    low, span = float(values.min()), float(np.ptp(values))
    share = (values - low) / span if span > 0 else np.ones(len(values))
    mixed = np.array(_LOW) + share[:, None] * (np.array(GHOST) - np.array(_LOW))
    return [(int(red), int(green), int(blue)) for red, green, blue in mixed.round()]


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
