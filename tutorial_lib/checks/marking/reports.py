"""The marks of a class: lines for a terminal, tables for programs, a page for each student."""

import csv
import difflib
import html
import io
import json
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tutorial_lib.checks.framework.check import Result
from tutorial_lib.checks.marking.handed_in import Student
from tutorial_lib.checks.marking.judging import Mark, printable
from tutorial_lib.errors import InputError, one_line
from tutorial_lib.files import make_folder, write_text
from tutorial_lib.reading.regular import read_text

_SHOWN, _PRINTED = 500, 200  # characters of a message, and of what an answer printed, on a line
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_COLUMNS = ("student", "folder", "exercise", "status", "points", "of", "message", "printed")
OTHERS = "others"
"""The name, in a file of weights, of all exercises that it does not name."""
_UNKNOWN = "unknown file"
_STYLE = "body{font:16px sans-serif;max-width:50em;margin:auto}pre{white-space:pre-wrap}"


@dataclass(frozen=True)
class Marked:
    """A student with marks for all exercises, and the points of each."""

    student: Student
    marks: Sequence[Mark]
    weights: Mapping[str, float]

    @property
    def name(self) -> str:
        """Of the student."""
        return one_line(self.student.name)

    @property
    def points(self) -> float:
        """Of what passed."""
        return sum(self.points_of(mark) for mark in self.marks)

    def points_of(self, mark: Mark) -> float:
        """What an exercise brings."""
        return self.weights[mark.exercise] if mark.status == "passed" else 0.0

    def summary(self) -> str:
        """One line on all exercises."""
        counts = Counter(mark.status for mark in self.marks)
        others = [
            f"{counts[s]} {s}" for s in ("failed", "not attempted", "not handed in") if counts[s]
        ]
        words = ", ".join([f"{counts['passed']} of {len(self.marks)} pass", *others])
        if len({*self.weights.values()}) > 1 or 1.0 not in self.weights.values():
            words += f"; {self.points:g} of {sum(self.weights.values()):g} points"
        return words


def lines_of(one: Marked) -> str:
    """What the terminal shows of a student: a line for each exercise and each unknown file."""
    lines = [f"{one.name}: {one.summary()}"]
    if one.student.problem:
        lines.append(f"  {one_line(str(one.student.folder))}: {one.student.problem}")
    for mark in one.marks:
        said = f". {one_line(mark.message, _SHOWN)}" if mark.status == "failed" else ""
        lines.append(f"  {mark.exercise}: {mark.status}{said}")
        if mark.printed:
            lines.append(f"    it printed: {one_line(mark.printed, _PRINTED)}")
    lines += [f"  {_UNKNOWN} {one_line(n)}: {words}" for n, words in one.student.unknown.items()]
    return "\n".join(lines)


def write_csv(path: Path, marked: Sequence[Marked]) -> None:
    """A row for each exercise and each unknown file of each student, for a spreadsheet.

    Text that a spreadsheet would take for a formula begins with an apostrophe.
    """
    text = io.StringIO(newline="")
    table = csv.writer(text)
    table.writerow(_COLUMNS)
    for one in marked:
        who = one.name, one_line(str(one.student.folder))
        for m in one.marks:
            points = one.points_of(m), one.weights[m.exercise]
            table.writerow(_cells(*who, m.exercise, m.status, *points, m.message, m.printed))
        for name, words in one.student.unknown.items():
            table.writerow(_cells(*who, one_line(name), _UNKNOWN, 0, 0, words, ""))
    write_text(path, text.getvalue())


def _cells(*values: str | float) -> list[str | float]:
    return [f"'{v}" if isinstance(v, str) and v.startswith(_FORMULA) else v for v in values]


def write_json(path: Path, marked: Sequence[Marked]) -> None:
    """All marks of all students."""
    write_text(path, json.dumps([_document(one) for one in marked], indent=1) + "\n")


def _document(one: Marked) -> dict[str, object]:
    return {
        "student": one.name,
        "folder": one_line(str(one.student.folder)),
        "problem": one.student.problem,
        "points": one.points,
        "of": sum(one.weights.values()),
        "exercises": [
            {
                "exercise": m.exercise,
                "status": m.status,
                "points": one.points_of(m),
                "of": one.weights[m.exercise],
                "message": m.message,
                "printed": m.printed,
            }
            for m in one.marks
        ],
        "unknown_files": {one_line(n): words for n, words in one.student.unknown.items()},
    }


def write_pages(folder: Path, marked: Sequence[Marked]) -> list[Path]:
    """A page of HTML for each student, with the pictures of the checks."""
    make_folder(folder)
    taken = Counter[str]()
    written = []
    for one in marked:
        stem = re.sub(r"[^\w-]+", "-", one.name).strip("-")[:80] or "student"
        taken[stem.lower()] += 1
        number = taken[stem.lower()]
        file = folder / (f"{stem}.html" if number == 1 else f"{stem}-{number}.html")
        write_text(file, _page(one))
        written.append(file)
    return written


def _page(one: Marked) -> str:
    name = html.escape(one.name)
    parts = [f"<h1>{name}</h1>", f"<p>{html.escape(one.summary())}</p>"]
    for m in one.marks:
        if m.status == "not handed in":
            parts.append(f"<p>{m.exercise}: not handed in</p>")
            continue
        parts.append(Result(m.exercise, m.status, m.message, m.picture)._repr_html_())
        if m.printed:
            parts.append(f"<p>It printed:</p><pre>{html.escape(m.printed)}</pre>")
    parts += [
        f"<p>{html.escape(one_line(n))}: {html.escape(printable(words))}</p>"
        for n, words in one.student.unknown.items()
    ]
    head = f'<!DOCTYPE html><meta charset="utf-8"><title>{name}</title><style>{_STYLE}</style>'
    return head + "\n".join(parts) + "\n"


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
