"""Answers that passed, kept in files of their own: ``my_answers/NN_name.py``.

A file holds one exercise: the imports, the constants and the student's own functions that it needs,
then the function itself. An answer that is replaced by another moves to ``my_answers/older``.
"""

from __future__ import annotations

import ast
import importlib.util
import inspect
import os
import re
import textwrap
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.global_names import global_names
from tutorial_lib.course import find_course
from tutorial_lib.errors import InputError, words_of
from tutorial_lib.files import write_text
from tutorial_lib.reading.regular import read_text

FOLDER = "TUTORIAL_ANSWERS"
"""The environment variable with the folder; set but empty, nothing is saved or found."""
_VERSION = re.compile(r"^# version (\d+)")
_PLAIN = (bool, int, float, str, tuple)
_LARGEST = 1_000  # numbers of an array that is written to a file

Function = Callable[..., Any]


def folder() -> Path | None:
    """Where answers are kept; None where they are not."""
    named = os.environ.get(FOLDER)
    if named is None:
        return (find_course() or Path.cwd()) / "my_answers"
    return Path(named) if named else None


def path(notebook: str, name: str) -> Path:
    """The file of an answer, in `folder` or, if nothing is kept, without one.

    Args:
        notebook: its number, as in "02".
        name: of the exercise.
    """
    return (folder() or Path()) / f"{notebook}_{name}.py"


def save(notebook: str, name: str, function: Function) -> str:
    """Keep an answer that passed, and say where; empty if answers are not kept.

    An error of the file system or a function whose text is not to be had is reported in the
    returned words: neither may take the result of a check from a student.
    """
    if folder() is None:
        return ""
    target = path(notebook, name)
    try:
        body = _text_of(function)
        kept = read_text(target) if target.exists() else ""
        if kept.partition("\n\n")[2] == body:
            return f"It is saved in my_answers/{target.name}."
        version = 1
        if kept:
            found = _VERSION.search(kept)
            version = int(found[1]) + 1 if found else 2
            older = target.parent / "older" / f"{target.stem}_v{version - 1}.py"
            older.parent.mkdir(parents=True, exist_ok=True)
            write_text(older, kept)
        target.parent.mkdir(parents=True, exist_ok=True)
        now = datetime.now().strftime("%Y-%m-%d %H:%M")
        heading = f"# version {version} of {name}, notebook {notebook}: passed its check on {now}"
        write_text(target, f"{heading}\n\n{body}")
    except (OSError, TypeError, ValueError) as error:
        return f"It could not be saved in my_answers ({error})."
    return f"It is saved in my_answers/{target.name}."


def load(notebook: str, name: str) -> Function | None:
    """The saved answer, or None if there is none.

    Raises:
        InputError: when the file does not run or defines no such function.
    """
    target = path(notebook, name)
    return read(target, name) if folder() is not None and target.exists() else None


def read(file: Path, name: str) -> Function:
    """The function `name` of an answer's file, whose code is run.

    Raises:
        InputError: when it does not run or defines no such function.
    """
    spec = importlib.util.spec_from_file_location(f"my_answers_{file.stem}", file)
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        return getattr(module, name)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        words = f"{file} does not run ({words_of(error)})"
        raise InputError(f"{words}; mend it, or delete it and solve the exercise again") from error


def _text_of(function: Function) -> str:
    """The text of a file that defines a function, with all that it needs.

    Raises:
        TypeError: when it needs a value that is no import, function or plain constant.
        OSError: when Python does not know the function's text.
    """
    needed = _Needed()
    needed.add(function)
    first = sorted(needed.imports, key=lambda line: (line.startswith("from"), line))
    constants = [f"{name} = {value}" for name, value in needed.constants.items()]
    lines = "\n\n".join(filter(None, ["\n".join(first), "\n".join(constants)]))
    return "\n\n\n".join(filter(None, [lines, *needed.functions.values()])) + "\n"


class _Needed:
    """What functions need, as text: imports, constants, and functions in the order of their use."""

    def __init__(self) -> None:
        self.imports: set[str] = set()
        self.constants: dict[str, str] = {}
        self.functions: dict[str, str] = {}

    def add(self, function: Function) -> None:
        """Add a function, after what it needs."""
        text = textwrap.dedent(inspect.getsource(function)).rstrip()
        self.functions[function.__name__] = text  # it may call itself
        for name in sorted(global_names(function.__code__) | _names_of_signature(text)):
            if name in function.__globals__:
                self._add_value(name, function.__globals__[name], function)
        self.functions[function.__name__] = self.functions.pop(function.__name__)

    def _add_value(self, name: str, value: Any, user: Function) -> None:  # noqa: ANN401 - anything
        own = inspect.isfunction(value) and value.__code__.co_filename.startswith(_cells(user))
        if isinstance(value, ModuleType):
            named = "" if value.__name__ == name else f" as {name}"
            self.imports.add(f"import {value.__name__}{named}")
        elif own and value.__name__ == name:
            if name not in self.functions:
                self.add(value)
        elif isinstance(value, _PLAIN) or value is None:
            self.constants[name] = repr(value)
        elif isinstance(value, np.ndarray) and value.size <= _LARGEST:
            self.imports.add("import numpy as np")
            self.constants[name] = f"np.array({value.tolist()!r})"
        elif getattr(value, "__module__", "__main__") != "__main__" and hasattr(
            value, "__qualname__"
        ):
            named = "" if value.__qualname__ == name else f" as {name}"
            self.imports.add(f"from {value.__module__} import {value.__qualname__}{named}")
        else:
            raise TypeError(f"it uses {name}, which cannot be written to a file; pass it in")


def _cells(function: Function) -> str:
    """What the file names of functions of the same notebook begin with."""
    return str(Path(function.__code__.co_filename).parent)


def _names_of_signature(text: str) -> set[str]:
    """The names that stand in a function's defaults, annotations and decorators."""
    function = ast.parse(text).body[0]
    if not isinstance(function, ast.FunctionDef):  # a lambda, within a longer line
        raise TypeError("write it with def")
    parts = [
        function.args,
        *function.decorator_list,
        *([function.returns] if function.returns else []),
    ]
    nodes = [node for part in parts for node in ast.walk(part)]
    return {node.id for node in nodes if isinstance(node, ast.Name)}
