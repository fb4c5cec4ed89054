"""The free space of a floor plan as a grid, with the clearance of every cell."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_PIXELS, MAX_ROOM_CELLS
from tutorial_lib.validation import floats, images, instance, integers, number
from tutorial_lib.world.floorplan import FloorPlan, Room

_SHIFT = 6  # OpenCV draws with coordinates in 1/64 of a cell


@dataclass(frozen=True)
class ClearanceGrid:
    """How far each cell's centre is from the nearest wall or furniture.

    Attributes:
        clearance: (H, W) float32 metres, 0 wherever no room is; row 0 is the lowest y.
        origin: (x, y) of the grid's lower left corner, in metres.
        resolution: metres per cell.
    """

    clearance: NDArray[np.float32]
    origin: tuple[float, float]
    resolution: float

    def __post_init__(self) -> None:
        floats("clearance", self.clearance, ("H", "W"))
        floats("origin", self.origin, (2,))
        number("resolution", self.resolution, above=0)

    def cells(self, points: ArrayLike) -> NDArray[np.intp]:
        """Row and column (..., 2) of the cell with each point (..., 2), clipped to the grid."""
        points = floats("points", points, (..., 2))
        cells = np.floor((points[..., ::-1] - self.origin[::-1]) / self.resolution).astype(np.intp)
        return np.clip(cells, 0, np.array(self.clearance.shape) - 1)

    def centres(self, cells: ArrayLike) -> NDArray[np.float64]:
        """The points (..., 2) in the middle of cells given as row and column (..., 2)."""
        cells = integers("cells", cells, (..., 2))
        return (cells[..., ::-1] + np.float64(0.5)) * self.resolution + np.asarray(self.origin)

    def at(self, points: ArrayLike) -> NDArray[np.float32]:
        """Clearance (...) in metres of the cell that holds each point (..., 2)."""
        cells = self.cells(points)
        return self.clearance[cells[..., 0], cells[..., 1]]


def clearance_grid(plan: FloorPlan, resolution: float = 0.05) -> ClearanceGrid:
    """Rasterise a plan: what is connected to the inside of a room is free, all else is not.

    Args:
        plan: the floor plan.
        resolution: metres per cell.

    Returns:
        The grid, one cell wider than the plan on every side; clearances are accurate to
        about half a cell.
    """
    origin, free = _draw_segments(instance("plan", plan, FloorPlan), resolution)
    for piece in plan.furniture:
        cv2.fillPoly(free, [_to_cells(piece.outline, origin, resolution)], 0, shift=_SHIFT)
    _, labels = cv2.connectedComponents(free, connectivity=4)
    inside = np.zeros(labels.max() + 1, dtype=bool)
    for box, within in _room_masks(plan.rooms, origin, resolution, free.shape):
        rim = within & (cv2.erode(within.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
        # The inside of a block in the middle of a room does not reach the rim.
        inside[np.unique(labels[box][rim & (free[box] > 0)])] = True
    inside[0] = False
    open_cells = (inside[labels] & (free > 0)).astype(np.uint8)
    # The line through a blocked cell runs, on average, through its middle.
    distance = cells_to_blocked(open_cells)
    return ClearanceGrid(distance * np.float32(resolution), origin, resolution)


def cells_to_blocked(open_cells: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(H, W) distance, in cells, from each cell to the nearest cell that is 0.

    OpenCV's rounding depends on its number of threads. Squared distances are whole numbers, so
    rounding them gives the same bytes everywhere.
    """
    images("open_cells", open_cells, ("H", "W"), empty=False)
    distance = cv2.distanceTransform(open_cells, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    squared = np.square(distance, dtype=np.float64)
    np.rint(squared, out=squared)
    return np.sqrt(squared, out=squared).astype(np.float32)


def check_closed(plan: FloorPlan, resolution: float = 0.05) -> None:
    """Check that no room is open to the outside.

    Raises:
        InputError: naming the room, and the loose wall end nearest to it where there is one; or
            when the rooms overlap so often that they have more than `MAX_ROOM_CELLS`.
    """
    origin, free = _draw_segments(instance("plan", plan, FloorPlan), resolution)
    _, labels = cv2.connectedComponents(free, connectivity=4)
    outside = labels[0, 0]
    masks = _room_masks(plan.rooms, origin, resolution, free.shape)
    for i, (room, (box, within)) in enumerate(zip(plan.rooms, masks, strict=True)):
        if (labels[box][within] == outside).any():
            raise InputError(
                f"rooms[{i}] ({room.kind}): is not closed, the outside can be reached from it"
                f"{_loose_end(plan, room)}; make the walls meet"
            )


def _draw_segments(
    plan: FloorPlan, resolution: float
) -> tuple[tuple[float, float], NDArray[np.uint8]]:
    """The grid's origin, and an (H, W) mask that is 0 where a segment runs and 1 elsewhere."""
    x0, y0, x1, y1 = plan.bounds
    resolution = number("resolution", resolution, above=0)
    cells = (x1 - x0) / resolution * (y1 - y0) / resolution
    if cells > MAX_PIXELS or resolution > max(x1 - x0, y1 - y0):
        raise InputError(f"resolution: {resolution}; give metres per cell that suit the plan")
    origin = (x0 - 2 * resolution, y0 - 2 * resolution)
    width = int(np.ceil((x1 - origin[0]) / resolution)) + 2
    height = int(np.ceil((y1 - origin[1]) / resolution)) + 2
    free = np.ones((height, width), np.uint8)
    ends = _to_cells(plan.segments.reshape(-1, 2), origin, resolution).reshape(-1, 2, 2)
    cv2.polylines(free, list(ends), isClosed=False, color=0, shift=_SHIFT)
    return origin, free


def _room_masks(
    rooms: Sequence[Room], origin: tuple[float, float], resolution: float, shape: tuple[int, ...]
) -> Iterator[tuple[tuple[slice, slice], NDArray[np.bool_]]]:
    """For each room a box of the grid's cells, and (h, w) which of these are well inside of it.

    They lie a cell and a half from its outline.

    Raises:
        InputError: when the boxes have more than `MAX_ROOM_CELLS` together.
    """
    total = 0
    for room in rooms:
        outline = _to_cells(room.outline, origin, resolution)
        first = np.clip((outline.min(axis=0) >> _SHIFT) - 3, 0, shape[::-1])
        last = np.clip((outline.max(axis=0) >> _SHIFT) + 4, 0, shape[::-1])
        total += int(np.prod(last - first, dtype=np.int64))
        if total > MAX_ROOM_CELLS:
            raise InputError("rooms: they overlap again and again; give each its own outline")
        mask = np.zeros((last - first)[::-1], np.uint8)
        cv2.fillPoly(mask, [outline - (first << _SHIFT)], 1, shift=_SHIFT)
        box = slice(first[1], last[1]), slice(first[0], last[0])
        yield box, cv2.erode(mask, np.ones((3, 3), np.uint8), iterations=2) > 0


def _to_cells(
    points: ArrayLike, origin: tuple[float, float], resolution: float
) -> NDArray[np.int32]:
    """Points in metres as OpenCV's fixed-point columns and rows; a cell's centre is whole."""
    cells = (np.asarray(points, dtype=float) - origin) / resolution - 0.5
    return np.round(cells * 2**_SHIFT).astype(np.int32)


def _loose_end(plan: FloorPlan, room: Room) -> str:
    """The loose wall end nearest to the room, as text; empty when every end meets another."""
    ends = plan.segments.reshape(-1, 2)
    gap, _ = KDTree(ends).query(ends, k=2)
    loose = ends[gap[:, 1] > 0.02]
    if not len(loose):
        return ""
    distance = np.linalg.norm(loose - np.mean(room.outline, axis=0), axis=1)
    x, y = loose[distance.argmin()]
    return f", perhaps at the loose wall end ({x:.2f}, {y:.2f})"
