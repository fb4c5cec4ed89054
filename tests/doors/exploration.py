"""Doors of exploration: episodes, their task, graphs, local maps and labels."""

from functools import cache

import numpy as np

from tests.doors.arguments import a, choice, flag, flags, floats, integers, number, several, whole
from tests.doors.walk import anything, call, numbers
from tests.doors.world import scene
from tutorial_lib import exploration
from tutorial_lib.exploration import bearings, episodes

WORLD = "apartment/0/standard"
STARTS = np.array([[2.0, 2.0, 0.0], [7.0, 3.0, 1.0]])
GOALS = np.array([[4.0, 4.0, 0.5], [5.0, 6.0, 1.0]])
COUNTS = {"easy": 1, "medium": 1}


def drawn():
    return exploration.Episodes(
        (WORLD, WORLD), STARTS, GOALS, np.array([2.9, 3.6]), ("easy", "medium")
    )


def task():
    return exploration.ExplorationTask({WORLD: scene()}, drawn(), np.random.default_rng(0))


class Stops:
    """Stops at once."""

    def start(self, goals):
        pass

    look_for = start

    def act(self, observations, running):
        return np.zeros(len(running), dtype=int)


def graph():
    found = exploration.GhostGraph(4)
    found.add_node([True, True, False, False], ranges=np.full(8, 5.0))
    found.add_node([True, False, True, False], None, 0, [4.0, 0.0, 0.0], np.full(8, 5.0))
    return found


def maps():
    found = exploration.LocalMaps(2, 4.0)
    found.observe(np.arange(2), np.zeros((2, 3)), np.full((2, 8), 1.0))
    return found


@cache
def labels():
    return exploration.PanoramaLabels(scene(), STARTS)


@cache
def geometry():
    return exploration.TrueGeometry(task())


FEATURES = np.column_stack([[0, 0], STARTS])
GHOST = exploration.Ghost(0, 1)


def robots(values=(0, 1), **more):
    return integers(values, ("M",), least=0, most=1, **more)


def pairs():
    return {
        "sources": integers([0, 1], ("P",), least=0, most=1),
        "goals": integers([1, 0], ("P",), least=0, most=1),
    }


def features():
    return {
        "sources": floats(FEATURES, ("P", 4), either="bool, huge, negative"),
        "goals": floats(FEATURES, ("P", 4), either="bool, huge, negative"),
    }


def node(value=0):
    return whole(value, least=0, most=1)


DOORS = {
    "Episodes": lambda: call(
        exploration.Episodes,
        anything,
        worlds=several([WORLD, WORLD], empty=False),
        starts=floats(STARTS, ("N", 3), empty=False),
        goals=floats(GOALS, ("N", 3), empty=False),
        shortest=floats([2.9, 3.6], ("N",), least=0, infinite=True, refuses="empty"),
        difficulty=several(["easy", ""], empty=False),
    ),
    "Episodes.joined": lambda: call(
        exploration.Episodes.joined, parts=several([drawn(), drawn()], empty=False)
    ),
    "ExplorationTask": lambda: call(
        exploration.ExplorationTask,
        anything,
        scenes=a({WORLD: scene()}),
        episodes=a(drawn()),
        rng=a(np.random.default_rng(0)),
        sensor=choice("rgb"),
        noise=flag(True),
        limit=whole(5, least=1),
        stops_itself=flag(True),
    ),
    "ExplorationTask.carry": lambda: call(
        task().carry,
        poses=floats(GOALS, ("N", 3), refuses="longer N, shorter N, empty"),
    ),
    "ExplorationTask.goals": lambda: call(
        task().goals, anything, robots=integers([0], ("M",), least=0, most=1, optional=True)
    ),
    "ExplorationTask.replace": lambda: call(
        task().replace,
        anything,
        robots=integers([0, 1], ("M",), least=0, most=1, refuses="longer M, shorter M, empty"),
        episodes=a(task().episodes),
        scenes=a(task().scenes),
    ),
    "ExplorationTask.next_goals": lambda: call(
        task().next_goals,
        goals=floats(GOALS, ("N", 3), refuses="longer N, shorter N, empty", either="bool, huge"),
    ),
    "ExplorationTask.step": lambda: call(
        task().step,
        actions=integers([0, 1], ("N",), least=0, most=3, refuses="longer N, shorter N, empty"),
    ),
    "Ghost": lambda: call(
        exploration.Ghost,
        node=whole(0, least=0),
        direction=whole(1, least=0),
        metres=number(3.0, least=0),
    ),
    "GhostGraph": lambda: call(
        exploration.GhostGraph,
        anything,
        directions=whole(12, least=1),
        radius=number(3.0, least=0),
    ),
    "GhostGraph.absorb": lambda: call(
        graph().absorb,
        other=a(graph()),
        node=whole(0, least=0, most=1),
        theirs=whole(1, least=0, most=1),
        pose=floats([4.0, 0.0, 0.0], (3,)),
    ),
    "GhostGraph.add_node": lambda: call(
        graph().add_node,
        explorable=flags([True, False, True, False], ("K",), refuses="longer K, shorter K, empty"),
        free=floats(np.ones(4), ("K",), optional=True),
        previous=whole(1, least=0, most=1),
        pose=floats([4.0, 0.0, 0.0], (3,)),
        ranges=floats(np.ones(8), ("W",), least=0, infinite=True, optional=True),
    ),
    "GhostGraph.connect": lambda: call(
        graph().connect,
        first=whole(0, least=0, most=1),
        second=whole(1, least=0, most=1),
        pose=floats([4.0, 0.0, 0.0], (3,)),
    ),
    "GhostGraph.metres_from": lambda: call(graph().metres_from, node=node()),
    "GhostGraph.path": lambda: call(graph().path, start=node(), end=node(1)),
    "GhostGraph.place_of": lambda: call(graph().place_of, ghost=a(GHOST)),
    "GhostGraph.poses_from": lambda: call(graph().poses_from, node=node()),
    "GhostGraph.remove": lambda: call(graph().remove, ghost=a(GHOST)),
    "LocalMaps": lambda: call(
        exploration.LocalMaps,
        anything,
        robots=whole(2, least=0, most=10**5),
        side=number(4.0, above=0, most=1000),
        reach=number(3.0, least=0),
    ),
    "LocalMaps.forget": lambda: call(maps().forget, robot=whole(0, least=0, most=1)),
    "LocalMaps.cells": lambda: call(
        maps().cells, robots=robots(), points=floats(np.zeros((2, 2)), ("M", 2))
    ),
    "LocalMaps.centres": lambda: call(
        maps().centres, robots=robots(), cells=integers([0, 5], ("M",), least=0, most=1599)
    ),
    "LocalMaps.checked": lambda: call(
        maps().checked, robots=robots(), odometry=floats(np.zeros((2, 3)), ("M", 3))
    ),
    "LocalMaps.close": lambda: call(
        maps().close, robots=robots(), points=floats(np.zeros((2, 2)), ("M", 2))
    ),
    "LocalMaps.observe": lambda: call(
        maps().observe,
        robots=robots(),
        odometry=floats(np.zeros((2, 3)), ("M", 3)),
        ranges=floats(np.ones((2, 8)), ("M", "W"), infinite=True),
    ),
    "PanoramaLabels": lambda: call(
        exploration.PanoramaLabels,
        anything,
        scene=a(scene()),
        poses=floats(STARTS, (..., 3), either="fewer axes, more axes"),
        ranges=floats(
            np.ones((2, 192)),
            ("N", "W"),
            least=0,
            infinite=True,
            optional=True,
            refuses="longer N, shorter N, empty",
        ),
        directions=whole(12, least=1, most=10**4),
        radius=number(3.0, above=0, most=100),
    ),
    "PanoramaLabels.connected": lambda: call(labels().connected, **pairs()),
    "PanoramaLabels.metres": lambda: call(labels().metres, numbers, **pairs()),
    "PanoramaLabels.relative": lambda: call(labels().relative, **pairs()),
    "PanoramaLabels.scores": lambda: call(labels().scores, **pairs()),
    "TrueGeometry": lambda: call(
        exploration.TrueGeometry,
        anything,
        task=a(task()),
        directions=whole(12, least=1),
        radius=number(3.0, above=0, most=50),
    ),
    "TrueGeometry.embed": lambda: call(
        geometry().embed, observations=a(geometry()._task.observe())
    ),
    "TrueGeometry.explorable": lambda: call(geometry().explorable, features=features()["sources"]),
    "TrueGeometry.ranges": lambda: call(
        geometry().ranges, observations=a(geometry()._task.observe())
    ),
    "TrueGeometry.relative": lambda: call(geometry().relative, **features()),
    "TrueGeometry.same_node": lambda: call(geometry().same_node, **features()),
    "TrueGeometry.scores": lambda: call(geometry().scores, anything, **features()),
    "draw_episodes": lambda: call(
        exploration.draw_episodes,
        anything,
        world=a(WORLD, takes="text"),
        scene=a(scene()),
        counts=a(COUNTS),
        rng=a(np.random.default_rng(0)),
    ),
    "draw_sequence": lambda: call(
        episodes.draw_sequence,
        scene=a(scene()),
        goals=floats(GOALS, ("N", 3), empty=False, either="huge, bool, negative"),
        count=whole(2, least=1, most=10**6),
        rng=a(np.random.default_rng(0)),
        metres=floats([1.5, 5.0], (2,), least=0, either="huge, bool"),
    ),
    "exploration_world": lambda: call(
        exploration.exploration_world,
        seed=whole(3, least=0),
        signs=choice("plain"),
        palette=choice("standard"),
    ),
    "explore": lambda: call(exploration.explore, task=a(task()), agent=a(Stops())),
    "explore_on": lambda: call(
        lambda **given: list(exploration.explore_on(**given)),
        task=a(task()),
        agent=a(Stops()),
        goals=floats(
            GOALS[None], ("K", "N", 3), refuses="longer N, shorter N", either="huge, bool"
        ),
    ),
    # What is public in its module.
    "bin_of": lambda: call(
        bearings.bin_of, bearings=floats([0.5, 1.0]), directions=whole(12, least=1)
    ),
    "bearing_of": lambda: call(
        bearings.bearing_of, bins=integers([0, 3], (...,)), directions=whole(12, least=1)
    ),
    "column_bearings": lambda: call(
        bearings.column_bearings, columns=whole(8, least=1, most=10**6)
    ),
    "column_of": lambda: call(
        bearings.column_of, bearings=floats([0.5, 1.0]), columns=whole(8, least=1)
    ),
}
WITHOUT = {
    "Destination": "holds what an agent has chosen; nothing to refuse",
    "ghost_places": "of an agent's own memory, whose graph has checked its ghosts",
}
