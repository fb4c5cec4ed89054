"""How answers to notebook 06 are called for, and what form they must have."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, SupportsFloat

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, keeping, kind
from tutorial_lib.checks.framework.explanation import Hints, explained

_HINTS: dict[type[Exception], str] = {
    KeyError: "a dictionary has no such key; ask with in, or with .get(key, something)",
    IndexError: "an index lies beyond the end of a list",
    RuntimeError: "does a dictionary or set change while a loop goes through it?",
}
_INNER = "the copy shares its inner dictionaries with the map; copy those, too"


def untouched(
    right: Callable[..., Any],
    hints: Hints | None = None,
    apart: str = "",
) -> Callable[..., Any]:
    """A way to call a student's function, which must change no argument; see `keeping`."""
    words, call = "it is needed again; make a new one", partial(explaining, hints=hints)
    return keeping(right, words, call, {"graph": _INNER}, apart)


def explaining(
    what: str,
    student: Callable[[], Any],
    hints: Hints | None = None,
    said: Mapping[str, str] | None = None,
) -> Any:  # noqa: ANN401
    """A student's answer.

    Args:
        what: was called, for the message.
        student: is called.
        hints: for kinds of errors, what to say of them in this exercise.
        said: what words of Python's own message mean here; they go first.

    Raises:
        WrongAnswer: when an error was raised: what it was, its line, and what it may mean; or by
            what the student's function was given, and then `what` goes before it.
    """
    try:
        return student()
    except WrongAnswer as wrong:
        raise WrongAnswer(f"{what}: {wrong}") from None
    except (NotImplementedError, MemoryError):
        raise
    except Exception as error:
        raise WrongAnswer(
            f"{what}: {explained(error, {**_HINTS, **(hints or {})}, said)}"
        ) from error


def number(what: str, got: object, words: str) -> float:
    """An answer that is one number.

    Raises:
        WrongAnswer: when it is none; `words` say what to return.
    """
    shape = getattr(got, "shape", ())
    odd = isinstance(got, bool | str) or np.asarray(got).dtype.kind not in "biufO"
    if odd or shape != () or not isinstance(got, SupportsFloat):
        raise WrongAnswer(f"{what}: {kind(got)} came back {words}; return a number")
    return float(got)


def vertices(what: str, got: object, known: set[Any], words: str) -> list[Any]:
    """An answer that is a list of vertices.

    Raises:
        WrongAnswer: when it is none, or holds something that is no vertex.
    """
    if not isinstance(got, tuple | list):
        raise WrongAnswer(f"{what}: {kind(got)} came back {words}; return a list")
    for vertex in got:
        if isinstance(vertex, list | dict | set | tuple) or vertex not in known:
            raise WrongAnswer(f"{what}: {vertex!r} stands in the path, but is no vertex")
    return list(got)
