"""What drawing is given: pictures, colours, sizes in pixels; see `validation` for all else."""

from collections.abc import Iterable
from types import EllipsisType

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import floats, images, instance, integers, listed, number, whole

Picture = NDArray[np.uint8]

FAR = 1e5
"""Metres; farther than any plan reaches, and 1/16 of a pixel still fits into 32 bits."""
LARGEST = 16_384
"""Pixels of a picture's side: more than any screen has, and as many as OpenCV draws well."""


def picture_of(name: str, value: ArrayLike) -> Picture:
    """A picture (H, W, 3) of bytes, or an `InputError`."""
    return np.ascontiguousarray(images(name, value, ("H", "W", 3), empty=False))


def resized(picture: Picture, size: tuple[int, int], how: int) -> Picture:
    """A picture scaled to columns and rows by one of OpenCV's interpolations."""
    return np.asarray(cv2.resize(picture, size, interpolation=how), np.uint8)


def pictures_of(name: str, values: Iterable[ArrayLike]) -> list[Picture]:
    """Pictures, each of a size of its own, or an `InputError`."""
    given = listed(name, values, "a list of pictures")
    return [picture_of(f"{name}[{number}]", value) for number, value in enumerate(given)]


def check_canvas(picture: Picture) -> None:
    """Check that a picture can be drawn on: in a list or a copy the drawing would be lost."""
    images("picture", instance("picture", picture, np.ndarray), ("H", "W", 3), empty=False)


def colour_of(name: str, value: ArrayLike) -> tuple[int, int, int]:
    """Red, green and blue from 0 to 255, or an `InputError`."""
    red, green, blue = integers(name, value, (3,), least=0, most=255).tolist()
    return red, green, blue


def places_of(
    name: str, value: ArrayLike, shape: tuple[int | str | EllipsisType, ...], empty: bool = True
) -> Array:
    """Points or poses in metres (and rad), less than `FAR` away, or an `InputError`.

    An empty list has no second axis, and is taken for no points.
    """
    none = (
        value.shape == (0,)
        if isinstance(value, np.ndarray)
        else isinstance(value, (list, tuple)) and not value
    )
    if none and len(shape) > 1:
        value = np.empty((0, 3 if shape[1] == 3 else 2))
    return floats(name, value, shape, least=-FAR, most=FAR, empty=empty)


def points_of(name: str, value: ArrayLike) -> Array:
    """The points (N, 2) of N points or poses, or an `InputError`."""
    found = places_of(name, value, ("N", "2 or 3"))
    if found.shape[1] not in (2, 3):
        raise InputError(f"{name}: shape {found.shape}; give x and y of each")
    return found[:, :2]


def pairs_of(
    value: Iterable[tuple[int, int]], count: int, of: str, name: str = "edges"
) -> list[tuple[int, int]]:
    """Edges between that many nodes or poses, or an `InputError`."""
    found = list(listed(name, value, "pairs of vertices"))
    if found:
        integers(f"{name} between {count} {of}", found, ("E", 2), least=0, most=count - 1)
    return found


def pixels_of(name: str, value: int, least: int = 1) -> int:
    """A whole number of pixels, or an `InputError`."""
    return whole(name, value, least=least, most=LARGEST)


def thickness_of(name: str, value: float) -> float:
    """Pixels of a line or a mark, which need not be whole, or an `InputError`."""
    return number(name, value, least=0.0, most=LARGEST)
