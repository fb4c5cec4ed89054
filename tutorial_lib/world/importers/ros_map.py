"""Maps as ROS saves them: a YAML file beside an image of the occupancy grid."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_yaml
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.validation import path_of
from tutorial_lib.world.fields import Field
from tutorial_lib.world.floorplan import FloorPlan, Room, too_far
from tutorial_lib.world.importers.contours import free_loops, signed_area
from tutorial_lib.world.importers.map_cells import free_cells, number_of
from tutorial_lib.world.importers.regions import Region, checked_region, part_at, within_box
from tutorial_lib.world.importers.surfaces import check_choice, dress_loops, imported_look
from tutorial_lib.world.occupancy import cells_to_blocked

MIN_AREA = 1.0
"""Square metres that the car must be able to cover in a free region, or it is left out."""
_CAR_RADIUS = 0.15  # metres; half the car's width and a little room


def import_ros_map(
    path: str | Path, seed: int = 0, palette: str = "standard", region: Region | None = None
) -> FloorPlan:
    """Read a ROS map as a floor plan of its free space.

    Whatever is not known to be free, occupied or unknown, gets walls around it, along the edges of
    the grid's cells and simplified within half a cell. Regions too small for the car are left out.

    Args:
        path: the YAML file; its image is found relative to it, or beside it: then a
            `errors.Notice` says so.
        seed: of the colours, which a map does not have.
        palette: "standard" or "shifted".
        region: of the map to read; all of it unless given. Either x0, y0, x1, y1 of a box, or x, y
            of a point in the free part that is meant; metres in the map's frame.

    Returns:
        A plan in metres in the map's frame, with a room of kind "open" for each free region.

    Raises:
        InputError: naming the file and field, when anything is missing, malformed or makes no
            sense, when no free region is large enough for the car, or all of them are too large.
    """
    check_choice(seed, palette)
    region = None if region is None else checked_region(region)
    path = path_of("path", path)
    content = read_yaml(path, "give a map's YAML file, or correct it")
    root = Field(content, path.name)
    resolution = number_of(root["resolution"])
    if resolution <= 0:
        raise root["resolution"].fail("give metres a cell, above 0")
    pose = _origin(root["origin"])
    free = _chosen(free_cells(root, path.parent), resolution, pose, region, root.where)
    _check_extent(free, resolution, pose, root.where)
    rng = np.random.default_rng(seed)
    try:
        return plan_of_cells(free, resolution, pose, ("ros", int(seed)), rng, palette)
    except InputError as error:
        raise InputError(f"{root.where}: image: {error}") from error


def _chosen(
    free: NDArray[np.bool_],
    resolution: float,
    pose: Array,
    region: Region | None,
    where: str,
) -> NDArray[np.bool_]:
    """The free cells of a region that the car can make use of."""
    if region is not None and len(region) == 4:
        free = within_box(free, resolution, pose, region)
    free = large_regions(free, resolution)
    if not free.any():
        also = "resolution" if region is None else "resolution, and the region"
        raise InputError(
            f"{where}: image: no free region lets the car cover {MIN_AREA:g} m²; check negate, "
            f"mode, free_thresh and {also}"
        )
    if region is None or len(region) == 4:
        return free
    try:
        return part_at(free, resolution, pose, region)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _check_extent(free: NDArray[np.bool_], resolution: float, pose: Array, where: str) -> None:
    """Check that a plan may be as large and as far away as the free cells are.

    Raises:
        InputError: naming the picture, and its pixels.
    """
    rows = np.flatnonzero(free.any(axis=1))
    first = free[rows].argmax(axis=1)
    last = free.shape[1] - free[rows, ::-1].argmax(axis=1)
    corners = [np.stack([x, y], axis=1) for x in (first, last) for y in (rows, rows + 1)]
    places = to_world(pose, np.concatenate(corners) * resolution)
    problem = too_far((*places.min(axis=0).tolist(), *places.max(axis=0).tolist()))
    if problem:
        raise InputError(
            f"{where}: image: its free part of {last.max() - first.min():,} x "
            f"{rows[-1] - rows[0] + 1:,} pixels at {resolution:g} m {problem}; correct resolution "
            "or origin, or choose a region"
        )


def plan_of_cells(
    free: NDArray[np.bool_],
    resolution: float,
    pose: NDArray[np.float64],
    name: tuple[str, int],
    rng: np.random.Generator,
    palette: str,
) -> FloorPlan:
    """The floor plan of an occupancy grid.

    Args:
        free: (H, W) cells known to be free, row 0 the lowest y, of `large_regions`.
        resolution: metres a cell.
        pose: [x, y, yaw] of the grid's lower left corner.
        name: family and seed of the plan.
        rng: of the colours, which a grid does not have.
        palette: "standard" or "shifted".
    """
    loops = [to_world(pose, loop * resolution) for loop in free_loops(free)]
    look = imported_look(rng, palette)
    walls, names, offsets, materials = dress_loops(loops, rng, palette)
    rooms = tuple(
        Room("open", tuple(map(tuple, loop.tolist()))) for loop in loops if signed_area(loop) > 0
    )
    return FloorPlan(*name, walls, names, offsets, materials, rooms, look=look)


def _origin(entry: Field) -> Array:
    """The pose [x, y, yaw] of the image's lower left corner."""
    if not isinstance(entry.value, list) or len(entry.value) != 3:
        raise entry.fail("give [x, y, yaw]")
    return np.array([number_of(item) for item in entry])


def large_regions(free: NDArray[np.bool_], resolution: float) -> NDArray[np.bool_]:
    """The free cells joined by their edges to enough room for the car."""
    grid = np.pad(free, 1).astype(np.uint8)
    count, labels = cv2.connectedComponents(grid, connectivity=4)
    inner = cells_to_blocked(grid) * resolution
    outer = (inner <= _CAR_RADIUS).astype(np.uint8)
    opened = cells_to_blocked(outer) * resolution
    covered = (opened <= _CAR_RADIUS) & (grid > 0)
    cells = np.bincount(labels[covered], minlength=count)
    cells[0] = 0
    return (cells * resolution**2 >= MIN_AREA)[labels][1:-1, 1:-1]
