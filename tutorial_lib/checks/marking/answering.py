"""The process of an answer: it runs the student's file, and calls its function when asked to."""

import dataclasses
import io
import os
import pickle
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from inspect import signature
from multiprocessing.connection import Client, Connection
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.checks.framework.explanation import place
from tutorial_lib.checks.framework.my_answers import read
from tutorial_lib.checks.marking.limits import limit_process
from tutorial_lib.checks.marking.wire import (
    MOST,
    Distant,
    FromCheck,
    error_of,
    error_parts,
    to_check,
)


class _Answer:
    """The student's function, and the way to its check."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.function: Callable[..., Any]  # once it is loaded

    def serve(self) -> None:
        """Do what the check asks for, until it asks no more."""
        printing = sys.stdout
        while True:
            what, arguments, named = FromCheck(self.connection.recv_bytes(), self.ask).load()
            try:
                before = _bytes_of(arguments)
                result = getattr(self, what)(*arguments, **named)
                same = before is not None and before == _bytes_of(arguments)
                changed = None if same else to_check([_state(value) for value in arguments])
                message = to_check(("returned", result, changed), arguments)
                if len(message) > MOST:
                    raise ValueError(f"more than {MOST / 1e6:.0f} MB came back; return less")
            except BaseException as error:
                key = getattr(error, "key", None)
                message = to_check(("raised", *error_parts(error), place(error), key))
            with suppress(ValueError, OSError):  # the answer may have closed it
                printing.flush()  # it is killed once it is judged
            self.connection.send_bytes(message)

    def load(self, file: str, text: bytes, name: str) -> list[str]:
        """Run the student's file, whose lines can then be shown; the names of its arguments."""
        Path(file).write_bytes(text)
        self.function = read(Path(file), name)
        with suppress(TypeError, ValueError):
            return list(signature(self.function).parameters)
        return []

    def call(self, *arguments: Any, **named: Any) -> Any:  # noqa: ANN401
        """Call the student's function."""
        return self.function(*arguments, **named)

    def run(self, where: str, *arguments: Any) -> Any:  # noqa: ANN401
        """Call a function of the library with the student's function."""
        module, _, name = where.partition(":")
        return getattr(import_module(module), name)(self.function, *arguments)

    def ask(self, number: int, name: str | None, arguments: Sequence, named: dict) -> Any:  # noqa: ANN401
        """Have the check do something with what stayed there."""
        self.connection.send_bytes(to_check(("ask", number, name, list(arguments), named)))
        kind, *parts = FromCheck(self.connection.recv_bytes(), self.ask).load()
        if kind == "value":
            return parts[0]
        names, words, key = parts
        raise error_of(names, words, key=key)


class _Comparable(pickle.Pickler):
    """Pickles arguments, so that what a function does to them can be seen."""

    def persistent_id(self, value: Any) -> int | None:  # noqa: ANN401
        """What stayed with the check cannot change here."""
        return id(value) if type(value) is Distant else None


def _bytes_of(arguments: Sequence[Any]) -> bytes | None:
    """Arguments as bytes; None where that cannot be."""
    file = io.BytesIO()
    try:
        _Comparable(file, protocol=5).dump(list(arguments))
    except Exception:
        return None
    return file.getvalue()


def _state(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, np.ndarray | list | dict | set):
        return value.copy()
    if isinstance(value, nx.Graph):
        return value
    if dataclasses.is_dataclass(value) and not value.__dataclass_params__.frozen:
        return {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    return None


def serve(connection: Connection) -> None:
    """Answer a check, and end when it is gone."""
    sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115 - for the process's life
    sys.setrecursionlimit(1000)
    try:
        _Answer(connection).serve()
    except (EOFError, OSError):
        os._exit(0)


def main() -> None:
    """Answer the check whose address comes by the standard input, where no process can fork."""
    address, key, folder = (sys.stdin.readline().rstrip("\n") for _ in range(3))
    os.chdir(folder)
    connection = Client(address, authkey=bytes.fromhex(key))
    limit_process()
    serve(connection)


if __name__ == "__main__":
    main()
