"""Doors of drawing: on the plan, as figures and films, and in notebooks."""

from functools import cache

import networkx as nx
import numpy as np

from tests.conftest import make_box
from tests.doors.arguments import (
    a,
    choice,
    flag,
    flags,
    floats,
    function,
    images,
    integers,
    number,
    several,
    text,
    tuples,
    whole,
)
from tests.doors.driving import recorded
from tests.doors.topology import PLACES, topomap
from tests.doors.walk import anything, call
from tutorial_lib import viz
from tutorial_lib.interfaces import Plan
from tutorial_lib.viz.canvas.ghost_graphs import draw_ghost_graph
from tutorial_lib.viz.canvas.labels import draw_badge
from tutorial_lib.viz.figures import directions
from tutorial_lib.world import Camera, Scene

POSES = np.array([[1.0, 1.0, 0.5], [2.0, 2.0, -0.5], [3.0, 2.5, 0.0]])
POINTS = POSES[:, :2]
SIZE = {"least": 0, "most": 16_384}
GRAPH = {"here": {"A": 0.9}, "A": {"goal": 0.8}, "goal": {}}
ROW = {"method": "meng", "context": 5, "sparsity": 0.1, "stored": 0.2, "threshold": 0.9}
ROW |= {"cover_rate": 0.9, "low": 0.8, "high": 0.95}


class Pressed:
    """What `presses` wants."""

    actions, text = ("on", "off"), "it is off"

    def press(self, name):
        self.text = f"it is {name}"

    def render(self):
        return np.zeros((8, 9, 3), np.uint8)


@cache
def scene():
    return Scene(make_box(6.0, 5.0))


@cache
def plan_view():
    return viz.PlanView(scene(), 120, 100, 8)


def view():
    return a(plan_view())


def picture(height=100, width=120, axes=("H", "W"), **changes):
    return images(np.zeros((height, width, 3)), (*axes, 3), refuses="empty", **changes)


def colour(**changes):
    return tuples(integers((10, 20, 30), (3,), least=0, most=255, **changes))


def points(values=POINTS, shape=("P", 2), refuses="huge", **more):
    return floats(values, shape, refuses=f"{refuses}, huge", **more)


def pose(**more):
    return points(POSES[0], (3,), **more)


def poses(axis="T", **more):
    return points(POSES, (axis, 3), **more)


def line():
    return number(2.0, **SIZE)


def side(value, least=1):
    return whole(value, least=least, most=16_384)


def on(function, *, seen=True, **arguments):
    """A call that draws on a picture, and gives what is on it then."""

    def run(picture, **rest):
        function(picture=picture, **rest)
        return picture

    return call(run, picture=picture(), **({"view": view()} if seen else {}), **arguments)


def by_view(method, **arguments):
    """A call of a method of a view, which draws on a picture."""
    return on(getattr(plan_view(), method), seen=False, **arguments)


def press():
    return viz.TeleopController(scene(), POSES[1], steps=1)


def axis():
    return viz.chart(2.0, 2.0)[1][0]


def shown(value):
    """Whether the output of a cell can be shown."""
    return bool(repr(value))


def render(push):
    return np.zeros((8, 8, 3), np.uint8), f"{push}"


CANVAS = {
    "PlanView": lambda: call(
        viz.PlanView,
        anything,
        scene=a(scene()),
        width=side(120),
        height=side(100),
        margin=whole(8, least=0),
        bounds=points((0.0, 0.0, 4.0, 3.0), (4,), optional=True, either="negative"),
    ),
    "PlanView.pixels": lambda: call(plan_view().pixels, points=points(shape=(..., 2))),
    "PlanView.polyline": lambda: by_view(
        "polyline", points=points(), colour=colour(), width=line()
    ),
    "PlanView.polygon": lambda: by_view(
        "polygon",
        points=points(empty=False),
        colour=colour(),
        opacity=number(0.5, least=0, most=1),
    ),
    "PlanView.disc": lambda: by_view(
        "disc", centre=points(POINTS[0], (2,)), radius=number(0.3, least=0), colour=colour()
    ),
    "PlanView.ring": lambda: by_view(
        "ring", centre=points(POINTS[0], (2,)), radius=number(0.3, least=0), colour=colour()
    ),
    "PlanView.points": lambda: by_view(
        "points", points=points(shape=(..., 2)), colour=colour(), radius=line()
    ),
    "PlanView.robot": lambda: by_view("robot", pose=pose(), footprint=points(empty=False)),
    "PlanView.arrow": lambda: by_view("arrow", pose=pose(), colour=colour(), size=line()),
    "PlanView.goal": lambda: by_view("goal", point=points(POINTS[0], (2,))),
    "PlanView.seen": lambda: by_view("seen", pose=pose(), ends=points(shape=(..., 2))),
    "PlanView.rays": lambda: by_view(
        "rays", pose=pose(), ends=points(shape=(..., 2)), colour=colour()
    ),
    "draw_anchors": lambda: on(
        viz.draw_anchors,
        poses=poses("A"),
        size=line(),
        colour=colour(),
    ),
    "draw_arrows": lambda: on(
        viz.draw_arrows,
        points=points(takes="more axes"),
        vectors=points(takes="more axes"),
    ),
    "draw_cells": lambda: on(
        viz.draw_cells,
        places=points(shape=("P", 2), takes="longer axis 1"),
        probability=floats([0.1, 0.5, 0.9], ("P",), least=0, most=1),
        size=number(0.5, least=0, most=1e5),
        opacity=number(0.8, least=0, most=1),
    ),
    "draw_edges": lambda: on(
        viz.draw_edges,
        poses=poses("V", refuses="shorter V, empty"),
        edges=integers([(0, 1), (1, 2)], ("E", 2), least=0, most=2),
        colour=colour(),
        width=line(),
        heads=flag(True),
    ),
    "draw_living_map": lambda: on(
        viz.draw_living_map,
        poses=poses("V", refuses="shorter V, empty"),
        graph=a(nx.DiGraph([(0, 1, {"probability": 0.9})])),
        pruned=integers([(1, 2)], ("E", 2), least=0, most=2),
    ),
    "draw_field_of_view": lambda: on(
        viz.draw_field_of_view,
        scene=a(scene()),
        pose=pose(either="negative"),
        camera=a(Camera(), optional=True),
        discs=a(None, optional=True),
    ),
    "draw_ghost_graph": lambda: on(
        draw_ghost_graph,
        nodes=points(shape=("V", 2), takes="longer axis 1", refuses="shorter V, empty"),
        edges=integers([(0, 1), (1, 2)], ("E", 2), least=0, most=2),
        ghosts=several([(0, (1.5, 1.0), 0.5), (1, (2.5, 1.0), 0.7)]),
        chosen=points(POINTS[0], (2,), optional=True),
        written=flag(True),
    ),
    "draw_metrics": lambda: on(
        viz.draw_metrics,
        points=points(takes="more axes"),
        metrics=floats(np.stack([np.eye(2)] * 3), ("P", 2, 2), takes="more axes"),
    ),
    "draw_badge": lambda: on(
        draw_badge,
        seen=False,
        text=text("12"),
        pixel=floats([20.0, 20.0], (2,), least=-16_384, most=16_384),
        size=number(0.5, least=0, most=100),
        colour=colour(),
    ),
    "draw_outcome": lambda: on(viz.draw_outcome, place=points(POINTS[0], (2,)), reached=flag(True)),
    "draw_plan": lambda: on(
        viz.draw_plan,
        poses=poses("V", refuses="shorter V, empty"),
        vertices=integers([0, 2], ("P",), least=0, most=2),
        here=pose(optional=True),
        goal=pose(optional=True),
        colour=colour(),
    ),
    "draw_states": lambda: on(
        viz.draw_states,
        poses=poses(),
        states=integers([0, 1, 1], ("T",), least=0, most=4),
        width=line(),
    ),
    "draw_topomap": lambda: on(
        viz.draw_topomap,
        topomap=a(topomap()),
        poses=points(PLACES, (5, 3)),
    ),
    "hue": lambda: call(viz.hue, number=whole(3, refuses="huge")),
    "label": lambda: on(
        viz.label,
        seen=False,
        text=text("words"),
        x=whole(3),
        y=whole(20),
        size=number(0.6, least=0, most=100),
        colour=colour(),
    ),
    "write_beside": lambda: on(
        viz.write_beside, text=text("12"), pose=pose(), off=number(18.0, least=-16_384, most=16_384)
    ),
}
FIGURES = {
    "aligned_sequences": lambda: call(
        viz.aligned_sequences,
        row=several(["a", "b"], refuses="empty"),
        column=several(["c", "d"], refuses="empty"),
        pairs=floats([0.9, 0.5], (2,)),
        framed=whole(1, least=0, most=1, optional=True),
    ),
    "along_trajectory": lambda: call(
        viz.along_trajectory,
        metres=floats([0.0, 1.0, 2.0], ("T",), empty=False),
        probability=floats([0.9, 0.5, 0.1], ("T",), least=0, most=1),
        now=whole(1, least=0, most=2),
        reached=flag(True, optional=True),
    ),
    "camera_picture": lambda: call(
        viz.camera_picture, image=picture(8, 24), width=side(48, 2), smooth=flag(True)
    ),
    "chart": lambda: call(
        viz.chart,
        anything,
        width=number(2.0, above=0, most=100),
        height=number(2.0, above=0, most=100),
        columns=whole(1, least=1, most=100),
    ),
    "closeup": lambda: call(
        viz.closeup,
        view=view(),
        picture=picture(),
        points=floats(POINTS, (..., 2), empty=False, refuses="huge"),
        margin=number(0.8, least=0, refuses="huge"),
        square=flag(True),
    ),
    "cover_chart": lambda: call(
        viz.cover_chart,
        rows=several([ROW, ROW], empty=False),
        against=choice("sparsity"),
        width=number(4.0, above=0, most=100),
    ),
    "draw_reliability": lambda: call(
        viz.draw_reliability,
        axis=a(axis()),
        predicted=floats([0.1, 0.9], ("B",), least=0, most=1, nan=True),
        measured=floats([0.2, 0.8], ("B",), least=0, most=1, nan=True),
        count=floats([5.0, 9.0], ("B",), least=0, optional=True, takes="no axes, fewer axes"),
    ),
    "drive_picture": lambda: call(
        viz.drive_picture,
        recorded=a(recorded()),
        topomap=a(topomap()),
        plan=a(Plan((0, 1, 2))),
        track=poses(empty=False),
        goal=pose(),
    ),
    "edge_table": lambda: call(
        viz.edge_table,
        values=floats(np.eye(3), ("R", "C"), nan=True, infinite=True),
        chosen=flags(np.eye(3), ("R", "C")),
        rings=flags(np.eye(3), ("R", "C"), optional=True),
        names=several(("from", "to"), empty=False),
        blank=flag(False),
    ),
    "faded": lambda: call(viz.faded, picture=picture(), share=number(0.5, least=0, most=1)),
    "film_strip": lambda: call(
        viz.film_strip,
        frames=several([np.zeros((8, 9, 3), np.uint8)] * 2, empty=False),
        times=floats([0.0, 1.0], (2,), optional=True),
        count=whole(4, least=1),
    ),
    "follower_machine": lambda: call(viz.follower_machine),
    "follower_strip": lambda: call(
        viz.follower_strip,
        view=view(),
        base=picture(),
        poses=poses(refuses="shorter T, empty"),
        states=integers([0, 1, 1], ("T",), least=0, most=4),
        steps=integers([0, 2], ("S",), least=0, most=2, empty=False),
        footprint=points(POINTS / 10, empty=False),
        reach=number(1.6, above=0, refuses="huge"),
        side=side(60, 12),
        discs=a({0: np.array([[1.0, 1.0, 0.2]])}, optional=True),
    ),
    "frames_kept": lambda: call(
        viz.frames_kept,
        total=whole(9, least=1, refuses="huge"),
        kept=integers([0, 3], ("K",), least=0, most=8),
        anchors=integers([3], ("A",), least=0, most=8),
    ),
    "from_figure": lambda: call(viz.from_figure, figure=a(viz.chart(2.0, 2.0)[0])),
    "graph_picture": lambda: call(
        viz.graph_picture,
        graph=a(GRAPH),
        path=several(["here", "A"]),
    ),
    "map_picture": lambda: call(
        directions.map_picture,
        free=flags(np.eye(9), ("S", "S"), refuses="longer S, shorter S, empty"),
        chosen=flags([True, False, True], ("K",)),
        reach=number(3.0, least=0, most=9),
    ),
    "map_view": lambda: call(
        viz.map_view,
        anything,
        scene=a(scene()),
        topomap=a(topomap()),
        poses=points(PLACES, (5, 3)),
        bounds=points((0.0, 0.0, 4.0, 3.0), (4,), optional=True, either="negative"),
    ),
    "matches_picture": lambda: call(
        viz.matches_picture,
        current=picture(8, 24),
        target=picture(8, 24, ("h", "w")),
        shares=floats(np.eye(4), ("R", "C"), empty=False),
        truth=floats([[0.1, 0.2], [0.3, 0.4]], ("T", 2), least=0, most=1),
        side=side(60, 2),
    ),
    "numbered_views": lambda: call(
        viz.numbered_views,
        view=view(),
        picture=picture(),
        poses=poses("P", empty=False),
        images=images(np.zeros((3, 8, 24, 3)), ("P", "h", "w", 3)),
        width=side(48, 2),
        columns=whole(2, least=1),
        margin=number(0.8, least=0, refuses="huge"),
        points=points(shape=("Q", 2), optional=True),
    ),
    "panorama_picture": lambda: call(
        directions.panorama_picture, image=picture(8, 24), width=side(48), height=side(12)
    ),
    "pictured_pair": lambda: call(
        viz.pictured_pair,
        now=picture(8, 24),
        target=picture(8, 24, ("h", "w")),
        width=side(48, 2),
    ),
    "probability_bar": lambda: call(viz.probability_bar, low=text("no"), high=text("yes")),
    "reach_table": lambda: call(
        viz.reach_table,
        reach=floats(np.eye(4), (4, 4)),
        threshold=number(0.5),
        anchors=integers([0, 2], ("A",), least=0, most=3),
    ),
    "scored_panorama": lambda: call(
        directions.scored_panorama,
        image=picture(8, 24),
        scores=floats([0.1, 0.9, 0.5], ("K",), empty=False),
        explorable=flags([True, False, True], ("K",), optional=True),
        chosen=whole(1, least=0, most=2, optional=True),
        truth=floats([0.2, 0.8, 0.5], ("K",), optional=True),
        width=side(120, 40),
    ),
    "state_legend": lambda: call(viz.state_legend, width=side(900)),
    "state_ribbon": lambda: call(
        viz.state_ribbon,
        states=integers([0, 1, 1], ("T",), least=0, most=4),
        width=side(120, 40),
        longest=whole(9, least=0, optional=True, refuses="huge"),
    ),
    **{
        name: lambda name=name, across=across: call(
            getattr(viz, name),
            pictures=several([np.zeros((8, 9, 3), np.uint8)] * 2, empty=False),
            titles=several(["one", "two"]),
            gap=whole(8, least=0, most=16_384),
            **{across: whole(20, least=1, most=16_384, optional=True)},
        )
        for name, across in (("side_by_side", "height"), ("stacked", "width"))
    },
}
NOTEBOOK = {
    "TeleopController": lambda: call(
        viz.TeleopController,
        anything,
        scene=a(scene()),
        pose=floats(POSES[1], (3,), refuses="huge, negative"),
        people=(),
        steps=whole(5, least=1),
    ),
    "TeleopController.press": lambda: call(press().press, name=choice("left")),
    "TeleopController.rehearse": lambda: call(
        press().rehearse, presses=several(["left", "stop"]), count=whole(2, least=1, most=100)
    ),
    "TeleopController.render": lambda: call(press().render, hide_map=flag(True)),
    "play": lambda: call(
        viz.play,
        anything,
        frames=several([np.zeros((8, 64, 3), np.uint8)] * 2, empty=False),
        frames_per_second=number(5.0, above=0, most=1000),
        times=floats([0.0, 1.0], (2,), optional=True),
        count=whole(4, least=1),
        alt=text("a film"),
        strip=several([np.zeros((8, 8, 3), np.uint8)] * 2, empty=False, optional=True),
    ),
    "presses": lambda: call(viz.presses, anything, controller=a(Pressed())),
    "show": lambda: call(viz.show, shown, picture=picture(8, 9), alt=text("a picture")),
    "sliders": lambda: call(
        viz.sliders,
        anything,
        render=function(render),
        labels=a({"push": "push, m/s²"}, optional=True),
        push=floats((0.0, 1.0, 0.1, 0.5), (4,), refuses="huge", either="bool, negative"),
    ),
    "table": lambda: call(
        viz.table,
        shown,
        columns=a({"planner": "", "success": ".0%"}),
        rows=several([["ours", 0.9], ["theirs", None]]),
        best=a({"success": max}, optional=True),
        caption=text("success"),
    ),
    "teleop": lambda: call(
        viz.teleop, anything, controller=a(press()), rehearsal=several(["left", "stop"])
    ),
}
DOORS = CANVAS | FIGURES | NOTEBOOK
PARTS = "holds what a film is drawn from, without a look at it"
WITHOUT = {"Moment": PARTS, "RolloutFilm": PARTS}
