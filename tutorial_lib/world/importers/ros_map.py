"""Maps as ROS saves them: a YAML file beside an image of the occupancy grid.

The meaning of every key is that of nav2's map_server.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_yaml
from tutorial_lib.reading.pictures import Picture, read_picture
from tutorial_lib.se2 import to_world
from tutorial_lib.world.fields import Field
from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.importers.contours import free_loops, signed_area
from tutorial_lib.world.importers.surfaces import check_choice, dress_loops, imported_look
from tutorial_lib.world.occupancy import cells_to_blocked

MIN_AREA = 1.0
"""Square metres that the car must be able to cover in a free region, or it is left out."""
MAX_EXTENT = 1000.0
"""Metres across, above which a resolution is taken for a mistake."""
_AT_ONCE = 1_000_000  # pixels
_CAR_RADIUS = 0.15  # metres; half the car's width and a little room


def import_ros_map(path: str | Path, seed: int = 0, palette: str = "standard") -> FloorPlan:
    """Read a ROS map as a floor plan of its free space.

    Whatever is not known to be free, occupied or unknown, gets walls around it, along the edges of
    the grid's cells and simplified within half a cell. Regions too small for the car are left out.

    Args:
        path: the YAML file; its image is found relative to it.
        seed: of the colours, which a map does not have.
        palette: "standard" or "shifted".

    Returns:
        A plan in metres in the map's frame, with a room of kind "open" for each free region.

    Raises:
        InputError: naming the file and field, when anything is missing, malformed or makes no
            sense, or when no free region is large enough for the car.
    """
    check_choice(seed, palette)
    content = read_yaml(path, "give a map's YAML file, or correct it")
    root = Field(content, Path(path).name)
    resolution = _positive(root["resolution"])
    pose = _origin(root["origin"])
    free = _free_cells(root, Path(path).parent)
    extent = resolution * max(free.shape)
    if extent > MAX_EXTENT:
        raise root["resolution"].fail(f"the map would be {extent:g} m across; give metres a cell")
    free = large_regions(free, resolution)
    if not free.any():
        raise InputError(
            f"{root.where}: image: no free region lets the car cover {MIN_AREA:g} m²; "
            "check negate, free_thresh and resolution"
        )
    rng = np.random.default_rng(seed)
    return plan_of_cells(free, resolution, pose, ("ros", int(seed)), rng, palette)


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


def _number(entry: Field) -> float:
    """A finite number; also one that YAML 1.1 takes for text, such as 5e-2."""
    if isinstance(entry.value, str):
        try:
            return Field(float(entry.value), entry.where).number()
        except ValueError:
            raise entry.fail("give a finite number") from None
    return entry.number()


def _positive(entry: Field) -> float:
    if _number(entry) <= 0:
        raise entry.fail("give metres a cell, above 0")
    return _number(entry)


def _origin(entry: Field) -> NDArray[np.float64]:
    """The pose [x, y, yaw] of the image's lower left corner."""
    if not isinstance(entry.value, list) or len(entry.value) != 3:
        raise entry.fail("give [x, y, yaw]")
    return np.array([_number(item) for item in entry])


def _free_cells(root: Field, folder: Path) -> NDArray[np.bool_]:
    """Which cells are known to be free (H, W), row 0 the lowest y."""
    low, high = _thresholds(root)
    mode = root["mode"].text() if "mode" in root else "trinary"
    if mode not in ("trinary", "scale"):
        raise root["mode"].fail(
            "give trinary or scale (raw maps have no thresholds: save it again)"
        )
    negate = root["negate"].value
    if not isinstance(negate, bool | int):
        raise root["negate"].fail("give 0 or 1")
    picture = _read_picture(root["image"], folder)
    height, width, channels = picture.values.shape
    pixels = picture.values.reshape(-1, channels)
    # Some at a time: as numbers of 64 bits they need many times the room.
    free = [
        _free_pixels(pixels[first : first + _AT_ONCE] / picture.top, mode, bool(negate), low, high)
        for first in range(0, len(pixels), _AT_ONCE)
    ]
    return np.concatenate(free).reshape(height, width)[::-1]


def _free_pixels(
    levels: NDArray[np.float64], mode: str, negate: bool, low: float, high: float
) -> NDArray[np.bool_]:
    """Which of N pixels (N, C), 0 to 1, are known to be free."""
    known = np.ones(len(levels), dtype=bool)
    shade = levels.mean(axis=1)
    if levels.shape[1] in (2, 4):
        alpha, shade = levels[:, -1], levels[:, :-1].mean(axis=1)
        if mode == "trinary":  # map_server averages alpha in; grey counts as red, green and blue
            shade = (3.0 * shade + alpha) / 4.0
        else:
            known = alpha >= 1.0
    occupied = shade if negate else 1.0 - shade
    return known & (occupied < low) & ~(occupied > high)


def _thresholds(root: Field) -> tuple[float, float]:
    """free_thresh and occupied_thresh."""
    low, high = _number(root["free_thresh"]), _number(root["occupied_thresh"])
    for key, value in (("free_thresh", low), ("occupied_thresh", high)):
        if not 0.0 <= value <= 1.0:
            raise root[key].fail("give a share from 0 to 1")
    if low >= high:
        raise root["free_thresh"].fail(f"give less than occupied_thresh, {high:g}")
    return low, high


def _read_picture(entry: Field, folder: Path) -> Picture:
    try:
        return read_picture(folder / entry.text())
    except InputError as error:
        raise entry.fail(f"{error}; put a whole picture beside the YAML file") from None


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
