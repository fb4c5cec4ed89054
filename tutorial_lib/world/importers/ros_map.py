"""Maps as ROS saves them: a YAML file beside an image of the occupancy grid.

The meaning of every key is that of nav2's map_server.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import to_world
from tutorial_lib.world.fields import Field
from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.importers.contours import free_loops, signed_area
from tutorial_lib.world.importers.surfaces import check_choice, dress_loops, imported_look
from tutorial_lib.world.occupancy import cells_to_blocked

MIN_AREA = 1.0
"""Square metres that the car must be able to cover in a free region, or it is left out."""
MAX_EXTENT = 1000.0
"""Metres across, above which a resolution is taken for a mistake."""
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
    root = _read_yaml(Path(path))
    resolution = _positive(root["resolution"])
    pose = _origin(root["origin"])
    free = _free_cells(root, Path(path).parent)
    extent = resolution * max(free.shape)
    if extent > MAX_EXTENT:
        raise root["resolution"].fail(f"the map would be {extent:g} m across; give metres a cell")
    if not large_regions(free, resolution).any():
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
        free: (H, W) cells known to be free, row 0 the lowest y.
        resolution: metres a cell.
        pose: [x, y, yaw] of the grid's lower left corner.
        name: family and seed of the plan.
        rng: of the colours, which a grid does not have.
        palette: "standard" or "shifted".
    """
    cells = free_loops(large_regions(free, resolution))
    loops = [to_world(pose, loop * resolution) for loop in cells]
    look = imported_look(rng, palette)
    walls, names, offsets, materials = dress_loops(loops, rng, palette)
    rooms = tuple(
        Room("open", tuple(map(tuple, loop.tolist()))) for loop in loops if signed_area(loop) > 0
    )
    return FloorPlan(*name, walls, names, offsets, materials, rooms, look=look)


def _read_yaml(path: Path) -> Field:
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a map's YAML file") from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" near line {mark.line + 1}" if mark else ""
        raise InputError(f"{path.name}: is no valid YAML{where}; correct it") from None
    return Field(content, path.name)


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
    colour, alpha = _read_picture(root["image"], folder)
    if alpha is None:
        shade = colour.mean(axis=2)
    elif mode == "trinary":  # map_server averages alpha in; grey counts as red, green and blue
        shade = (3.0 * colour.mean(axis=2) + alpha) / 4.0
    else:
        shade = colour.mean(axis=2)
    occupied = shade if negate else 1.0 - shade
    free = (occupied < low) & ~(occupied > high)
    if mode == "scale" and alpha is not None:
        free &= alpha >= 1.0
    return free[::-1]


def _thresholds(root: Field) -> tuple[float, float]:
    """free_thresh and occupied_thresh."""
    low, high = _number(root["free_thresh"]), _number(root["occupied_thresh"])
    for key, value in (("free_thresh", low), ("occupied_thresh", high)):
        if not 0.0 <= value <= 1.0:
            raise root[key].fail("give a share from 0 to 1")
    if low >= high:
        raise root["free_thresh"].fail(f"give less than occupied_thresh, {high:g}")
    return low, high


def _read_picture(
    entry: Field, folder: Path
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Brightness (H, W, 1 or 3) and, where there is one, opacity (H, W), each 0 to 1."""
    path = folder / entry.text()
    try:
        data = path.read_bytes()
    except (OSError, ValueError):
        raise entry.fail("this picture cannot be read; put it beside the YAML file") from None
    if data[:2] in (b"P2", b"P5"):
        return _read_pgm(data, entry)[..., None], None
    cut = data[:4] == b"\x89PNG" and b"IEND" not in data
    picture = None if cut or not data else _decode(data)
    if picture is None or picture.dtype not in (np.uint8, np.uint16):
        raise entry.fail("this is no whole PGM or PNG picture; was it cut off?")
    levels = picture.reshape(*picture.shape[:2], -1) / np.iinfo(picture.dtype).max
    if levels.shape[2] in (2, 4):
        return levels[..., :-1], levels[..., -1]
    return levels, None


def _decode(data: bytes) -> NDArray[Any] | None:
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None


def _read_pgm(data: bytes, entry: Field) -> NDArray[np.float64]:
    """Brightness (H, W), 0 to 1, of a PGM in text (P2) or bytes (P5); OpenCV accepts cut ones."""
    header = re.match(rb"P[25]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d{1,9})" + rb"(?=\s)", data)
    if header is None:
        raise entry.fail("its PGM header is broken; give width, height and largest value")
    width, height, top = (int(group) for group in header.groups())
    if not (width and height and 0 < top < 65536):
        raise entry.fail(f"PGM of {width} x {height} pixels up to {top}; give sizes above 0")
    count = width * height
    if data[:2] == b"P5":
        kind = np.dtype(np.uint8 if top < 256 else ">u2")
        body = data[header.end() + 1 :]
        found = len(body) // kind.itemsize
    else:
        kind = np.dtype(np.int64)
        body = re.sub(rb"#[^\n]*", b"", data[header.end() :]).split()
        found = len(body)
    if found < count:
        raise entry.fail(
            f"holds {found} of {width} x {height} pixels; it was cut off, save it again"
        )
    if data[:2] == b"P5":
        values = np.frombuffer(body, kind, count)
    else:
        try:
            values = np.array([min(int(word), top) for word in body[:count]])
        except ValueError:
            raise entry.fail("a pixel is no number; save the PGM again") from None
    return np.clip(values.reshape(height, width) / top, 0.0, 1.0)


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
