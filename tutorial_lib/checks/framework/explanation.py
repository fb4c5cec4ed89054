"""What an error of a student's code was, where, and what it may mean."""

import sysconfig
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

_OTHERS = (str(Path(__file__).resolve().parents[2]), *sysconfig.get_paths().values())
"""Folders of code that is not the student's: this library, Python's, and what is installed."""
_GENERATED = ("<frozen", "<__array_function__", "<class 'networkx")
"""Names of code that has no file: Python's, numpy's and networkx's."""
_USUAL: dict[type[Exception], str] = {
    IndexError: "an index lies beyond the end of an array; do not look there",
    TypeError: "something isn't of the type you use it as; compare with the docstring",
    ValueError: "do the shapes fit, and is there anything to choose from?",
    KeyError: "there is no such key",
    NameError: "is a name misspelt, or set in one branch only?",
    AttributeError: "is a name misspelt? Compare with the docstring",
    ZeroDivisionError: "something is divided by zero",
    RecursionError: "the function calls itself for ever",
}
_NEW = "what you were given mustn't be changed; make a new one"
_MEANT = {
    "Cannot cast ufunc": "+= and its like change an array in place, in the type that it has; "
    "a = a + b makes a new one",
    "read-only": _NEW,
    "does not support item assignment": _NEW,
    "cannot assign to field": f"{_NEW}, with dataclasses.replace",
    "truth value of an array": "if, and, or, not, max and min want single values, and an array "
    "stands there; of arrays they are &, |, ~, np.maximum and np.minimum",
    "requires grad": "a tensor with its gradients stands there; loss.item() is its number",
}
"""What words of Python's own message mean in any exercise."""
_ANY = "try this case by hand, and print what you have just before that line"


Hints = Mapping[type[Exception], str | Callable[[Any], str]]
"""For kinds of errors what to say of them in an exercise, or what says it of an error."""


def explained(
    error: Exception,
    hints: Hints | None = None,
    said: Mapping[str, str] | None = None,
) -> str:
    """What an error was, where, and what it may mean.

    Args:
        error: of the student's code.
        hints: what to say in this exercise.
        said: what words of Python's own message mean here; they go first.
    """
    known = {**_USUAL, **(hints or {})}
    words = [meant(error, said)] if meant(error, said) else []
    hint = next((known[kind] for kind in type(error).__mro__ if kind in known), _ANY)
    words.append(hint(error) if callable(hint) else hint)
    return "; ".join([stops(error), words[0]])


def meant(error: Exception, said: Mapping[str, str] | None = None) -> str:
    """What the words of an error's message mean; empty if that is not known."""
    known = [*(said or {}).items(), *_MEANT.items()]
    return next((words for part, words in known if part in str(error)), "")


def stops(error: BaseException) -> str:
    """What an error was, and in which line of the student's code."""
    said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return f"your code stops with {said}{place(error)}"


def place(error: BaseException) -> str:
    """The last line of a student's code on the way to an error; empty if there is none.

    An error of another process brings it along, as its `place`.
    """
    brought = getattr(error, "place", None)
    if isinstance(brought, str):
        return brought
    own = [f for f in traceback.extract_tb(error.__traceback__) if not _is_others(f.filename)]
    if not own:
        return ""
    line = f": {own[-1].line}" if own[-1].line else ""
    return f", in line {own[-1].lineno}{line}"


def _is_others(file: str) -> bool:
    return file.startswith((*_OTHERS, *_GENERATED))
