"""Marks the saved answers that students handed in; a teacher's command.

It runs the students' code, with the limits of the checks and no others: mark on a machine, or in a
container, where that may happen.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from tutorial_lib.checks.framework import my_answers
from tutorial_lib.checks.framework.check import Check, Result
from tutorial_lib.errors import InputError


def all_checks() -> list[Check]:
    """Every check of the course, by notebook."""
    folder = Path(__file__).resolve().parent
    found = []
    for package in sorted(folder.glob("nb[0-9][0-9]")):
        module = import_module(f"tutorial_lib.checks.{package.name}")
        found += [value for value in vars(module).values() if isinstance(value, Check)]
    return found


def mark(folder: Path) -> Iterator[Result]:
    """The result of every answer in a student's folder `my_answers`.

    Raises:
        InputError: when there is no such folder, or no answer in it.
    """
    judged = False
    for check in all_checks():
        file = folder / f"{check.notebook}_{check.name}.py"
        if file.is_file():
            judged = True
            yield _result(check, file)
    if not judged:
        raise InputError(f"{folder}: no answers NN_name.py; give a student's folder my_answers")


def _result(check: Check, file: Path) -> Result:
    try:
        return check(my_answers.read(file, check.name))
    except InputError as error:
        return Result(check.name, "failed", str(error))
