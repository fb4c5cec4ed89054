"""What crosses between a check and the process of an answer.

A check trusts its own side only. What it sends is pickled as usual; functions and the robots and
recorders of a check stay where they are, and the answer gets a `Distant` one that asks for
everything. What comes back is data and nothing else: see `plain`.
"""

import builtins
import dataclasses
import io
import pickle
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, TypeGuard

import networkx as nx
import numpy as np

from tutorial_lib.checks.marking.plain import identifier, made, parts
from tutorial_lib.errors import one_line

MOST = 1 << 26
"""Bytes of a message."""
_CHECKS = "tutorial_lib.checks."


class Distant:
    """Stands for what stays with the check: calls and attributes are asked for there."""

    def __init__(self, number: int, ask: Callable[..., Any]) -> None:
        """Know its number there, and how to ask."""
        self._number, self._ask = number, ask

    def __call__(self, *arguments: Any, **named: Any) -> Any:  # noqa: ANN401
        """Have the check call it."""
        return self._ask(self._number, None, arguments, named)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        if name.startswith("_"):
            raise AttributeError(name)
        return self._ask(self._number, name, (), {})


class ToAnswer(pickle.Pickler):
    """Pickles what a check sends; what stays with it is appended to `kept`."""

    def __init__(self, file: io.BytesIO, kept: list[Any]) -> None:
        super().__init__(file, protocol=5)
        self.kept = kept

    def persistent_id(self, value: Any) -> int | None:  # noqa: ANN401
        """The number of what stays."""
        if isinstance(value, type) or not _stays(value):
            return None
        known = (n for n, other in enumerate(self.kept) if other is value or _same(other, value))
        number = next(known, len(self.kept))
        if number == len(self.kept):
            self.kept.append(value)
        return number


def _same(first: Any, second: Any) -> bool:  # noqa: ANN401
    """Whether both are one method of one object, which Python makes anew at each look."""
    own = getattr(first, "__self__", None)
    return own is not None and own is getattr(second, "__self__", None) and first == second


def _stays(value: Any) -> bool:  # noqa: ANN401
    """Whether it is a method, a function, or an object with a state of its own, of a check."""
    kind = type(value)
    if kind.__name__ == "method":
        return True
    if kind.__name__ == "function":
        return value.__module__.startswith(_CHECKS) or "<" in value.__qualname__
    data = dataclasses.is_dataclass(kind) or isinstance(value, tuple | Enum)
    return kind.__module__.startswith(_CHECKS) and not data


class FromCheck(pickle.Unpickler):
    """Loads what a check has sent, in the answer's process."""

    def __init__(self, data: bytes, ask: Callable[..., Any]) -> None:
        super().__init__(io.BytesIO(data))
        self.ask = ask

    def persistent_load(self, number: int) -> Distant:
        """Stand for what stays with the check."""
        return Distant(number, self.ask)


def _may_change(value: Any) -> bool:  # noqa: ANN401
    return isinstance(value, np.ndarray | list | dict | set | nx.Graph) or dataclasses.is_dataclass(
        value
    )


class _ToCheck(pickle.Pickler):
    """Takes apart all that an answer sends."""

    def __init__(self, file: io.BytesIO, arguments: Sequence[Any]) -> None:
        super().__init__(file, protocol=5)
        changeable = [(n, value) for n, value in enumerate(arguments) if _may_change(value)]
        self.arguments = {id(value): number for number, value in changeable}

    def persistent_id(self, value: Any) -> tuple[str, int] | None:  # noqa: ANN401
        """What is the check's own."""
        if type(value) is Distant:
            return "kept", value._number
        number = self.arguments.get(id(value))
        return None if number is None else ("argument", number)

    def reducer_override(self, value: Any) -> Any:  # noqa: ANN401
        """Its parts, which `made` puts together again."""
        return NotImplemented if value is made else (made, parts(value))


def to_check(value: Any, arguments: Sequence[Any] = ()) -> bytes:  # noqa: ANN401
    """What an answer sends; of `arguments`, which it was given, only the numbers."""
    file = io.BytesIO()
    _ToCheck(file, arguments).dump(value)
    return file.getvalue()


class FromAnswer(pickle.Unpickler):
    """Loads what an answer has sent. No code of its choice runs, whatever the bytes are."""

    def __init__(
        self, data: bytes, kept: Sequence[Any] = (), arguments: Sequence[Any] = ()
    ) -> None:
        super().__init__(io.BytesIO(data))
        self.own = {"kept": kept, "argument": arguments}

    def find_class(self, module: str, name: str) -> Callable[..., Any]:
        """Only what makes plain data; a new function each time, so that none can be changed."""
        if (module, name) != (made.__module__, made.__name__):
            raise pickle.UnpicklingError(f"no plain data: {one_line(f'{module}.{name}', 80)}")
        return lambda *parts: made(*parts)

    def persistent_load(self, key: tuple[str, int]) -> Any:  # noqa: ANN401
        """What is the check's own."""
        return self.own[key[0]][key[1]]


def error_parts(error: BaseException) -> tuple[list[str], str]:
    """The names of an error's classes, and its words."""
    try:
        words = str(error)
    except BaseException as another:
        words = f"no message, since its __str__ raised {type(another).__name__}"
    return [kind.__name__ for kind in type(error).__mro__], words[:10_000]


def error_of(
    names: Sequence[str], words: str, place: str = "", key: int | None = None
) -> BaseException:
    """An error of Python's or networkx's own class, by the names and words of one elsewhere.

    It has the place, and the key by which the check knows an error of its own.
    """
    known = {**vars(nx), **vars(builtins), "LinAlgError": np.linalg.LinAlgError}
    found = (known[name] for name in names if name != "KeyboardInterrupt" and name in known)
    base = next((kind for kind in found if _is_error(kind)), RuntimeError)
    base = RuntimeError if base in (BaseException, GeneratorExit) else base
    own = {"__str__": lambda self: words, "place": place, "key": key}
    return base.__new__(type(identifier(names[0]), (base,), own))


def _is_error(kind: object) -> TypeGuard[type[BaseException]]:
    return isinstance(kind, type) and issubclass(kind, BaseException)
