"""What the arguments of public functions must be: checks for the doors of the library.

Each returns its argument in the form that the code behind the door computes with, or raises an
`InputError` that names the argument, says what was given, and what to give. They take microseconds:
use them where a caller's value comes in, and not inside loops.

A shape is a tuple of lengths, in which a name stands for any length and `...` for any axes in
front: ``("N", 3)``, ``(..., 2)``.
"""

import operator
import re
from collections.abc import Collection, Iterable, Sized
from os import PathLike
from pathlib import Path
from typing import Any, SupportsIndex, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.array_forms import (
    LARGEST,
    Shape,
    as_array,
    is_plain,
    is_plain_index,
    limits,
    quoted,
    wrong,
)
from tutorial_lib.errors import InputError

Kind = TypeVar("Kind")

_LEAST, _MOST = np.iinfo(np.intp).min, np.iinfo(np.intp).max


def floats(
    name: str,
    value: object,
    shape: Shape = (...,),
    *,
    least: float = -np.inf,
    most: float = np.inf,
    infinite: bool = False,
    nan: bool = False,
    empty: bool = True,
) -> NDArray[np.float64]:
    """Real numbers as float64, none beyond `LARGEST` but infinities.

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
    if least == -np.inf and most == np.inf and is_plain(value, shape):
        return value
    array = as_array(name, value, "biuf", "real numbers", shape, empty).astype(float, copy=False)
    bad = ~(np.abs(array) <= LARGEST)
    if infinite:
        bad &= ~np.isinf(array)
    if least > -np.inf or most < np.inf:
        bad |= ~((array >= least) & (array <= most))
    if nan:
        bad &= ~np.isnan(array)
    if bad.any():
        value, allowed = array[bad].flat[0], "" if infinite else "finite "
        if LARGEST < abs(value) < np.inf:
            least, most = max(least, -LARGEST), min(most, LARGEST)
        raise wrong(name, value, f"{allowed}numbers{limits(least, most)}", shape)
    return array


def integers(
    name: str,
    value: object,
    shape: Shape = (...,),
    *,
    least: int | None = None,
    most: int | None = None,
    empty: bool = True,
) -> NDArray[np.intp]:
    """Whole numbers, as indices are, or an `InputError`, also for floats that are whole.

    >>> integers("frames", [3, 99], ("F",), least=0, most=9)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: frames: 99; give whole numbers from 0 to 9
    """
    if least == 0 and is_plain_index(value, shape, most):
        return value
    array = as_array(name, value, "iu", "whole numbers", shape, empty)
    low, high = _LEAST if least is None else least, _MOST if most is None else most
    bad = ~((array >= low) & (array <= high))
    if bad.any():
        span = limits(-np.inf if least is None else least, np.inf if most is None else most)
        raise wrong(name, array[bad].flat[0], f"whole numbers{span}", shape)
    return array.astype(np.intp, copy=False)


def flags(
    name: str, value: object, shape: Shape = (...,), *, empty: bool = True
) -> NDArray[np.bool_]:
    """Truth values; 0 and 1 are taken for False and True.

    Raises:
        InputError: when the argument is anything else.
    """
    array = as_array(name, value, "biuf", "truth values", shape, empty)
    bad = (array != 0) & (array != 1)
    if bad.any():
        raise wrong(name, array[bad].flat[0], "True or False, or 1 and 0", shape)
    return array.astype(bool, copy=False)


def flag(name: str, value: object) -> bool:
    """True or False, or 1 and 0; an `InputError` says that it is anything else."""
    return value if type(value) is bool else bool(flags(name, value, ()))


def images(name: str, value: object, shape: Shape, *, empty: bool = True) -> NDArray[np.uint8]:
    """Pictures of bytes, or an `InputError`."""
    array = as_array(name, value, "u", "uint8", shape, empty)
    if array.dtype != np.uint8:
        raise InputError(f"{name}: {array.dtype}; give uint8, 0 to 255")
    return array


def number(
    name: str,
    value: object,
    *,
    least: float = -np.inf,
    most: float = np.inf,
    above: float = -np.inf,
    infinite: bool = False,
) -> float:
    """One real number, from `least` to `most`; or greater than `above`, which stands for `least`.

    Raises:
        InputError: when the argument is anything else.
    """
    low, high = max(least, -LARGEST), min(most, LARGEST)
    if type(value) is float and low <= value <= high and above < value:
        return value
    if above > -np.inf:
        found = float(floats(name, value, (), infinite=infinite))
        if not above < found <= most:
            highest = f", up to {most:.15g}" if most < np.inf else ""
            raise InputError(f"{name}: {found}; give one real number above {above:.15g}{highest}")
        return found
    return float(floats(name, value, (), least=least, most=most, infinite=infinite))


def whole(name: str, value: object, *, least: int | None = None, most: int | None = None) -> int:
    """One whole number; True and 3.0 are none.

    Raises:
        InputError: when the argument is anything else.

    >>> whole("k", 2.0)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: k: 2.0; give one whole number
    """
    low, high = -np.inf if least is None else least, np.inf if most is None else most
    if type(value) is int and low <= value <= high:  # before the slow question what it supports
        return value
    try:
        found = operator.index(value) if isinstance(value, SupportsIndex) else None
    except TypeError:
        found = None
    if found is None or isinstance(value, (bool, np.bool_)) or not low <= found <= high:
        raise wrong(name, value, f"whole numbers{limits(low, high)}", ())
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
    raise InputError(f"{name}: {quoted(value)}; give {choice}")


def instance(name: str, value: object, kind: type[Kind]) -> Kind:
    """An object of a class.

    Raises:
        InputError: when it is of another.

    >>> instance("rng", 3, np.random.Generator)
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: rng: 3; give a Generator
    """
    if not isinstance(value, kind):
        article = "an" if re.match("[AEIOUaeiou]|[FHLMNRSX][A-Z]", kind.__name__) else "a"
        raise InputError(f"{name}: {quoted(value)}; give {article} {kind.__name__}")
    return value


def listed(name: str, values: object, what: str) -> tuple[Any, ...]:
    """What comes one after the other, as in a list; text, bytes and arrays without axes do not.

    Raises:
        InputError: for anything else; it says to give `what`.
    """
    alone = isinstance(values, (str, bytes)) or getattr(values, "ndim", 1) == 0
    if alone or not isinstance(values, Iterable):
        raise InputError(f"{name}: {quoted(values)}; give {what}")
    return tuple(values)


def instances(
    name: str, values: object, kind: type[Kind], *, empty: bool = True
) -> tuple[Kind, ...]:
    """Objects of a class, one after the other.

    Raises:
        InputError: when they are of another, or there are none.
    """
    found = listed(name, values, f"a list of {kind.__name__}")
    for number, value in enumerate(found):
        if not isinstance(value, kind):
            instance(f"{name}[{number}]", value, kind)
    if not (found or empty):
        raise InputError(f"{name}: there are none; give one {kind.__name__} at least")
    return found


def path_of(name: str, value: object) -> Path:
    """The path of a file or a folder, or an `InputError`."""
    if not isinstance(value, (str, PathLike)):
        raise InputError(f"{name}: {quoted(value)}; give the path of a file")
    return Path(value)


def with_methods(name: str, value: Kind, *methods: str) -> Kind:
    """An object of whatever class that has these methods, or an `InputError`."""
    if isinstance(value, type) and methods != ("__call__",):
        raise InputError(f"{name}: the class {value.__name__}; give an object of it")
    if "__len__" in methods and getattr(value, "ndim", 1) == 0:
        raise InputError(f"{name}: {quoted(value)}; give several")
    for method in methods:
        if not callable(getattr(value, method, None)):
            raise InputError(f"{name}: {quoted(value)}; give an object with the method {method}")
    return value


def batch(name: str, value: Kind) -> Kind:
    """Images, or whatever an estimator made of them: of any class with a length and indices.

    Raises:
        InputError: when it is anything else, text, or an array of complex numbers or text.

    >>> batch("prepared", np.array(["kitchen", "bath"]))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: prepared: array of <U7; give real numbers
    """
    with_methods(name, value, "__len__", "__getitem__")
    if isinstance(value, (str, bytes)):
        raise InputError(f"{name}: {quoted(value)}; give several")
    if isinstance(value, np.ndarray) and value.dtype.kind not in "biufOV":
        raise InputError(f"{name}: array of {value.dtype}; give real numbers")
    return value


def match(**axes: tuple[int, ...]) -> None:
    """Leading axes of arrays that go together fit as numpy's do; an `InputError` names both."""
    if len(set(axes.values())) == 1:
        return
    try:
        np.broadcast_shapes(*axes.values())
    except ValueError:
        shapes = ", ".join(f"{name}: {shape}" for name, shape in axes.items())
        raise InputError(f"{shapes}; give leading axes that match") from None


def alike(**arrays: Sized) -> None:
    """Arrays that belong together have the same length.

    Raises:
        InputError: when one has no length, or they differ, naming each with its length.

    >>> alike(starts=np.zeros((2, 3)), goals=np.zeros((3, 2)))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: starts: 2, goals: 3; give as many of each
    """
    for name, array in arrays.items():
        with_methods(name, array, "__len__")
    if len({len(array) for array in arrays.values()}) > 1:
        lengths = ", ".join(f"{name}: {len(array)}" for name, array in arrays.items())
        raise InputError(f"{lengths}; give as many of each")


def fit_together(**arrays: tuple[ArrayLike, Shape]) -> None:
    """Check that arrays have the shapes that compiled code counts on: it reads on beyond an end.

    Args:
        arrays: by name, each with its shape, in which a name stands for the same length wherever it
            occurs; the first array that has it says how long.

    Raises:
        InputError: naming the first array that does not fit.

    >>> fit_together(lasers=(np.zeros((2, 96)), ("N", "B")), angles=(np.zeros(96), ("B",)))
    >>> fit_together(robots=([0, 1], ("M",)), odometry=(np.zeros((1, 3)), ("M", 3)))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: odometry: shape (1, 3); give shape (2, 3)
    """
    lengths: dict[str, int] = {}
    for name, (array, shape) in arrays.items():
        found = np.shape(array)
        if len(found) == len(shape):
            for axis, length in zip(shape, found, strict=True):
                if isinstance(axis, str):
                    lengths.setdefault(axis, length)
        wanted = tuple(lengths.get(axis, axis) if isinstance(axis, str) else axis for axis in shape)
        if found != wanted:
            words = ", ".join(map(str, wanted)) + ("," if len(wanted) == 1 else "")
            raise InputError(f"{name}: shape {found}; give shape ({words})")
