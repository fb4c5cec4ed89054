"""Where a demo begins and ends, and where people walk meanwhile."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import CLEARANCE, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.viz.canvas.colours import PERSON
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene

ROOMS_AWAY = 3
_SHORTEST, _FAR = 3.0, 10.0  # metres of path: needed, and enough
_STROLL = 2.5  # metres that a person walks to and fro
_ASIDE = 0.45  # metres beside the path
_AT_EASE = 1.0  # metres of the path without people at either end
_TRIES = 20  # pairs of rooms


def choose_places(
    scene: Scene, paths: GridPaths, rng: np.random.Generator
) -> tuple[Array, Array, tuple[str, str], int]:
    """A start pose (3,), a goal (2,), the kinds of their rooms and the doors between them.

    The goal is `ROOMS_AWAY` doors away where the plan has such rooms; on a map without rooms it is
    the place farthest from a random one. Of several pairs the first that is far enough is taken.

    Raises:
        InputError: when no two places are at least 3 m apart.
    """
    plan = scene.plan
    doors = doors_between(plan)
    away = min(ROOMS_AWAY, int(doors[np.isfinite(doors)].max()))
    pairs = np.argwhere(doors == away)
    best, best_length = None, _SHORTEST
    for first, second in pairs[rng.permutation(len(pairs))][:_TRIES]:
        here, there = (nodes_in(plan, paths, room) for room in (first, second))
        if not len(here) or not len(there):
            continue
        goal = paths.points[rng.choice(there)]
        fields = paths.fields(goal)
        start = rng.choice(here) if away else here[fields.cost[0, here].argmax()]
        path = fields.path(paths.points[start])
        pose = _face_along(scene, path)
        if pose is not None and arc_length(path)[-1] >= best_length:
            kinds = (plan.rooms[first].kind, plan.rooms[second].kind)
            best, best_length = (pose, goal, kinds, away), arc_length(path)[-1]
            if best_length >= _FAR:
                break
    if best is None:
        raise InputError(f"demo: {plan.family} has no two places 3 m apart; give a larger map")
    return best


def place_people(path: Array, scene: Scene) -> list[Person]:
    """Two people who walk to and fro beside a path (P, 2), where there is most room."""
    miles = arc_length(path)
    people, middle = [], miles[-1] / 2
    for first, last in ((_AT_EASE, middle), (middle, miles[-1] - _AT_EASE)):
        begins = np.linspace(first, max(first, last - _STROLL), 30)
        stretches = begins[:, None] + np.linspace(0, min(_STROLL, last - first), 12)
        routes = np.stack([np.interp(stretches, miles, path[:, axis]) for axis in (0, 1)], axis=-1)
        along = np.gradient(routes, axis=1)
        left = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        left /= np.linalg.norm(left, axis=-1, keepdims=True)
        routes = np.concatenate([routes + _ASIDE * left, routes - _ASIDE * left])
        roomiest = scene.clearance.at(routes).min(axis=1).argmax()
        people.append(Person(routes[roomiest], speed=0.4, colour=PERSON))
    return people


def doors_between(plan: FloorPlan) -> Array:
    """(R, R) the least number of doors between every two rooms; inf where there is none."""
    count = len(plan.rooms)
    doors = np.where(np.eye(count, dtype=bool), 0.0, np.inf)
    for door in plan.doors:
        first, second = door.rooms
        doors[first, second] = doors[second, first] = 1.0
    for between in range(count):
        doors = np.minimum(doors, doors[:, between, None] + doors[None, between])
    return doors


def nodes_in(plan: FloorPlan, paths: GridPaths, room: int) -> NDArray[np.intp]:
    """Indices of the grid's nodes inside a room, a little off the walls."""
    inside = plan.rooms[room].contains(paths.points)
    return np.flatnonzero(inside & paths.largest & (paths.clearance > CLEARANCE + 0.1))


def _face_along(scene: Scene, path: Array) -> Array | None:
    """A free pose at a path's start that looks along it, as nearly as there is room."""
    ahead = path[min(5, len(path) - 1)] - path[0]
    heading = float(np.arctan2(ahead[1], ahead[0]))
    turns = np.array([0.0, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0, np.pi])
    poses = np.column_stack([np.tile(path[0], (len(turns), 1)), heading + turns])
    free = np.flatnonzero(is_free(scene, BicycleCar(), poses))
    return poses[free[0]] if free.size else None
