"""Calls that must leave their arguments alone, and whose errors are explained, in notebook 06."""

import copy
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, SupportsFloat

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, kind
from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.checks.framework.explanation import explained

_HINTS: dict[type[Exception], str] = {
    KeyError: "a dictionary has no such key; ask with in, or with .get(key, something)",
    IndexError: "an index lies beyond the end of a list",
    RuntimeError: "does a dictionary or set change while a loop goes through it?",
}


def untouched(
    what: str,
    student: Callable[..., Any],
    *arguments: Any,  # noqa: ANN401
    names: Sequence[str],
    hints: Mapping[type[Exception], str] | None = None,
    copies: bool = False,
) -> Any:  # noqa: ANN401
    """A student's answer, if the arguments are as they were.

    Args:
        what: was called, for the message.
        student: is called.
        arguments: copies of these are given.
        names: of the arguments.
        hints: for kinds of errors, what to say of them in this exercise.
        copies: whether a graph comes back that must share nothing with the first argument.

    Raises:
        WrongAnswer: when one was changed, an error was raised, or nothing came back.
    """
    given = copy.deepcopy(arguments)
    got = explaining(what, partial(student, *given), hints)
    for name, old, new in zip(names, arguments, given, strict=True):
        if old == new:
            continue
        inner = name == "graph" and old.keys() == new.keys()
        words = "the copy shares its inner dictionaries with the map; copy those, too"
        words = words if inner else "it is needed again; make a new one"
        raise WrongAnswer(f"{what}: your function changes its argument {name}; {words}")
    if copies and isinstance(got, dict) and not _ids(got).isdisjoint(_ids(given[0])):
        words = "copy those of all vertices: who changes the new graph must not change the map"
        raise WrongAnswer(f"{what}: the new graph shares inner dictionaries with the map; {words}")
    return returned(what, got)


def _ids(graph: Mapping[Any, Any]) -> set[int]:
    return {id(out) for out in graph.values()}


def explaining(
    what: str,
    student: Callable[[], Any],
    hints: Mapping[type[Exception], str] | None = None,
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
