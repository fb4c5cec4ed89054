"""A part of a map: all within a box, or the free part that holds a point."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.validation import floats
from tutorial_lib.world.occupancy import cells_to_blocked

Region = Sequence[float]
"""x0, y0, x1, y1 of a box, or x, y of a point; metres in the map's frame."""
_ROWS = 256  # at a time: the places of all cells need much room
_NAMED = 5  # free parts in a message, the largest


def parse_region(region: str) -> tuple[float, ...]:
    """A region from text with commas.

    Raises:
        InputError: when it is none.

    >>> parse_region("-1,0,12.5,8")
    (-1.0, 0.0, 12.5, 8.0)
    """
    try:
        return checked_region([float(part) for part in region.split(",")])
    except (ValueError, AttributeError, TypeError):
        raise InputError(f"region: {region!r}; give x0,y0,x1,y1 or x,y in metres") from None


def checked_region(region: Region) -> tuple[float, ...]:
    """The region as a tuple, a box from its lower left to its upper right corner.

    Raises:
        InputError: when it is neither a box nor a point.
    """
    numbers = floats("region", region, ("N",)).tolist()
    if len(numbers) == 2:
        return tuple(numbers)
    if len(numbers) != 4 or numbers[0] == numbers[2] or numbers[1] == numbers[3]:
        raise InputError(f"region: {numbers}; give x0, y0, x1, y1 of a box, or x, y of a point")
    x0, y0, x1, y1 = numbers
    return min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)


def within_box(
    free: NDArray[np.bool_], resolution: float, pose: Array, box: Region
) -> NDArray[np.bool_]:
    """The free cells (H, W) whose middles lie in a box of the map's frame."""
    found = np.zeros_like(free)
    x = (np.arange(free.shape[1]) + 0.5) * resolution
    for first in range(0, len(free), _ROWS):
        y = (first + np.arange(min(_ROWS, len(free) - first)) + 0.5) * resolution
        places = to_world(pose, np.stack(np.meshgrid(x, y), axis=-1))
        inside = (places >= box[:2]) & (places <= box[2:])
        found[first : first + _ROWS] = free[first : first + _ROWS] & inside.all(axis=-1)
    return found


def part_at(
    free: NDArray[np.bool_], resolution: float, pose: Array, point: Region
) -> NDArray[np.bool_]:
    """The free cells (H, W) that hang together with the one at a point of the map's frame.

    Raises:
        InputError: when the point is not free; it names a point in each large part.
    """
    count, labels = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    column, row = np.floor(to_local(pose, point) / resolution).tolist()
    inside = 0 <= row < len(free) and 0 <= column < free.shape[1]
    label = labels[int(row), int(column)] if inside else 0
    if label:
        return labels == label
    cells = np.bincount(labels.ravel(), minlength=count)
    room = cells_to_blocked(np.pad(free, 1).astype(np.uint8))[1:-1, 1:-1]
    parts = []
    for part in 1 + np.argsort(-cells[1:], kind="stable")[:_NAMED]:
        roomiest = np.unravel_index(np.where(labels == part, room, 0).argmax(), room.shape)
        x, y = to_world(pose, (np.array(roomiest[::-1]) + 0.5) * resolution)
        parts.append(f"{x:.2f},{y:.2f} ({cells[part] * resolution**2:,.1f} m²)")
    raise InputError(
        f"region: {point[0]:g},{point[1]:g} is in no free part large enough for the car; give a "
        f"point in one of them, such as {' or '.join(parts)}"
    )
