"""What a student committed to and scored, kept beside the answers in ``my_answers/record.json``.

By notebook it holds predictions by name, and the rows of a league table; and the robot's name,
which notebook 00 asks for. Nothing of it is marked. Functions here raise `InputError` when the file
is damaged or cannot be written.
"""

import json
from datetime import datetime
from pathlib import Path
from typing import Any

from tutorial_lib.checks.framework import my_answers
from tutorial_lib.errors import InputError
from tutorial_lib.files import write_text
from tutorial_lib.reading.documents import read_json

FILE = "record.json"
_FIRST = "00"
_ADVICE = "delete it; your answers are in files of their own"


def predictions(notebook: str) -> dict[str, dict[str, str]]:
    """By name, the "choice" that came first, what is "right", and "on" which day.

    Args:
        notebook: its number, as in "05".
    """
    made = _of(_load(), notebook, "predictions", {})
    return {name: one for name, one in made.items() if isinstance(one, dict)}


def scores(notebook: str) -> list[list[Any]]:
    """The rows of a notebook's league table, in the order in which they were entered."""
    return _of(_load(), notebook, "scores", [])


def robot() -> str:
    """The name that the robot was given; empty before."""
    return _of(_load(), _FIRST, "robot", "")


def keep_prediction(notebook: str, name: str, choice: str, right: str) -> None:
    """Keep the first choice of a prediction; later ones change nothing."""
    known, today = _load(), datetime.now().strftime("%Y-%m-%d")
    made = _of(known, notebook, "predictions", {})
    made.setdefault(name, {"choice": choice, "right": right, "on": today})
    _save(known, notebook, "predictions", made)


def keep_score(notebook: str, row: list[Any]) -> None:
    """Keep a row of a league table, once."""
    known = _load()
    rows = _of(known, notebook, "scores", [])
    if row not in rows:
        _save(known, notebook, "scores", [*rows, row])


def keep_robot(name: str) -> None:
    """Keep the robot's name, in place of an earlier one."""
    _save(_load(), _FIRST, "robot", name)


def _path() -> Path | None:
    folder = my_answers.folder()
    return None if folder is None else folder / FILE


def _load() -> dict[str, Any]:
    path = _path()
    known = read_json(path, _ADVICE) if path is not None and path.is_file() else {}
    if not isinstance(known, dict):
        raise InputError(f"{path}: damaged; {_ADVICE}")
    return known


def _of(known: dict[str, Any], notebook: str, kind: str, none: Any) -> Any:  # noqa: ANN401
    """A notebook's part of one kind, or `none`."""
    part = known.get(notebook, {})
    found = part.get(kind, none) if isinstance(part, dict) else None
    if not isinstance(found, type(none)):
        raise InputError(f"{_path()}: damaged; {_ADVICE}")
    return found


def _save(known: dict[str, Any], notebook: str, kind: str, part: Any) -> None:  # noqa: ANN401
    path = _path()
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        changed = known | {notebook: known.get(notebook, {}) | {kind: part}}
        write_text(path, json.dumps(changed, indent=1, sort_keys=True) + "\n")
