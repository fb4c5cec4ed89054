"""Mutants of every exercise's solution, and those that a check lets pass.

A mutant that is no mistake stands with the reason in ``tests/harmless_mutants/NN_name.json``:
``{exercise: {"old line -> new line": reason}}``.
"""

import ast
import builtins
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from tutorial_lib.builder.mutation import changes
from tutorial_lib.builder.notebooks import BEGIN, END, cells_of
from tutorial_lib.checks.framework.check import Check
from tutorial_lib.checks.framework.global_names import global_names
from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_json


@dataclass(frozen=True)
class Exercise:
    """An exercise of a notebook.

    Attributes:
        name: of its function.
        code: of its cell, solution included.
        lines: the numbers of the solution's lines, from 1.
        given: the code of earlier cells that it needs.
        check: that judges it.
    """

    name: str
    code: str
    lines: range
    given: str
    check: Check


@dataclass(frozen=True)
class Survivor:
    """A mutant that passed its check.

    Attributes:
        exercise: whose solution was changed.
        change: ``old line -> new line``.
        reason: why it is no mistake; empty if nobody gave one.
    """

    exercise: str
    change: str
    reason: str


def exercises(source: Path) -> list[Exercise]:
    """The exercises of a source, ``solutions/NN_name.py``, in its order."""
    checks = import_module(f"tutorial_lib.checks.nb{source.stem[:2]}")
    found, earlier = [], list[str]()
    for cell in cells_of(source.read_text(encoding="utf-8")).cells:
        if cell.cell_type != "code":
            continue
        if name := cell.metadata.get("exercise"):
            rows = [row.strip() for row in cell.source.splitlines()]
            lines = range(rows.index(BEGIN) + 2, rows.index(END) + 1)
            given, check = _needed(cell.source, earlier), getattr(checks, f"check_{name}")
            found.append(Exercise(name, cell.source, lines, given, check))
        earlier.append(cell.source)
    return found


def mutants(exercise: Exercise) -> Iterator[tuple[str, Any]]:
    """Each change to the solution, and the changed function."""
    given: dict[str, Any] = {}
    exec(compile(exercise.given, "<given>", "exec"), given)
    for code, change in changes(exercise.code, exercise.lines):
        names = dict(given)
        exec(compile(code, "<mutant>", "exec"), names)
        yield change, names[exercise.name]


def survivors(source: Path, known: Path) -> Iterator[tuple[Exercise, int, list[Survivor]]]:
    """For each exercise of a source, the number of mutants and those that pass the check.

    Raises:
        InputError: when `known`, the file with the harmless ones, names a mutant that does not
            exist or is rejected.
    """
    reasons = harmless(known)
    for exercise in exercises(source):
        tried, passed = 0, []
        listed = reasons.get(exercise.name, {})
        for change, function in mutants(exercise):
            tried += 1
            if exercise.check(function).status == "passed":
                passed.append(Survivor(exercise.name, change, listed.get(change, "")))
        stale = set(listed) - {survivor.change for survivor in passed}
        if stale:
            raise InputError(f"{known.name}, {exercise.name}: no such survivor: {sorted(stale)}")
        yield exercise, tried, passed


def harmless(known: Path) -> dict[str, dict[str, str]]:
    """By exercise and change, why a mutant is no mistake; empty without the file."""
    return read_json(known) if known.is_file() else {}


def _needed(code: str, earlier: list[str]) -> str:
    """The statements of earlier cells, in their order, that some code needs."""
    statements = [node for cell in earlier for node in ast.parse(cell).body]
    wanted, kept = _read(ast.parse(code)), set()
    for i in reversed(range(len(statements))):
        if _bound(statements[i]) & wanted:
            kept.add(i)
            wanted |= _read(ast.Module([statements[i]], []))
    return "\n".join(ast.unparse(statements[i]) for i in sorted(kept))


def _bound(statement: ast.stmt) -> set[str]:
    """The names that a statement of a notebook binds."""
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return {alias.asname or alias.name.split(".")[0] for alias in statement.names}
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    if isinstance(statement, ast.Assign | ast.AnnAssign) and ".use(" not in ast.unparse(statement):
        return {
            node.id
            for node in ast.walk(statement)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
    return set()


def _read(tree: ast.Module) -> set[str]:
    """The names of a notebook that code reads."""
    return global_names(compile(tree, "<notebook>", "exec")) - set(dir(builtins))
