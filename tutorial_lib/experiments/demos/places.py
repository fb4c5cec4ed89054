"""Rooms and doors of a demo's plan, and where people walk meanwhile."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import CLEARANCE, GridPaths
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.viz.canvas.colours import PERSON
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene

ROOMS_AWAY = 3
_STROLL = 2.5  # metres that a person walks to and fro
_ASIDE = 0.45  # metres beside the path
_AT_EASE = 1.0  # metres of the path without people at either end


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
