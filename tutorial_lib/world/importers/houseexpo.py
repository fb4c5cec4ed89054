"""Floor plans of the HouseExpo data set: an outer wall and the rooms' boxes, as JSON."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_json
from tutorial_lib.reading.limits import MAX_BOXES, MAX_OUTLINE
from tutorial_lib.validation import path_of
from tutorial_lib.world.fields import Field
from tutorial_lib.world.floorplan import FloorPlan, Room, too_far
from tutorial_lib.world.importers.contours import signed_area
from tutorial_lib.world.importers.surfaces import check_choice, dress_loops, imported_look

_SAME = 1e-3  # metres within which two corners are one
_MIN_ROOM = 0.5  # square metres below which what is left of a room's box is dropped
_KINDS = {
    "bathroom": "bathroom toilet restroom shower",
    "bedroom": "bedroom child_room guest_room nursery",
    "hallway": "hallway hall entryway entrance corridor lobby passage",
    "kitchen": "kitchen pantry",
    "living": "living_room dining_room lounge family_room living",
    "office": "office study library",
    "storage": "storage garage wardrobe boiler_room closet laundry laundry_room",
}
_KIND_OF = {name: kind for kind, names in _KINDS.items() for name in names.split()}


def import_houseexpo(path: str | Path, seed: int = 0, palette: str = "standard") -> FloorPlan:
    """Read a HouseExpo JSON file (Li et al. 2019) as a floor plan.

    Args:
        path: the JSON file, with `verts` in metres and, where known, `room_category`.
        seed: of the colours, which the data set does not have.
        palette: "standard" or "shifted".

    Returns:
        A plan with walls along the outline, and a room for each box, cut to the outline; boxes may
        overlap. Without any there is one room of kind "open".

    Raises:
        InputError: naming the file and field, when one is missing or malformed, or when the
            outline crosses itself or encloses nothing.
    """
    check_choice(seed, palette)
    path = path_of("path", path)
    content = read_json(path, "give a HouseExpo JSON file; was it cut off?")
    root = Field(content, path.name)
    outline = _outline(root["verts"])
    rng = np.random.default_rng(seed)
    look = imported_look(rng, palette)
    try:
        walls, names, offsets, materials = dress_loops([outline], rng, palette)
    except InputError as error:
        raise InputError(f"{root['verts'].where}: {error}") from error
    rooms = _rooms(root["room_category"], outline) if "room_category" in root else ()
    rooms = rooms or (_room("open", outline),)
    return FloorPlan("houseexpo", int(seed), walls, names, offsets, materials, rooms, look=look)


def _outline(verts: Field) -> NDArray[np.float64]:
    """The outer wall (K, 2), counter-clockwise, no corner repeated."""
    points = np.array(verts.points()).reshape(-1, 2)
    if len(points) > MAX_OUTLINE:
        raise InputError(f"{verts.where}: {len(points)} corners; give at most {MAX_OUTLINE}")
    if len(points):
        points = points[np.hypot(*(points - np.roll(points, 1, axis=0)).T) > _SAME]
    if len(points) < 3:
        raise verts.fail("give at least three different corners [x, y]")
    problem = too_far((*points.min(axis=0).tolist(), *points.max(axis=0).tolist()))
    if problem:
        raise InputError(f"{verts.where}: the outline {problem}; give metres")
    crossing = _crossing(points)
    if crossing is not None:
        i, j = crossing
        raise InputError(
            f"{verts.where}: the walls after different corners {points[i].tolist()} and "
            f"{points[j].tolist()} cross; give an outline that does not cross itself"
        )
    area = signed_area(points)
    if abs(area) < _MIN_ROOM:
        raise InputError(f"{verts.where}: enclose {abs(area):.2g} m²; give metres, {_MIN_ROOM} up")
    return points if area > 0 else points[::-1]


def _crossing(points: NDArray[np.float64]) -> tuple[int, int] | None:
    """Two sides of a polygon that cross, each by its first corner; touching is allowed."""
    ends = np.roll(points, -1, axis=0)
    for i in range(len(points)):
        a, b, c, d = points[i], ends[i], points[i + 1 :], ends[i + 1 :]
        across = _side(a, b, c) * _side(a, b, d) < 0
        hits = np.flatnonzero(across & (_side(c, d, a) * _side(c, d, b) < 0))
        if hits.size:
            return i, i + 1 + int(hits[0])
    return None


def _side(
    start: NDArray[np.float64], end: NDArray[np.float64], point: NDArray[np.float64]
) -> NDArray[np.float64]:
    """On which side of a line each point lies: positive left, 0 within a micrometre or so."""
    along, offset = end - start, point - start
    cross = along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0]
    return np.where(np.abs(cross) < 1e-6 * np.hypot(*np.moveaxis(along, -1, 0)), 0.0, cross)


def _rooms(categories: Field, outline: NDArray[np.float64]) -> tuple[Room, ...]:
    if not isinstance(categories.value, dict):
        raise categories.fail("give a mapping of categories to boxes")
    rooms, count = [], 0
    for name in categories.value:
        entry = categories[name]
        single = isinstance(entry.value, list) and entry.value[:1] and _is_number(entry.value[0])
        boxes = [entry] if single else list(entry)
        count += len(boxes)
        if count > MAX_BOXES:
            raise InputError(f"{categories.where}: give at most {MAX_BOXES} boxes")
        for box in boxes:
            x0, y0, x1, y1 = box.numbers(4)
            corners = _clipped(outline, (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)))
            if len(corners) >= 3 and abs(signed_area(corners)) >= _MIN_ROOM:
                rooms.append(_room(_kind(str(name)), corners))
    return tuple(rooms)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)


def _kind(category: str) -> str:
    """The kind of room that a category names; "open" where none fits.

    >>> _kind("Living_Room"), _kind("guest room"), _kind("Gym"), _kind("Toilet,Storage")
    ('living', 'bedroom', 'open', 'bathroom')
    """
    for part in re.split(r"[,/&+]", category):
        name = re.sub(r"[\s_-]+", "_", part.strip().lower())
        if name in _KIND_OF:
            return _KIND_OF[name]
    return "open"


def _clipped(
    polygon: NDArray[np.float64], box: tuple[float, float, float, float]
) -> NDArray[np.float64]:
    """The part of a polygon inside a box x0, y0, x1, y1 (Sutherland and Hodgman).

    Parts that hang together only outside of the box stay joined by sides along its border.
    """
    for axis, limit, sign in ((0, box[0], 1), (1, box[1], 1), (0, box[2], -1), (1, box[3], -1)):
        corners = []
        depth = sign * (polygon[:, axis] - limit)
        for k in range(len(polygon)):
            if (depth[k - 1] >= 0) != (depth[k] >= 0):
                share = depth[k - 1] / (depth[k - 1] - depth[k])
                corners.append(polygon[k - 1] + share * (polygon[k] - polygon[k - 1]))
            if depth[k] >= 0:
                corners.append(polygon[k])
        polygon = np.array(corners).reshape(-1, 2)
        if len(polygon):
            polygon = polygon[np.hypot(*(polygon - np.roll(polygon, 1, axis=0)).T) > _SAME]
    return polygon


def _room(kind: str, corners: NDArray[np.float64]) -> Room:
    return Room(kind, tuple((x, y) for x, y in corners.tolist()))
