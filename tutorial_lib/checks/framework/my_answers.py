"""Answers that passed, kept in files of their own: ``my_answers/NN_name.py``.

A file holds one exercise: the imports, the constants and the student's own functions that it needs,
then the function itself. An answer that is replaced by another moves to ``my_answers/older``.
"""

import ast
import importlib.util
import inspect
import os
import re
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import numpy as np

from tutorial_lib.checks.framework import guard
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
        body = _text_of(function, name)
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
    except (OSError, TypeError, ValueError, SyntaxError) as error:
        return f"It could not be saved in my_answers ({error})."
    return f"It is saved in my_answers/{target.name}."


def load(notebook: str, name: str) -> Function | None:
    """The saved answer, or None if there is none.

    Raises:
        InputError: when the file does not run or defines no such function.
    """
    target = path(notebook, name)
    if folder() is None or not target.exists():
        return None
    with _staying():
        return read(target, name)


def read(file: Path, name: str) -> Function:
    """The function `name` of an answer's file, whose code is run.

    Raises:
        InputError: when it does not run or defines no such function.
    """
    spec = importlib.util.spec_from_file_location(f"my_answers_{file.stem}", file)
    words = "mend it, or delete it and solve the exercise again"
    if spec is None or spec.loader is None:
        raise InputError(f"{file} is no Python file; its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        function = vars(module).get(name)
    except (KeyboardInterrupt, guard.TimeUp):
        raise
    except BaseException as error:
        raise InputError(f"{file} does not run ({words_of(error)}); {words}") from error
    if not callable(function):
        raise InputError(f"{file} defines no function {name}; {words}")
    return function


@contextmanager
def _staying() -> Iterator[None]:
    """Turn `os._exit`, which would end the notebook, into an error; a forked child may end."""
    leave, process = os._exit, os.getpid()

    def stay(status: int) -> NoReturn:
        if os.getpid() != process:
            leave(status)
        raise SystemExit(status)

    os._exit = stay
    try:
        yield
    finally:
        os._exit = leave


def _text_of(function: Function, name: str) -> str:
    """The text of a file that defines a function by a name, with all that it needs.

    Raises:
        TypeError: when it needs a value that is no import, function or plain constant.
        OSError: when Python does not know the function's text.
    """
    needed = _Needed()
    needed.add(function)
    needed.call(function, name)
    first = sorted(needed.imports, key=lambda line: (line.startswith("from"), line))
    constants = [f"{name} = {value}" for name, value in needed.constants.items()]
    lines = "\n\n".join(filter(None, ["\n".join(first), "\n".join(constants)]))
    texts = [lines, *needed.functions.values()]
    return "\n\n\n".join(filter(None, texts)) + "\n"


class _Needed:
    """What functions need, as text: imports, constants, and functions in the order of their use."""

    def __init__(self) -> None:
        self.imports: set[str] = set()
        self.constants: dict[str, str] = {}
        self.functions: dict[str, str] = {}
        self._names: dict[str, Any] = {}

    def add(self, function: Function) -> None:
        """Add a function, after what it needs."""
        if not inspect.isfunction(function):
            raise TypeError("write it with def")
        if function.__closure__:
            around = ", ".join(function.__code__.co_freevars)
            raise TypeError(f"it uses {around} of the function around it; pass it in")
        text = textwrap.dedent(inspect.getsource(function)).rstrip()
        name = _definition(text).name
        self._take(name, function)
        self.functions[name] = text  # it may call itself
        for used in sorted(global_names(function.__code__) | _names_of_signature(text)):
            if used in function.__globals__:
                self._add_value(used, function.__globals__[used], function)
        self.functions[name] = self.functions.pop(name)

    def call(self, function: Function, name: str) -> None:
        """Give a function that was added another name."""
        if self._names.get(name) is not function:
            self._take(name, function)
            defined = _definition(textwrap.dedent(inspect.getsource(function))).name
            self.functions[name] = f"{name} = {defined}"

    def _take(self, name: str, value: Any) -> None:  # noqa: ANN401
        """Remember what a name stands for, which is one thing in a file."""
        if self._names.setdefault(name, value) is not value:
            raise TypeError(f"two different things in it are called {name}; rename one")

    def _add_value(self, name: str, value: Any, user: Function) -> None:  # noqa: ANN401 - anything
        own = inspect.isfunction(value) and value.__code__.co_filename.startswith(_cells(user))
        if own:
            if all(known is not value for known in self._names.values()):
                self.add(value)
            self.call(value, name)
            return
        self._take(name, value)
        if isinstance(value, ModuleType):
            named = "" if value.__name__ == name else f" as {name}"
            self.imports.add(f"import {value.__name__}{named}")
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
    function = _definition(text)
    parts = [function.args, *function.decorator_list, function.returns]
    nodes = [node for part in parts if part for node in ast.walk(part)]
    return {node.id for node in nodes if isinstance(node, ast.Name)}


def _definition(text: str) -> ast.FunctionDef:
    """A function's text, parsed."""
    function = ast.parse(text).body[0]
    if not isinstance(function, ast.FunctionDef):  # a lambda, within a longer line
        raise TypeError("write it with def")
    return function
