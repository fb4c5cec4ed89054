"""Whether a value is an array of some kind and shape, and the words for what it should be."""

import re
from types import EllipsisType
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError, one_line

Shape = tuple["int | str | EllipsisType", ...]
"""Lengths; a name stands for any length and `...` for any axes in front."""
LARGEST = 1e15
"""Of real numbers: the squares of greater ones, or their cells on a grid, are soon none."""
_INDEX = np.dtype(np.intp)
_FLOAT, _FEW = np.dtype(float), 4_096  # numbers, of which the sum of squares says all at once
_QUOTED = 60  # characters of a value within a message


def as_array(
    name: str, value: object, kinds: str, words: str, shape: Shape, empty: bool
) -> NDArray[Any]:
    """A value as an array of these kinds of numbers and this shape, or an `InputError`."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, RuntimeError) as error:  # ragged lists; a tensor with gradients
        raise InputError(f"{name}: {one_line(str(error), 200)}; give {words}") from error
    if array.dtype.kind not in kinds and array.size:
        wanted = in_words(words, shape)
        given = quoted(value) if array.ndim == 0 else f"array of {array.dtype}"
        raise InputError(f"{name}: {given}; give {wanted}")
    if isinstance(value, np.ma.MaskedArray):
        raise InputError(f"{name}: an array with a mask; give {in_words(words, shape)}, filled")
    if not fits(array.shape, shape):
        raise InputError(f"{name}: shape {array.shape}; give {in_words(words, shape)}")
    if not (empty or array.size):
        raise InputError(f"{name}: empty; give {in_words(words, shape)}, one at least")
    return array if array.dtype.kind in kinds else array.astype(float if "f" in kinds else np.uint8)


def is_plain(value: object, shape: Shape) -> TypeGuard[NDArray[np.float64]]:
    """Whether a value is seen at a glance to be right: a few small float64 of the shape."""
    return (
        type(value) is np.ndarray
        and value.dtype is _FLOAT
        and 0 < value.size < _FEW
        and fits(value.shape, shape)
        and bool(np.vdot(value, value) <= LARGEST**2)
    )


def is_plain_index(value: object, shape: Shape, most: int | None) -> TypeGuard[NDArray[np.intp]]:
    """Whether a value is seen at a glance to be indices from 0 to `most`."""
    return (
        type(value) is np.ndarray
        and value.dtype is _INDEX
        and value.size > 0
        and most is not None
        and fits(value.shape, shape)
        # Without a sign, a negative one is greater than any.
        and bool(value.view(np.uintp).max() <= most)
    )


def fits(found: tuple[int, ...], wanted: Shape) -> bool:
    """Whether a shape is the wanted one."""
    if wanted and wanted[0] is ...:
        wanted = wanted[1:]
        found = found[max(len(found) - len(wanted), 0) :]
    if len(found) != len(wanted):
        return False
    for there, length in zip(found, wanted, strict=True):
        if there != length and not isinstance(length, str):
            return False
    return True


def in_words(words: str, shape: Shape) -> str:
    """What to give, in words."""
    if shape == (...,):
        return words
    if shape == ():
        return f"one {words.removesuffix('s')}"
    lengths = ", ".join("..." if length is ... else str(length) for length in shape)
    return f"{words} of shape ({lengths}{',' if len(shape) == 1 else ''})"


def wrong(name: str, value: object, words: str, shape: Shape) -> InputError:
    """The error that names a value and what to give instead."""
    if shape == ():
        words = words.replace("whole numbers", "one whole number")
        words = re.sub(r"^(finite )?numbers", "one real number", words)
    if isinstance(value, np.generic):
        value = value.item()
    return InputError(f"{name}: {quoted(value)}; give {words}")


def limits(least: float, most: float) -> str:
    """Limits in words; nothing where there are none."""
    if least > -np.inf and most < np.inf:
        return f" from {least:.15g} to {most:.15g}"
    if least > -np.inf:
        return f" from {least:.15g} on"
    return f" up to {most:.15g}" if most < np.inf else ""


def quoted(value: object) -> str:
    """A value as it looks in Python, cut."""
    try:
        return one_line(repr(value), _QUOTED)
    except Exception:
        return f"a {type(value).__name__}"
