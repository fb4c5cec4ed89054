"""Walks through the doors of the library with arguments that are wrong in one place.

A table (one module for each package) has for each public function, class and method a call that
works; see `arguments` for what is then put in the place of each argument. A call may end in three
ways: an `InputError` that names the argument, a right value where the table says that the argument
is fine, or wrong.

    python -m tests.doors.walk world driving

prints what is wrong in these packages, and how many calls ended how.
"""

import dataclasses
import enum
import importlib
import inspect
import re
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.doors.arguments import REFUSED, TAKEN, Argument
from tutorial_lib.errors import InputError

FOLDER = Path(__file__).parent
TABLES = sorted(
    file.stem
    for file in FOLDER.glob("*.py")
    if file.stem not in ("__init__", "arguments", "walk", "test_doors")
)


def finite(value: Any) -> bool:
    """Whether no number in a result is NaN or infinite."""
    return _all(value, np.isfinite)


def numbers(value: Any) -> bool:
    """Whether no number in a result is NaN; infinities may stand among them."""
    return not _all(value, np.isnan, any)


def anything(value: Any) -> bool:
    """Of a result that cannot be judged here."""
    return True


@dataclass
class Call:
    """A call that works.

    Attributes:
        function: what is called, by keywords.
        arguments: by name.
        right: whether a result is right.
    """

    function: Callable[..., Any]
    arguments: dict[str, Argument]
    right: Callable[[Any], bool] = finite


def call(function: Callable[..., Any], right: Callable[[Any], bool] = finite, /, **arguments):
    """An entry of a table; an argument that is no `Argument` is given as it is."""
    return Call(
        function,
        {n: a if isinstance(a, Argument) else Argument(a) for n, a in arguments.items()},
        right,
    )


@dataclass
class Tally:
    """How the calls of a door ended; `wrong` says so in words."""

    ends: Counter = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)


def walk(make: Callable[[], Call]) -> Tally:
    """Call a function with each argument in turn replaced by each value that is wrong for it.

    `make` is called before each, since a call may change what it is given.
    """
    tally = Tally()
    sound = make()
    _try(tally, "as it is", "", sound, sound.arguments, TAKEN)
    for name, argument in sound.arguments.items():
        for label in (*argument.trials, *argument.lengths):
            fresh = make()
            value, expected = _trial(fresh, name, label)
            hostile = fresh.arguments | {name: Argument(value)}
            _try(tally, f"{name} {label}", name, fresh, hostile, expected)
    return tally


def _trial(made: Call, name: str, label: str) -> tuple[Any, str]:
    argument = made.arguments[name]
    if label in argument.trials:
        return argument.trials[label]
    value, axis = argument.lengths[label]
    others = [o.axes for n, o in made.arguments.items() if n != name]
    return value, REFUSED if any(axis in axes for axes in others) else TAKEN


def _try(
    tally: Tally, label: str, name: str, made: Call, arguments: dict[str, Argument], expected: str
) -> None:
    """One call."""
    tally.ends["calls"] += 1
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            result = made.function(**{n: a.value for n, a in arguments.items()})
    except InputError as error:
        if expected == TAKEN:
            _fault(tally, "refused", f"{label}: is fine, and was refused: {error}")
        elif not re.search(rf"\b{re.escape(name)}\b", str(error)):
            _fault(tally, "unnamed", f"{label}: {name} is not named: {error}")
    except Exception as error:
        words = str(error).split("\n")[0][:80]
        _fault(tally, "deep", f"{label}: {type(error).__name__} deep inside: {words}")
    else:
        if expected == REFUSED:
            _fault(tally, "silent", f"{label}: not refused, gave {_shown(result)}")
        elif not made.right(result):
            _fault(tally, "silent", f"{label}: gave {_shown(result)}")


def _fault(tally: Tally, end: str, words: str) -> None:
    tally.ends[end] += 1
    tally.wrong.append(words)


def _shown(result: Any) -> str:
    return re.sub(r"\s+", " ", repr(result))[:60]


def _all(value: Any, test: Callable, combine: Callable = all) -> bool:
    """Whether a test is true of all (or any) floats in a result."""
    return combine(bool(combine(np.ravel(test(part)))) for part in _floats(value) if part.size)


def _floats(value: Any) -> Iterator[np.ndarray]:
    if isinstance(value, (float, complex, np.ndarray, np.generic)):
        array = np.asarray(value)
        if array.dtype.kind in "fc":
            yield array
    elif isinstance(value, (tuple, list, set)):
        for one in value:
            yield from _floats(one)
    elif isinstance(value, dict):
        yield from _floats(list(value.values()))
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield from _floats([getattr(value, f.name, None) for f in dataclasses.fields(value)])


def doors(table: str) -> dict[str, Callable[[], Call]]:
    """The calls of a table, by name."""
    return importlib.import_module(f"tests.doors.{table}").DOORS


def parts(name: str, value: object) -> Iterator[str]:
    """The doors of an export: a function, or a class with its public methods.

    Constants, enumerations, Protocols and functions without an argument have none.
    """
    if not inspect.isclass(value):
        if callable(value) and _has_arguments(value):
            yield name
        return
    if issubclass(value, (enum.Enum, BaseException)) or getattr(value, "_is_protocol", False):
        return
    if _has_arguments(value):
        yield name
    for method in dir(value):
        found = inspect.getattr_static(value, method)
        function = getattr(found, "__func__", found)
        ours = getattr(function, "__module__", "") or ""
        if not method.startswith("_") and inspect.isfunction(function) and "tutorial_lib" in ours:
            bound = 0 if isinstance(found, staticmethod) else 1
            if _has_arguments(function, bound):
                yield f"{name}.{method}"


def _has_arguments(function: Callable, bound: int = 0) -> bool:
    try:
        return len(inspect.signature(function).parameters) > bound
    except (TypeError, ValueError):
        return False


def main(tables: list[str]) -> None:
    total = Counter()
    for table in tables or TABLES:
        ends = Counter()
        for name, make in doors(table).items():
            tally = walk(make)
            ends += tally.ends
            for words in tally.wrong:
                print(f"{table}: {name}: {words}", flush=True)
        print(f"{table}: {dict(ends)}", file=sys.stderr)
        total += ends
    print(f"in all: {dict(total)}", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
