"""People who stand in the way, and the paths around them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.geometry import Array
from tutorial_lib.world.floorplan import Door
from tutorial_lib.world.people import Person

APART = 0.34
"""Metres between people who stand in a row; no car fits through."""
BODY = 0.12
"""Metres, half the width of a car."""


def paths_around(building: Building, places: Array) -> GridPaths:
    """A building's geodesics where people stand at places (P, 2)."""
    clearance = building.scene.clearance
    cells = np.indices(clearance.clearance.shape).reshape(2, -1).T
    gap = np.linalg.norm(clearance.centres(cells)[:, None] - places, axis=-1).min(axis=1)
    gap = np.maximum(gap - Person.radius, 0.0).reshape(clearance.clearance.shape)
    left = np.minimum(clearance.clearance, gap).astype(np.float32)
    return GridPaths(replace(clearance, clearance=left))


def across_door(door: Door) -> list[Person]:
    """People who close a door."""
    count = max(int(np.ceil(door.width / APART)), 1) + 1
    return [Person(place[None], speed=0.0) for place in np.linspace(door.start, door.end, count)]
