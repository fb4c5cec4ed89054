"""A student's function as its check sees it: one that runs in another process."""

import dataclasses
import io
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from inspect import Parameter, Signature
from multiprocessing.connection import Connection
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.checks.framework import guard
from tutorial_lib.checks.marking.wire import MOST, FromAnswer, ToAnswer, error_of, error_parts
from tutorial_lib.errors import InputError, words_of


class Ended(BaseException):
    """The answer's process is gone. No `Exception`, so that no check takes it for an answer's."""


class StandIn:
    """Calls an answer in its process, and does there what the call does to its arguments.

    Attributes:
        ended: whether its process has ended by itself.
    """

    def __init__(self, connection: Connection) -> None:
        """Know the way to the process."""
        self._connection, self.ended = connection, False
        self._latest = time.monotonic() + guard.WAITING
        self._kept: list[Any] = []
        self._raised: list[BaseException] = []

    def load(self, file: str, text: bytes, name: str) -> None:
        """Run the file of the answer, which defines a function of this name.

        Raises:
            InputError: when it does not run or defines no such function.
            Ended: when it ends its process.
            TimeUp: when that takes too long.
        """
        try:
            names = self._ask("load", (file, text, name), {})
        except Exception as error:
            raise InputError(str(error) or f"{file} does not run ({words_of(error)})") from None
        with suppress(Exception):  # for messages alone
            kind = Parameter.POSITIONAL_OR_KEYWORD
            self.__signature__ = Signature([Parameter(str(name), kind) for name in names])
        self._latest = time.monotonic() + guard.WAITING

    def __call__(self, *arguments: Any, **named: Any) -> Any:  # noqa: ANN401
        """What the student's function returns, or raise what it raises."""
        return self._ask("call", arguments, named)

    def run_beside(self, function: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        """What a function of the library returns of the student's function, called over there."""
        return self._ask("run", (f"{function.__module__}:{function.__qualname__}", *arguments), {})

    def _ask(self, what: str, arguments: Sequence[Any], named: dict[str, Any]) -> Any:  # noqa: ANN401
        self._send((what, arguments, named))
        while True:
            kind, *parts = self._received(arguments)
            if kind == "ask":
                self._reply(*parts)
            elif kind == "raised":
                names, words, place, key = parts
                raise self._raised[key] if key is not None else error_of(names, words, place)
            else:
                result, changed = parts
                states = FromAnswer(changed, self._kept).load() if changed else ()
                for argument, state in zip(arguments, states, strict=False):
                    _change(argument, state)
                return result

    def _send(self, message: Any) -> None:  # noqa: ANN401
        file = io.BytesIO()
        ToAnswer(file, self._kept).dump(message)
        try:
            self._connection.send_bytes(file.getvalue())
        except OSError:
            self.ended = True
            raise Ended from None

    def _received(self, arguments: Sequence[Any]) -> tuple[Any, ...]:
        try:
            if not self._connection.poll(max(self._latest - time.monotonic(), 0.0)):
                raise guard.TimeUp
            data = self._connection.recv_bytes(MOST)
        except (EOFError, OSError):
            self.ended = True
            raise Ended from None
        try:
            return tuple(FromAnswer(data, self._kept, arguments).load())
        except Exception as error:
            words = f"what came back cannot be read ({words_of(error, 80)}); return plain values"
            raise RuntimeError(words) from None

    def _reply(self, number: int, name: str | None, arguments: Sequence, named: dict) -> None:
        """Do what the answer asks of something that stayed here."""
        try:
            what = self._kept[number]
            if name is None:
                value = what(*arguments, **named)
            elif str(name).startswith("_"):
                raise AttributeError(name)
            else:
                value = getattr(what, name)
        except Exception as error:
            self._raised.append(error)
            self._send(("raised", *error_parts(error), len(self._raised) - 1))
        else:
            self._send(("value", value))


def _change(argument: Any, state: Any) -> None:  # noqa: ANN401
    """Give an argument the state that a student's function has left its copy in."""
    if state is None:
        return
    if isinstance(argument, np.ndarray):
        if argument.shape == state.shape:
            argument[...] = state
    elif isinstance(argument, list):
        argument[:] = state
    elif isinstance(argument, dict | set):
        argument.clear()
        argument.update(state)
    elif isinstance(argument, nx.Graph):
        argument.__dict__.update(state.__dict__)
    elif dataclasses.is_dataclass(argument):
        argument.__dict__.update(
            {f.name: state[f.name] for f in dataclasses.fields(argument) if f.name in state}
        )
