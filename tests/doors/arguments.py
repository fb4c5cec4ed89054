"""Arguments of public functions: a value that works, and what may be wrong with it.

Each function here is a kind of argument. What is wrong with one is told by its kind, its shape and
its limits; `refuses`, `takes` and `either` name the trials of which that is not true.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tutorial_lib.array_forms import LARGEST

REFUSED, TAKEN, EITHER = "refused", "taken", "either"
"""What must happen: an error that names the argument, a right value, or one of both."""


@dataclass
class Argument:
    """A value that works, and others by what is wrong with them.

    Attributes:
        value: that works.
        trials: the value and what must happen, by label.
        lengths: the value and the name of the axis that has another length, by label: refused where
            another argument has that axis, too.
        axes: names of the axes of free length.
    """

    value: Any
    trials: dict[str, tuple[Any, str]] = field(default_factory=dict)
    lengths: dict[str, tuple[Any, str]] = field(default_factory=dict)
    axes: tuple[str, ...] = ()


Words = str
"""Labels of trials, with commas between them."""


def floats(
    value: Any,
    shape: tuple = (...,),
    *,
    least: float = -np.inf,
    most: float = np.inf,
    infinite: bool = False,
    nan: bool = False,
    empty: bool = True,
    optional: bool = False,
    dtype: type = float,
    **changes: Words,
) -> Argument:
    """Real numbers of a shape, see `validation.floats`."""
    array = np.asarray(value, dtype=dtype)
    found = _array(array, shape, empty)
    inside = REFUSED if not infinite else TAKEN
    found.trials |= {
        "nan": (_with(array, np.nan), TAKEN if nan else REFUSED),
        "inf": (_with(array, np.inf), REFUSED if most < np.inf else inside),
        "-inf": (_with(array, -np.inf), REFUSED if least > -np.inf else inside),
        "huge": (_with(array, 1e308), REFUSED),
        "all huge": (np.full(array.shape, -1e200), REFUSED),
        "large": (_with(array, LARGEST / 2), REFUSED if most < np.inf else EITHER),
        "negative": (-np.abs(array) - 1.0, REFUSED if least > -1 else EITHER),
        "bool": (np.ones(array.shape, dtype=bool), EITHER),
    }
    if least > -np.inf:
        found.trials["below"] = (_with(array, least - 0.5), REFUSED)
    if most < np.inf:
        found.trials["above"] = (_with(array, most + 0.5), REFUSED)
    return _changed(found, optional, changes)


def integers(
    value: Any,
    shape: tuple = ("N",),
    *,
    least: int | None = None,
    most: int | None = None,
    empty: bool = True,
    optional: bool = False,
    **changes: Words,
) -> Argument:
    """Whole numbers of a shape, such as indices."""
    array = np.asarray(value)
    found = _array(array, shape, empty)
    found.trials |= {
        "float": (array + 0.5, REFUSED),
        "whole float": (array.astype(float), REFUSED),
        "nan": (np.full(array.shape, np.nan), REFUSED),
        "bool": (np.ones(array.shape, dtype=bool), REFUSED),
        "negative": (-np.abs(array) - 1, REFUSED if least is not None else EITHER),
        "huge": (_with(array.astype(np.int64), 2**40), REFUSED if most is not None else EITHER),
    }
    if least is not None:
        found.trials["below"] = (_with(array, least - 1), REFUSED)
    if most is not None:
        found.trials["above"] = (_with(array, most + 1), REFUSED)
    return _changed(found, optional, changes)


def flags(
    value: Any, shape: tuple = ("N",), *, optional: bool = False, **changes: Words
) -> Argument:
    """Truth values of a shape."""
    array = np.asarray(value, dtype=bool)
    found = _array(array, shape, empty=True)
    found.trials |= {
        "two": (np.full(array.shape, 2), REFUSED),
        "half": (np.full(array.shape, 0.5), REFUSED),
        "nan": (np.full(array.shape, np.nan), REFUSED),
    }
    return _changed(found, optional, changes)


def images(value: Any, shape: tuple, *, optional: bool = False, **changes: Words) -> Argument:
    """Pictures of bytes."""
    array = np.asarray(value, dtype=np.uint8)
    found = _array(array, shape, empty=True)
    found.trials |= {
        "float": (array / 255.0, REFUSED),
        "int64": (array.astype(np.int64), REFUSED),
        "bool": (array > 0, REFUSED),
    }
    return _changed(found, optional, changes)


def number(
    value: float,
    *,
    least: float = -np.inf,
    most: float = np.inf,
    above: float = -np.inf,
    infinite: bool = False,
    optional: bool = False,
    **changes: Words,
) -> Argument:
    """One real number; greater than `above`."""
    inside = TAKEN if infinite else REFUSED
    low = max(least, above)
    found = _anything(Argument(value))
    found.trials |= {
        "nan": (np.nan, REFUSED),
        "inf": (np.inf, REFUSED if most < np.inf else inside),
        "-inf": (-np.inf, REFUSED if low > -np.inf else inside),
        "huge": (1e308, REFUSED),
        "large": (LARGEST / 2, REFUSED if most < np.inf else EITHER),
        "negative": (-abs(value) - 1.0, REFUSED if low > -1 else EITHER),
        "complex": (value + 1j, REFUSED),
        "several": ([value, value], REFUSED),
        "none": ([], REFUSED),
        "bool": (True, EITHER),
    }
    if least > -np.inf:
        found.trials["below"] = (least - 0.5, REFUSED)
    if above > -np.inf:
        found.trials["at"] = (above, REFUSED)
    if most < np.inf:
        found.trials["above"] = (most + 0.5, REFUSED)
    return _changed(found, optional, changes)


def whole(
    value: int,
    *,
    least: int | None = None,
    most: int | None = None,
    optional: bool = False,
    **changes: Words,
) -> Argument:
    """One whole number."""
    found = _anything(Argument(value))
    found.trials |= {
        "float": (value + 0.5, REFUSED),
        "whole float": (float(value), REFUSED),
        "nan": (np.nan, REFUSED),
        "bool": (True, REFUSED),
        "several": ([value, value], REFUSED),
        "complex": (value + 1j, REFUSED),
        "huge": (10**30, EITHER),
    }
    if least is not None:
        found.trials["below"] = (least - 1, REFUSED)
    if most is not None:
        found.trials["above"] = (most + 1, REFUSED)
    return _changed(found, optional, changes)


def flag(value: bool, *, optional: bool = False, **changes: Words) -> Argument:
    """True or False."""
    found = _anything(Argument(value))
    found.trials |= {"two": (2, REFUSED), "nan": (np.nan, REFUSED), "several": ([True], EITHER)}
    return _changed(found, optional, changes)


def choice(value: Any, *, optional: bool = False, **changes: Words) -> Argument:
    """One of a few values that are known."""
    found = _anything(Argument(value))
    found.trials |= {"number": (3, REFUSED), "empty": ("", REFUSED), "list": ([value], REFUSED)}
    return _changed(found, optional, changes)


def text(value: str, *, optional: bool = False, **changes: Words) -> Argument:
    """Any text."""
    found = _anything(Argument(value))
    found.trials |= {"number": (3, REFUSED), "list": ([value], REFUSED)}
    return _changed(found, optional, {"takes": "text"} | changes)


def path(value: Any, *, optional: bool = False, **changes: Words) -> Argument:
    """A file's or a folder's path; that of a file which is missing is tried elsewhere."""
    found = _anything(Argument(value))
    found.trials |= {"number": (3, REFUSED), "list": ([value], REFUSED)}
    del found.trials["text"]
    return _changed(found, optional, changes)


def a(value: Any, *, optional: bool = False, **changes: Words) -> Argument:
    """An object of a class, or with the methods of a Protocol."""
    found = _anything(Argument(value))
    found.trials |= {"number": (3, REFUSED), "list": ([value], REFUSED)}
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":  # of whatever numbers
        found.trials["complex"] = (value + 1j, REFUSED)
        found.trials["of text"] = (np.full(value.shape, "abc"), REFUSED)
    return _changed(found, optional, changes)


def function(value: Callable, *, optional: bool = False, **changes: Words) -> Argument:
    """A function."""
    return a(value, optional=optional, **changes)


def several(
    value: list, *, empty: bool = True, optional: bool = False, **changes: Words
) -> Argument:
    """A sequence of objects of one class."""
    found = _anything(Argument(value))
    found.trials |= {
        "number": (3, REFUSED),
        "of numbers": ([*value[:-1], 3.5], REFUSED),
        "of None": ([*value[:-1], None], REFUSED),
        "empty": ([], TAKEN if empty else REFUSED),
    }
    return _changed(found, optional, changes)


def tuples(argument: Argument) -> Argument:
    """The same argument with all arrays as tuples, as the fields of a frozen class are."""
    argument.value = _tuple(argument.value)
    for cases in (argument.trials, argument.lengths):
        for label, (value, expected) in cases.items():
            if isinstance(value, np.ndarray):
                cases[label] = (_tuple(value), expected)
    return argument


def _tuple(array: Any) -> Any:
    listed = array.tolist() if isinstance(array, np.ndarray) else array
    return tuple(map(_tuple, listed)) if isinstance(listed, list) else listed


def _array(array: np.ndarray, shape: tuple, empty: bool) -> Argument:
    """What may be wrong with the type and the shape of an array."""
    lead = shape[:1] == (...,)
    tail = shape[1:] if lead else shape
    found = _anything(Argument(array, axes=tuple(n for n in tail if isinstance(n, str))))
    found.trials |= {
        "complex": (array + 1j, REFUSED),
        "objects": (np.full(array.shape or (1,), object(), dtype=object), REFUSED),
        "ragged": ([[1, 2], [1]], REFUSED),
        "more axes": (array[None], TAKEN if lead else REFUSED),
    }
    if tail or (lead and array.ndim):
        fewer = TAKEN if lead and array.ndim > len(tail) else REFUSED
        found.trials["fewer axes"] = (array[0], fewer)
        found.trials["no axes"] = (array.flat[0], TAKEN if shape == (...,) else REFUSED)
    for axis, length in enumerate(tail, start=array.ndim - len(tail)):
        longer = np.concatenate([array, array.take([-1], axis)], axis)
        others = {"longer": longer, "shorter": array.take(range(longer.shape[axis] - 2), axis)}
        for label, other in others.items():
            if isinstance(length, str):
                found.lengths[f"{label} {length}"] = (other, length)
            else:
                found.trials[f"{label} axis {axis}"] = (other, REFUSED)
    if lead or (tail and isinstance(tail[0], str)):
        if not empty:
            found.trials["empty"] = (array[:0] if array.ndim else array[None][:0], REFUSED)
        elif tail and isinstance(tail[0], str):
            found.lengths["empty"] = (array[:0], tail[0])
    return found


def _anything(argument: Argument) -> Argument:
    """What no argument is, unless its kind says otherwise."""
    argument.trials |= {
        "None": (None, REFUSED),
        "text": ("abc", REFUSED),
        "object": (object(), REFUSED),
        "bytes": (b"abc", REFUSED),
        "scalar array": (np.array(-1.5), EITHER),
        "empty array": (np.empty(0), EITHER),
        "no truth": (np.array([object(), object()]), REFUSED),
    }
    return argument


def _with(array: np.ndarray, value: float) -> np.ndarray:
    """A copy whose last number is another."""
    array = np.array(
        array, dtype=np.result_type(array, float) if isinstance(value, float) else None
    )
    if array.size:
        array.flat[array.size - 1] = value
    return array


def _changed(argument: Argument, optional: bool, changes: dict[str, Words]) -> Argument:
    if optional:
        argument.trials["None"] = (None, TAKEN)
    for happens, labels in changes.items():
        outcome = {"refuses": REFUSED, "takes": TAKEN, "either": EITHER}[happens]
        for label in labels.split(","):
            label = label.strip()
            value, _ = argument.trials.get(label) or argument.lengths.pop(label)
            argument.trials[label] = (value, outcome)
    return argument
