"""What the arguments of public functions must be: checks for the doors of the library.

Each returns its argument in the form that the code behind the door computes with, or raises an
`InputError` that names the argument, says what was given, and what to give. They take microseconds:
use them where a caller's value comes in, and not inside loops.

A shape is a tuple of lengths, in which a name stands for any length and `...` for any axes in
front: ``("N", 3)``, ``(..., 2)``.
"""

from __future__ import annotations

import operator
from collections.abc import Collection
from types import EllipsisType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError, one_line

Shape = tuple["int | str | EllipsisType", ...]
Kind = TypeVar("Kind")

_QUOTED = 60  # characters of a value within a message
_LEAST, _MOST = np.iinfo(np.intp).min, np.iinfo(np.intp).max


def floats(
    name: str,
    value: ArrayLike,
    shape: Shape = (...,),
    *,
    least: float = -np.inf,
    most: float = np.inf,
    infinite: bool = False,
    nan: bool = False,
    empty: bool = True,
) -> NDArray[np.float64]:
    """Real numbers as float64.

    Args:
        name: of the argument.
        value: numbers or truth values; a scalar is an array without axes.
        shape: that they must have.
        least: the smallest value allowed.
        most: the largest value allowed.
        infinite: whether infinities may stand among them.
        nan: whether NaN may, for what is not known.
        empty: whether there may be none.

    Raises:
        InputError: when the argument is anything else.

    >>> floats("poses", [[1, 2, 0]], ("N", 3)).tolist()
    [[1.0, 2.0, 0.0]]
    >>> floats("poses", [[1, 2]], ("N", 3))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: poses: shape (1, 2); give real numbers of shape (N, 3)
    >>> floats("share", 1.5, (), least=0, most=1)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: share: 1.5; give one real number from 0 to 1
    """
    array = _array(name, value, "biuf", "real numbers", shape, empty).astype(float, copy=False)
    bad = np.isnan(array) if infinite else ~np.isfinite(array)
    if least > -np.inf or most < np.inf:
        bad |= ~((array >= least) & (array <= most))
    if nan:
        bad &= ~np.isnan(array)
    if bad.any():
        allowed = "" if infinite else "finite "
        raise _wrong(name, array[bad].flat[0], f"{allowed}numbers{_span(least, most)}", shape)
    return array


def integers(
    name: str,
    value: ArrayLike,
    shape: Shape = (...,),
    *,
    least: int | None = None,
    most: int | None = None,
    empty: bool = True,
) -> NDArray[np.intp]:
    """Whole numbers, as indices are; floats are refused even if they are whole.

    Raises:
        InputError: when the argument is anything else.

    >>> integers("frames", [3, 99], ("F",), least=0, most=9)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: frames: 99; give whole numbers from 0 to 9
    """
    array = _array(name, value, "iu", "whole numbers", shape, empty)
    low, high = _LEAST if least is None else least, _MOST if most is None else most
    bad = ~((array >= low) & (array <= high))
    if bad.any():
        span = _span(-np.inf if least is None else least, np.inf if most is None else most)
        raise _wrong(name, array[bad].flat[0], f"whole numbers{span}", shape)
    return array.astype(np.intp, copy=False)


def flags(
    name: str, value: ArrayLike, shape: Shape = (...,), *, empty: bool = True
) -> NDArray[np.bool_]:
    """Truth values; 0 and 1 are taken for False and True.

    Raises:
        InputError: when the argument is anything else.
    """
    array = _array(name, value, "biuf", "truth values", shape, empty)
    bad = (array != 0) & (array != 1)
    if bad.any():
        raise _wrong(name, array[bad].flat[0], "True or False, or 1 and 0", shape)
    return array.astype(bool, copy=False)


def images(name: str, value: ArrayLike, shape: Shape) -> NDArray[np.uint8]:
    """Pictures of bytes.

    Raises:
        InputError: when the argument is anything else.
    """
    array = _array(name, value, "u", "uint8", shape, empty=True)
    if array.dtype != np.uint8:
        raise InputError(f"{name}: {array.dtype}; give uint8, 0 to 255")
    return array


def number(
    name: str,
    value: object,
    *,
    least: float = -np.inf,
    most: float = np.inf,
    infinite: bool = False,
) -> float:
    """One real number.

    Raises:
        InputError: when the argument is anything else.
    """
    return float(floats(name, value, (), least=least, most=most, infinite=infinite))  # type: ignore[arg-type]


def whole(name: str, value: object, *, least: int | None = None, most: int | None = None) -> int:
    """One whole number; True and 3.0 are none.

    Raises:
        InputError: when the argument is anything else.

    >>> whole("k", 2, least=0)
    2
    >>> whole("k", 2.0)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: k: 2.0; give one whole number
    """
    low, high = -np.inf if least is None else least, np.inf if most is None else most
    try:
        found = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        found = None
    if found is None or isinstance(value, (bool, np.bool_)) or not low <= found <= high:
        raise _wrong(name, value, f"whole numbers{_span(low, high)}", ())
    return found


def one_of(name: str, value: object, known: Collection[Kind]) -> Kind:
    """One of the values that are known.

    Raises:
        InputError: when it is none of them.

    >>> one_of("family", "castle", ("maze", "office"))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: family: 'castle'; give maze or office
    """
    for one in known:
        if type(value) is type(one) and value == one:
            return one
    *others, last = map(str, known)
    choice = f"{', '.join(others)} or {last}" if others else last
    raise InputError(f"{name}: {_quoted(value)}; give {choice}")


def instance(name: str, value: object, kind: type[Kind] | tuple[type[Kind], ...]) -> Kind:
    """An object of a class, or of one of several.

    Raises:
        InputError: when it is of another.

    >>> instance("rng", 3, np.random.Generator)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: rng: 3; give a Generator
    """
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        wanted = " or ".join(one.__name__ for one in kinds)
        article = "an" if wanted[0] in "AEIOUaeiou" else "a"
        raise InputError(f"{name}: {_quoted(value)}; give {article} {wanted}")
    return value


def with_methods(name: str, value: Kind, *methods: str) -> Kind:
    """An object of whatever class that has these methods.

    Raises:
        InputError: when it has not.

    >>> with_methods("controller", 3, "act")
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: controller: 3; give an object with the method act
    """
    for method in methods:
        if not callable(getattr(value, method, None)):
            raise InputError(f"{name}: {_quoted(value)}; give an object with the method {method}")
    return value


def alike(**arrays: NDArray[Any]) -> None:
    """Arrays that belong together have the same length.

    Raises:
        InputError: when they do not, naming each with its length.

    >>> alike(starts=np.zeros((2, 3)), goals=np.zeros((3, 2)))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: starts: 2, goals: 3; give as many of each
    """
    if len({len(array) for array in arrays.values()}) > 1:
        lengths = ", ".join(f"{name}: {len(array)}" for name, array in arrays.items())
        raise InputError(f"{lengths}; give as many of each")


def _array(
    name: str, value: ArrayLike, kinds: str, words: str, shape: Shape, empty: bool
) -> NDArray[Any]:
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, RuntimeError) as error:  # ragged lists; a tensor with gradients
        raise InputError(f"{name}: {one_line(str(error), 200)}; give {words}") from error
    if array.dtype.kind not in kinds and array.size:
        wanted = _wanted(words, shape)
        given = _quoted(value) if array.ndim == 0 else f"array of {array.dtype}"
        raise InputError(f"{name}: {given}; give {wanted}")
    if not fits(array.shape, shape):
        raise InputError(f"{name}: shape {array.shape}; give {_wanted(words, shape)}")
    if not (empty or array.size):
        raise InputError(f"{name}: empty; give {_wanted(words, shape)}, one at least")
    return array if array.dtype.kind in kinds else array.astype(float if "f" in kinds else np.uint8)


def fits(found: tuple[int, ...], wanted: Shape) -> bool:
    if wanted[:1] == (...,):
        wanted = wanted[1:]
        found = found[len(found) - len(wanted) :] if len(found) >= len(wanted) else found
    return len(found) == len(wanted) and all(
        isinstance(length, str) or length == there
        for length, there in zip(wanted, found, strict=True)
    )


def _wanted(words: str, shape: Shape) -> str:
    if shape == (...,):
        return words
    if shape == ():
        return f"one {words.removesuffix('s')}"
    lengths = ", ".join("..." if length is ... else str(length) for length in shape)
    return f"{words} of shape ({lengths}{',' if len(shape) == 1 else ''})"


def _wrong(name: str, value: object, words: str, shape: Shape) -> InputError:
    if shape == ():
        words = words.replace("finite numbers", "one real number").replace("numbers", "number")
        words = words.replace("whole", "one whole")
    if isinstance(value, np.generic):
        value = value.item()
    return InputError(f"{name}: {_quoted(value)}; give {words}")


def _span(least: float, most: float) -> str:
    if least > -np.inf and most < np.inf:
        return f" from {least:g} to {most:g}"
    return f" from {least:g} on" if least > -np.inf else f" up to {most:g}" if most < np.inf else ""


def _quoted(value: object) -> str:
    try:
        return one_line(repr(value), _QUOTED)
    except Exception:
        return f"a {type(value).__name__}"
