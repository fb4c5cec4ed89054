"""Points of exercises, from a teacher's file."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from pathlib import Path

from tutorial_lib.errors import InputError
from tutorial_lib.reading.regular import read_text

OTHERS = "others"
"""The name, in a file of weights, of all exercises that it does not name."""


def read_weights(file: Path, exercises: Sequence[str]) -> dict[str, float]:
    """Points by exercise; those that the file does not name have 1.

    A line has an exercise's name, as in ``01_to_local`` or ``to_local``, and its points. ``others``
    stands for all that have no line; what follows a ``#`` is not read.

    Raises:
        InputError: when a line is none, names no exercise, or names one again.
    """
    names = {name[3:]: name for name in exercises} | {name: name for name in exercises}
    names[OTHERS] = OTHERS
    points: dict[str, float] = {}
    for number, line in enumerate(read_text(file).removeprefix("\ufeff").splitlines(), 1):
        words = line.partition("#")[0].replace("=", " ").replace(":", " ").split()
        if not words:
            continue
        where = f"{file}:{number}"
        if len(words) != 2:
            raise InputError(f"{where}: give a name and its points, as in: to_local 2")
        if words[0] not in names:
            near = difflib.get_close_matches(words[0], names, 1)
            meant = f"; did you mean {near[0]}?" if near else f"; give one as in {exercises[0]}"
            raise InputError(f"{where}: there is no exercise {words[0]}{meant}")
        if names[words[0]] in points:
            raise InputError(f"{where}: {words[0]} has points already; give each once")
        points[names[words[0]]] = _points(words[1], where)
    rest = points.pop(OTHERS, 1.0)
    return {name: points.get(name, rest) for name in exercises}


def _points(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 1e6:
        raise InputError(f"{where}: {text!r} are no points; give a number from 0 to 1000000")
    return value
