"""Anchors of a trajectory, a follower's states, and the cover rate (Meng 2020, Figs. 5 to 7)."""

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.validation import alike, instance, instances, integers, number, one_of, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.anchors import STATES, draw_states, state_name, states_of
from tutorial_lib.viz.canvas.given import (
    LARGEST,
    check_canvas,
    picture_of,
    pictures_of,
    pixels_of,
    places_of,
)
from tutorial_lib.viz.canvas.labels import draw_badge, label
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.closeups import closeup
from tutorial_lib.viz.figures.panels import TITLE, camera_picture, side_by_side, stacked
from tutorial_lib.world.simulation import STEP

CONTEXTS = {"k0": colours.LASER, "k2": colours.GOAL, "k5": colours.ROBOT, "laser": colours.PATH}
"""A colour for each controller, by its context."""
_LONG = 10**6  # steps that a ribbon may stand for
_COLUMNS = {"method", "context", "sparsity", "stored", "cover_rate", "low", "high", "threshold"}
_BAR = 22  # pixels of a ribbon's height


def state_ribbon(states: ArrayLike, width: int = 960, longest: int | None = None) -> Picture:
    """A follower's states over time, as a bar of colours with seconds under it.

    Args:
        states: (T,) one for each control step.
        width: pixels of `longest` steps.
        longest: steps that fill the width; all of these unless given.
    """
    states, width = states_of(states), pixels_of("width", width, least=40)
    longest = len(states) if longest is None else whole("longest", longest, least=0, most=_LONG)
    longest = max(longest or len(states), 1)
    bar = np.full((_BAR + 20, width, 3), colours.PAPER, np.uint8)
    edges = np.round(np.arange(len(states) + 1) * width / longest).astype(int)
    for state, left, right in zip(states, edges, edges[1:], strict=False):
        bar[:_BAR, left:right] = STATES[State(state)]
    spacing = 5 if longest * STEP <= 60 else 20
    for second in range(0, int(longest * STEP) + 1, spacing):
        column = min(round(second / STEP * width / longest), width - 1)
        bar[_BAR : _BAR + 4, column] = colours.SOLID
        label(bar, f"{second} s", min(column, width - 40), _BAR + 17, 0.4, colours.SOLID)
    return bar


def state_legend(width: int = 960) -> Picture:
    """The names of the states beside their colours."""
    line = np.full((TITLE, pixels_of("width", width), 3), colours.PAPER, np.uint8)
    for place, (state, colour) in enumerate(STATES.items()):
        left = 4 + place * 170
        line[8:22, left : left + 22] = colour
        label(line, state_name(state), left + 30, 21, 0.5)
    return line


def follower_strip(
    view: PlanView,
    base: Picture,
    poses: ArrayLike,
    states: ArrayLike,
    steps: Sequence[int],
    footprint: ArrayLike,
    reach: float = 1.6,
    side: int = 230,
    discs: Mapping[int, NDArray[np.float64]] | None = None,
) -> Picture:
    """Moments of a rollout around the robot, each framed in the colour of its state.

    Args:
        view: the plan.
        base: the plan with what does not move, such as anchors.
        poses: (T, 3) of the robot.
        states: (T,).
        steps: indices of the moments to show.
        footprint: (K, 2) of the robot.
        reach: metres shown around the robot.
        side: pixels of each picture.
        discs: people and obstacles by step, (D, 3) as x, y, radius.
    """
    poses, states = places_of("poses", poses, ("T", 3)), states_of(states)
    alike(poses=poses, states=states)
    instance("view", view, PlanView)
    base, side = picture_of("base", base), pixels_of("side", side, least=12)
    reach = number("reach", reach, above=0.0, most=LARGEST / 3 / view.scale)
    discs = instance("discs", {} if discs is None else discs, Mapping)
    steps = integers(
        f"steps of {len(poses)} poses", steps, ("S",), least=0, most=len(poses) - 1, empty=False
    ).tolist()
    panels, titles = [], []
    for step in steps:
        picture = base.copy()
        draw_states(view, picture, poses[: step + 1], states[: step + 1], 4)
        for x, y, radius in discs.get(step, ()):
            view.disc(picture, [x, y], radius, colours.PERSON)
        view.robot(picture, poses[step], footprint)
        panel = closeup(view, picture, poses[step, :2], reach, square=True)
        panel = cv2.resize(panel, (side, side), interpolation=cv2.INTER_AREA)
        colour = STATES[State(states[step])]
        cv2.rectangle(panel, (2, 2), (side - 3, side - 3), colour, 5)
        panels.append(panel)
        titles.append(f"{step * STEP:.1f} s: {state_name(states[step])}")
    return side_by_side(panels, titles, gap=8)


def numbered_views(
    view: PlanView,
    picture: Picture,
    poses: ArrayLike,
    images: Sequence[NDArray[np.uint8]],
    width: int = 252,
    columns: int = 2,
    margin: float = 0.8,
    points: ArrayLike | None = None,
) -> Picture:
    """A path on the plan, and the images taken at numbered places along it (Fig. 6).

    The images stand beside the plan, or below it where it is wide.

    Args:
        view: the plan.
        picture: the plan with the path; the numbers are drawn on it.
        poses: (P, 3) of the numbered places.
        images: (H, W, 3) taken there.
        width: pixels of each image.
        columns: of images.
        margin: metres around the places.
        points: (Q, 2) that the cut-out must contain besides the numbered places.
    """
    poses = places_of("poses", poses, ("P", 3), empty=False)
    images, columns = pictures_of("images", images), whole("columns", columns, least=1)
    alike(poses=poses, images=images)
    check_canvas(picture)
    instance("view", view, PlanView)
    points = np.empty((0, 2)) if points is None else places_of("points", points, ("Q", 2))
    views = []
    for place, (pose, image) in enumerate(zip(poses, images, strict=True), 1):
        draw_badge(picture, str(place), view.pixels(pose[:2]))
        panel = camera_picture(image, width)
        draw_badge(panel, str(place), np.array([15.0, 15.0]))
        views.append(panel)
    held = np.concatenate([points, poses[:, :2]])
    rows = [side_by_side(views[i : i + columns], gap=6) for i in range(0, len(views), columns)]
    plan, seen = closeup(view, picture, held, margin), stacked(rows, gap=6)
    arrange = stacked if plan.shape[1] > 1.3 * plan.shape[0] else side_by_side
    return arrange([plan, seen], gap=12)


def cover_chart(
    rows: Sequence[Mapping[str, Any]], against: str = "sparsity", width: float = 9.0
) -> Picture:
    """Cover rate against sparsity (Fig. 7).

    Args:
        rows: of `experiment meng_fig7` under one condition; k = 5 is labelled by its thresholds.
        against: "sparsity" or "stored".
        width: inches.
    """
    against = one_of("against", against, ("sparsity", "stored"))
    for row in instances("rows", rows, Mapping, empty=False):
        if missing := _COLUMNS - row.keys():
            raise InputError(f"rows: one has no {min(missing)}; give rows of meng_fig7")
    figure, (axis,) = chart(width, 4.4)
    for method, context in dict.fromkeys((row["method"], str(row["context"])) for row in rows):
        own = [r for r in rows if (r["method"], str(r["context"])) == (method, context)]
        own.sort(key=lambda row: row[against])
        name = context if context in CONTEXTS else f"k{context}"
        colour = colours.unit(CONTEXTS.get(name, colours.INK))
        x, y = ([100 * row[key] for row in own] for key in (against, "cover_rate"))
        off = [[100 * abs(row[end] - row["cover_rate"]) for row in own] for end in ("low", "high")]
        style = {"color": colour, "linestyle": "-" if method == "meng" else "--"}
        mark = "o" if method == "meng" else "s"
        axis.errorbar(x, y, off, marker=mark, elinewidth=1, label=f"{method} {name}", **style)
        for row, *at in zip(own, x, y, strict=True):
            if method == "meng" and against == "sparsity" and name == "k5":
                words = {"xytext": (-5, 3), "textcoords": "offset points", "fontsize": 9}
                words["ha"] = "right"  # nothing is left of this line
                axis.annotate(f"{row['threshold']:g}", at, color=colour, **words)
    kept = "anchors" if against == "sparsity" else "frames kept with their context"
    axis.set(xlabel=f"{kept}, % of the frames", ylabel="length covered, %", ylim=(None, 101))
    figure.legend(loc="outside upper center", ncols=6, fontsize=10, frameon=False)
    return from_figure(figure)
