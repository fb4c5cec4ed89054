"""Removes the furniture that keeps the car from getting everywhere."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.world.floorplan import FloorPlan, Furniture, Room
from tutorial_lib.world.generators.rectilinear import DoesNotFit
from tutorial_lib.world.occupancy import ClearanceGrid, clearance_grid

CAR = 0.25
"""Metres from the car's middle to anything else that it needs."""
CRUMB = 0.02
"""Square metres: smaller patches are the raster's, not the world's."""
ROOM_SHARE = 1.0
"""Square metres in every room that the car can be in."""
RESOLUTION = 0.05

_Cells = NDArray[Any]
"""The patch of each cell, or how many each patch has; patch 0 is all that is not free."""


def open_up(plan: FloorPlan, twins: list[int]) -> FloorPlan:
    """Remove furniture until the car can get from anywhere to anywhere.

    Args:
        plan: with all its furniture.
        twins: for each piece its group; a group is removed as one.

    Raises:
        DoesNotFit: if the bare walls keep the car out of somewhere.
    """
    while True:
        grid = clearance_grid(plan, RESOLUTION)
        free = (grid.clearance >= CAR).view(np.uint8)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(free)
        patches = grid, labels, stats[:, cv2.CC_STAT_AREA]
        blocking = _cut_off(plan, *patches) or _cramped(plan, *patches)
        if not blocking:
            return plan
        groups = {twins[i] for i in blocking}
        stay = [i for i, group in enumerate(twins) if group not in groups]
        twins = [twins[i] for i in stay]
        plan = replace(plan, furniture=tuple(plan.furniture[i] for i in stay))


def _cut_off(plan: FloorPlan, grid: ClearanceGrid, labels: _Cells, cells: _Cells) -> set[int]:
    """The piece nearest to each patch of floor that is cut off from the largest."""
    order = 1 + np.argsort(cells[1:], kind="stable")
    patches = [i for i in order[:-1] if cells[i] * RESOLUTION**2 >= CRUMB]
    return {_nearest_piece(plan, grid.centres(np.argwhere(labels == i))) for i in patches}


def _nearest_piece(plan: FloorPlan, points: NDArray[np.float64]) -> int:
    """The index of the piece of furniture that is nearest to any of the points (N, 2)."""
    if not plan.furniture:
        raise DoesNotFit("walls that cut off a part of the floor")
    corners = [len(piece.outline) for piece in plan.furniture]
    sides = plan.segments[len(plan.walls) :]
    points = points[:: 1 + len(points) // 50]  # a large patch has enough of them
    nearest = distance_to_segments(points, sides).min(axis=0).argmin()
    return int(np.searchsorted(np.cumsum(corners), nearest, side="right"))


def _cramped(plan: FloorPlan, grid: ClearanceGrid, labels: _Cells, cells: _Cells) -> set[int]:
    """The largest piece in each room that leaves too little floor to the car."""
    floor = grid.centres(np.argwhere(labels == 1 + cells[1:].argmax()))
    pieces = set()
    for room in plan.rooms:
        if _inside(room, floor).sum() * RESOLUTION**2 >= ROOM_SHARE:
            continue
        middles = np.array([np.mean(piece.outline, axis=0) for piece in plan.furniture])
        here = np.flatnonzero(_inside(room, middles.reshape(-1, 2)))
        if not here.size:
            raise DoesNotFit(f"a {room.kind} too small for the car")
        pieces.add(int(max(here, key=lambda i: _floor_taken(plan.furniture[i]))))
    return pieces


def _inside(room: Room, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) whether each point (N, 2) is in a room, by the sides that lie above it."""
    start = np.asarray(room.outline)
    end = np.roll(start, -1, axis=0)
    flat = start[:, 1] == end[:, 1]
    low, high = (f(start[flat, 0], end[flat, 0]) for f in (np.minimum, np.maximum))
    inside = ((points > start.min(axis=0)) & (points < start.max(axis=0))).all(axis=1)
    x, y = points[inside, :1], points[inside, 1:]
    inside[inside] = ((low <= x) & (x < high) & (start[flat, 1] > y)).sum(axis=1) % 2 == 1
    return inside


def _floor_taken(piece: Furniture) -> float:
    """Square metres."""
    return Room("open", piece.outline).area
