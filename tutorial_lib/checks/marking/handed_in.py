"""What students handed in: which folders, and which files of them are answers to what."""

import difflib
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tutorial_lib.checks.framework import record
from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_TEXT
from tutorial_lib.reading.regular import read_bytes

_ANSWERS = "my_answers"
_FILE = re.compile(r"\d\d_\w+\.py")
_OURS = ("older", "__pycache__", record.FILE)
_DEEPEST = 4  # folders from a class's to a student's answers


@dataclass(frozen=True)
class Student:
    """What a student handed in.

    Attributes:
        name: of the student, by the folder.
        folder: with the answers.
        problem: why there is nothing to judge; empty if there is.
        unknown: files that are no answer to any exercise, each with what to do.
        texts: by exercise, as in ``01_to_local``: what is in its file, or why it cannot be read.
    """

    name: str
    folder: Path
    problem: str = ""
    unknown: dict[str, str] = field(default_factory=dict)
    texts: dict[str, bytes | InputError] = field(default_factory=dict)


def students_in(folders: Sequence[Path], exercises: Sequence[str]) -> list[Student]:
    """What was handed in: of each folder, which may be a student's or a whole class's.

    Names that two students share are followed by their folders.
    """
    places = [place for folder in folders for place in _places(folder)]
    counts = Counter(name for name, _ in places)
    return [
        _student(name if counts[name] == 1 else f"{name} ({place})", place, exercises)
        for name, place in places
    ]


def _places(folder: Path, depth: int = 0) -> list[tuple[str, Path]]:
    """Names of students and their folders in a folder; at the top also one without answers."""
    name = _name(folder)
    if (folder / _ANSWERS).is_dir():
        return [(name, folder / _ANSWERS)]
    below = _folders(folder)
    if folder.name == _ANSWERS or depth == _DEEPEST or _has_answers(folder) or not below:
        return [(name, folder)]
    inner = [(place, _places(place, depth + 1)) for place in below]
    if depth:  # a folder between a student's and the answers, as of an archive
        return next(
            (found for _, found in inner if any(_has_answers(p) for _, p in found)), inner[0][1]
        )
    return [
        (_name(place) if len(found) == 1 else name, there)
        for place, found in inner
        for name, there in found
    ]


def _name(folder: Path) -> str:
    whole = folder.resolve()
    return whole.parent.name if whole.name == _ANSWERS else whole.name


def _folders(folder: Path) -> list[Path]:
    others = [p for p in _inside(folder) if not p.name.startswith((".", *_OURS))]
    return [p for p in others if p.is_dir() and not _FILE.fullmatch(p.name)]


def _has_answers(folder: Path) -> bool:
    return any(path.suffix == ".py" for path in _inside(folder))


def _inside(folder: Path) -> list[Path]:
    """What lies in a folder; nothing where it cannot be read."""
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _student(name: str, folder: Path, exercises: Sequence[str]) -> Student:
    try:
        names = sorted(path.name for path in folder.iterdir())
    except OSError as error:
        return Student(name, folder, f"cannot be read ({error.strerror})")
    texts = {
        exercise: _text(folder / f"{exercise}.py")
        for exercise in exercises
        if f"{exercise}.py" in names
    }
    known = {f"{exercise}.py" for exercise in exercises}
    strange = [n for n in names if n not in known and not n.startswith(".") and n not in _OURS]
    unknown = {n: _advice(n, known - set(names), known) for n in strange}
    problem = "" if texts else "no answer of the course is in it"
    return Student(name, folder, problem, unknown, texts)


def _advice(name: str, missing: set[str], known: set[str]) -> str:
    """What to do about a file that is no answer."""
    plain = re.sub(r"[ _-]*(\(\d+\)|copy|kopie)", "", name.lower())
    near = difflib.get_close_matches(plain, sorted(missing or known), 1, 0.8)
    if not near:
        return "it is no exercise of the course and was not judged"
    return f"it was not judged; rename it {near[0]} if it is that answer"


def _text(file: Path) -> bytes | InputError:
    if file.is_symlink():
        return InputError(f"{file.name} is a symbolic link; hand in the file itself")
    try:
        return read_bytes(file, MAX_TEXT, "hand in the file that the notebook saved")
    except InputError as error:
        return InputError(str(error).replace(str(file), file.name))
