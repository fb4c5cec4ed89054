"""What drawing is given: pictures, colours, sizes in pixels; see `validation` for all else."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import images, instance, integers, number, whole

Picture = NDArray[np.uint8]

LARGEST = 16_384
"""Pixels of a picture's side: more than any screen has, and as many as OpenCV draws well."""


def picture_of(name: str, value: ArrayLike) -> Picture:
    """A picture (H, W, 3) of bytes, or an `InputError`."""
    return np.ascontiguousarray(images(name, value, ("H", "W", 3), empty=False))


def pictures_of(name: str, values: Iterable[ArrayLike]) -> list[Picture]:
    """Pictures, each of a size of its own, or an `InputError`."""
    if not isinstance(values, Iterable):
        raise InputError(f"{name}: {values!r}; give a list of pictures")
    return [picture_of(f"{name}[{number}]", value) for number, value in enumerate(values)]


def check_canvas(picture: Picture) -> None:
    """Check that a picture can be drawn on: in a list or a copy the drawing would be lost."""
    images("picture", instance("picture", picture, np.ndarray), ("H", "W", 3), empty=False)


def colour_of(name: str, value: ArrayLike) -> tuple[int, int, int]:
    """Red, green and blue from 0 to 255, or an `InputError`."""
    red, green, blue = integers(name, value, (3,), least=0, most=255).tolist()
    return red, green, blue


def pixels_of(name: str, value: int, least: int = 1) -> int:
    """A whole number of pixels, or an `InputError`."""
    return whole(name, value, least=least, most=LARGEST)


def thickness_of(name: str, value: float) -> float:
    """Pixels of a line or a mark, which need not be whole, or an `InputError`."""
    return number(name, value, least=0.0, most=LARGEST)
