"""Rules of following: a table of reachabilities with the chosen anchors, and the state machine."""

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.validation import floats, integers, number, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.anchors import STATES, state_name
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.edge_tables import CELL, FAILS, HOLDS, SIZE, draw_cell

_MOST = 900  # frames in a row of boxes
_PLACES = {
    State.SEARCH: (0.10, 0.80),
    State.FOLLOW: (0.44, 0.80),
    State.DEAD_RECKONING: (0.80, 0.80),
    State.DONE: (0.44, 0.44),
    State.LOST: (0.44, 0.10),
}
# From, to, how far the arrow bends, the condition, and where it is written.
_TRANSITIONS = (
    (State.SEARCH, State.FOLLOW, 0.0, "RE(best) > p_search", (0.265, 0.86)),
    (State.SEARCH, State.LOST, 0.0, "otherwise", (0.20, 0.42)),
    (State.FOLLOW, State.DEAD_RECKONING, -0.3, "RE(active) too low", (0.60, 0.97)),
    (State.DEAD_RECKONING, State.FOLLOW, -0.3, "RE(active) > p_follow", (0.58, 0.61)),
    (State.FOLLOW, State.DONE, 0.0, "at the last anchor", (0.345, 0.60)),
    (State.DEAD_RECKONING, State.LOST, 0.0, "for too long", (0.69, 0.34)),
)


def reach_table(reach: ArrayLike, threshold: float, anchors: Sequence[int] = ()) -> Picture:
    """RE (T, T) from each frame (row) to each later one (column).

    Values above the threshold are green, the rest red. The rows of `anchors` stand out; in each,
    the next anchor is ringed.
    """
    reach = floats("reach", reach, ("T", "T"))
    if reach.shape[0] != reach.shape[1]:
        raise InputError(f"reach: shape {reach.shape}; give (T, T)")
    threshold = number("threshold", threshold)
    anchors = _frames("anchors", anchors, len(reach))
    side = (len(reach) + 1) * CELL
    picture = np.full((side + 1, side + 1, 3), colours.PAPER, np.uint8)
    following = dict(pairwise(anchors))
    for row, line in enumerate(reach):
        for column in range(row + 1, len(reach)):
            left, top = (column + 1) * CELL, (row + 1) * CELL
            colour = np.array(HOLDS if line[column] > threshold else FAILS)
            if len(following) and row not in following:
                colour = (colour + 2 * np.array(colours.PAPER)) // 3
            draw_cell(picture, left, top, colour, line[column])
            if following.get(row) == column:
                corner = (left + CELL - 3, top + CELL - 3)
                cv2.rectangle(picture, (left, top), corner, colours.GOAL, 3)
    for frame in range(len(reach)):
        colour = colours.GOAL if frame in anchors else colours.SOLID
        label(picture, str(frame), (frame + 1) * CELL + 16, 30, SIZE, colour)
        label(picture, str(frame), 16, (frame + 1) * CELL + 30, SIZE, colour)
    label(picture, "from", 2, CELL + 4, 0.55, colours.SOLID)
    label(picture, "to", CELL - 12, 16, 0.55, colours.SOLID)
    return picture


def frames_kept(total: int, kept: Sequence[int], anchors: Sequence[int]) -> Picture:
    """Frames 0 to `total` - 1 as a row of boxes: filled where kept, green where an anchor."""
    total, width = whole("total", total, least=1, most=_MOST), 18
    kept, anchors = _frames("kept", kept, total), _frames("anchors", anchors, total)
    row = np.full((44, total * width, 3), colours.PAPER, np.uint8)
    for frame in range(0, total, 6):
        label(row, str(frame), frame * width + 1, 40, 0.42, colours.SOLID)
    for frame in range(total):
        left = frame * width
        colour = colours.PATH if frame in kept else colours.PAPER
        colour = colours.GOAL if frame in kept and frame in anchors else colour
        cv2.rectangle(row, (left + 1, 3), (left + width - 3, 22), colour, cv2.FILLED)
        cv2.rectangle(row, (left + 1, 3), (left + width - 3, 22), colours.FAINT, 1)
    return row


def _frames(name: str, frames: Sequence[int], total: int) -> list[int]:
    """Indices of frames, or an `InputError`."""
    return integers(name, frames, ("A",), least=0, most=total - 1).tolist()


def follower_machine() -> Picture:
    """The follower's states and transitions (Meng 2020, III-H)."""
    from matplotlib.patches import FancyArrowPatch

    figure, (axis,) = chart(9.0, 3.4)
    axis.set(xlim=(0, 1), ylim=(0, 1))
    axis.axis("off")
    boxes = {}
    for state, (x, y) in _PLACES.items():
        box = {"boxstyle": "round,pad=0.5", "color": colours.unit(STATES[state])}
        words = {"ha": "center", "va": "center", "color": "white", "fontsize": 13, "bbox": box}
        boxes[state] = axis.text(x, y, state_name(state), **words).get_bbox_patch()
    figure.draw_without_rendering()  # the boxes are as large as their words only now
    for start, end, bend, words, (x, y) in _TRANSITIONS:
        arrow = FancyArrowPatch(
            _PLACES[start],
            _PLACES[end],
            connectionstyle=f"arc3,rad={bend}",
            arrowstyle="-|>",
            mutation_scale=16,
            patchA=boxes[start],
            patchB=boxes[end],
            shrinkA=3,
            shrinkB=3,
            color=colours.unit(colours.SOLID),
        )
        axis.add_patch(arrow)
        axis.text(x, y, words, ha="center", va="center", fontsize=11)
    return from_figure(figure)
