"""The pictures of Figs. 3, 4, 9 and 10 of Chaplot et al. 2020, from their rows alone."""

from typing import Any

import numpy as np

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.ghost_graphs import draw_ghost_graph
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.directions import panorama_picture, scored_panorama
from tutorial_lib.viz.figures.panels import faded, side_by_side, stacked
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of

_SHARP = PanoramicCamera(rows=64, columns=768)
_WIDE, _PLAN = 960, 460  # pixels
_BEYOND = 3.5  # metres around what is drawn on a plan
_TRACKS = (colours.ROBOT, colours.TRACK, colours.LASER, colours.PATH)

Row = dict[str, Any]


def pictures(rows: Rows) -> dict[str, Picture]:
    """The picture of each figure that has rows, by "fig3", "fig4", "fig9" and "fig10"."""
    draw = {3: _explorable, 4: _scores, 9: _trajectories, 10: _choices}
    found = {}
    for figure, drawing in draw.items():
        mine = [row for row in rows if row["figure"] == figure]
        worlds = dict.fromkeys(row["world"] for row in mine)
        parts = [drawing([row for row in mine if row["world"] == world]) for world in worlds]
        if parts:
            found[f"fig{figure}"] = stacked(parts, list(worlds))
    return found


def _explorable(rows: Rows) -> Picture:
    """Panoramas with the probability that each direction is explorable, and the labels."""
    return stacked(
        [_scored(row) for row in rows],
        [
            f"is it explorable? Bars: probability, dark above 0.5; orange: the label. "
            f"{row['agree']} of 12 agree"
            for row in rows
        ],
    )


def _scores(rows: Rows) -> Picture:
    """One source with its scores towards each of two goals, under the goal's picture."""
    parts, titles = [], []
    for row in rows:
        parts += [panorama_picture(_look(row["goal"], row["world"]), _WIDE, 64), _scored(row)]
        titles += [
            f"the goal: {row['what']}",
            f"the source. Bars: scores, dark: explorable, green: chosen ({row['chosen']}, best "
            f"{row['best']}); orange: the label",
        ]
    return stacked(parts, titles)


def _scored(row: Row) -> Picture:
    """The panorama at a row's pose with its scores and what they should be."""
    image = _look(row["pose"], row["world"])
    known = np.array(row["explorable"], bool)
    return scored_panorama(image, row["scores"], known, row["chosen"], row["truth"], _WIDE)


def _trajectories(rows: Rows) -> Picture:
    """The tracks of all agents, and the graph of the first one at four moments."""
    view = _view(rows)
    base = faded(view.base, 0.5)
    plans, titles = [], []
    for row, colour in zip(rows, _TRACKS, strict=True):
        plan = base.copy()
        view.polyline(plan, row["track"], colour, 3)
        _draw_ends(view, plan, row)
        plans.append(plan)
        ended = "" if row["success"] else ", missed"
        titles.append(f"{row['what']}: {row['steps']} steps, {row['travelled']:.1f} m{ended}")
    lines = [side_by_side(plans, titles)]
    moments = rows[0]["moments"]
    graphs = [_draw_moment(view, base, rows[0], moment) for moment in moments]
    if graphs:
        lines.append(side_by_side(graphs, [f"its graph at step {m['step']}" for m in moments]))
    return stacked(lines)


def _choices(rows: Rows) -> Picture:
    """The ghost that is chosen first at one place, for each of two goals."""
    view = _view(rows)
    base = faded(view.base, 0.5)
    plans, titles = [], []
    for row in rows:
        plan = _draw_moment(view, base, row, row["moments"][0])
        view.polyline(plan, row["track"], colours.TRACK, 2)
        _draw_ends(view, plan, row)
        plans.append(plan)
        ended = f"{row['travelled']:.1f} m" if row["success"] else "missed"
        ghost = f"first to ghost {row['chosen']} (best: {row['best']})"
        titles.append(f"goal: {row['what']}; {ghost}; {ended}")
    return side_by_side(plans, titles)


def _draw_moment(view: PlanView, base: Picture, row: Row, moment: Row) -> Picture:
    plan = base.copy()
    view.polyline(plan, moment["path"], colours.PATH, 8)  # wider than the edges on it
    hung = list(zip(moment["hosts"], moment["ghosts"], moment["scores"], strict=True))
    draw_ghost_graph(view, plan, moment["nodes"], moment["edges"], hung, written=True)
    _draw_ends(view, plan, row)
    return plan


def _draw_ends(view: PlanView, plan: Picture, row: Row) -> None:
    view.goal(plan, row["goal"][:2])
    view.arrow(plan, row["pose"])


def _view(rows: Rows) -> PlanView:
    """The part of the plan in which all of the rows happen."""
    points = np.concatenate([[row["goal"][:2], *row["track"]] for row in rows])
    scene = scene_of(rows[0]["world"])
    x0, y0, x1, y1 = scene.plan.bounds
    low = np.maximum(points.min(axis=0) - _BEYOND, [x0, y0])
    high = np.minimum(points.max(axis=0) + _BEYOND, [x1, y1])
    return PlanView(scene, _PLAN, _PLAN, bounds=[*low, *high])


def _look(pose: list[float], world: str) -> Picture:
    """The panorama at a pose."""
    return _SHARP.look(scene_of(world), np.array([pose]))[0][0]
