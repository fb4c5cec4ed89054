"""Calls of students' functions, and what form their answers must have."""

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from inspect import Parameter, signature
from typing import Any, SupportsFloat

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.explanation import Hints, explained
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.geometry import Array

Mask = NDArray[np.bool_]
_COPIED = (np.ndarray, list, tuple, dict, set, nx.Graph)
_PLAIN = (bool, int, float, complex, str, bytes, set, np.generic)


class Alias(WrongAnswer):
    """An answer that lies in the memory of an argument.

    Attributes:
        answer: what came back; it may be right otherwise.
    """

    def __init__(self, name: str, answer: Any) -> None:  # noqa: ANN401
        words = "what changes one of them later changes the other; return a new array"
        super().__init__(f"what comes back is your argument {name} itself: {words}")
        self.answer = answer


def patient(invoke: Callable[..., Any]) -> tuple[Callable[..., Any], list[WrongAnswer]]:
    """A way to call that goes on after an `Alias`, and what is to be said in the end.

    Wrong numbers come first; then that they are not the student's own, or that a call has changed
    what the call before it returned.
    """
    met: list[WrongAnswer] = []
    last: list[Any] = [None, None]  # an answer, and what it was

    def on(*arguments: Any) -> Any:  # noqa: ANN401
        try:
            answer = invoke(*arguments)
        except Alias as alias:
            met.append(alias)
            answer = alias.answer
        if not unchanged(last[1], last[0]):
            words = "each call changes what the one before it returned; return a new array"
            met.append(WrongAnswer(words))
        last[:] = answer, copy.deepcopy(answer) if _arrays(answer) else answer
        return answer

    return on, met


def _arrays(answer: Any) -> bool:  # noqa: ANN401
    """Whether an answer is an array, or several."""
    if isinstance(answer, tuple | list):
        return bool(answer) and all(isinstance(part, np.ndarray) for part in answer)
    return isinstance(answer, np.ndarray)


def call(student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401 - whatever students return
    """Call a student's function, and demand that it leaves its arguments alone.

    It gets copies of what could be changed: what it changes does not spoil the next case.

    Raises:
        WrongAnswer: when an argument was changed.
        Alias: when one came back as the answer or a part of it.
    """
    given = [copy.deepcopy(a) if isinstance(a, _COPIED) else a for a in arguments]
    answer = student(*given)
    for name, old, new in zip(_names(student, len(given)), arguments, given, strict=True):
        if not unchanged(old, new):
            new_one = (
                "graph" if isinstance(old, nx.Graph) else type(old).__name__.removeprefix("nd")
            )
            raise WrongAnswer(f"your function changes its argument {name}; make a new {new_one}")
        if _shares(answer, new):
            raise Alias(str(name), answer)
    return answer


def _names(student: Callable[..., Any], count: int) -> Sequence[object]:
    """What a student's function calls its first arguments; numbers from 1 on if that is unknown."""
    with suppress(TypeError, ValueError):
        every = signature(student).parameters.values()
        names = [p.name for p in every if p.kind is Parameter.POSITIONAL_OR_KEYWORD]
        if len(names) >= count:
            return names[:count]
    return range(1, count + 1)


def unchanged(old: Any, new: Any) -> bool:  # noqa: ANN401 - arguments of any kind
    """Whether an argument is still what it was; of objects that is not looked into."""
    if isinstance(old, nx.Graph):
        return isinstance(new, nx.Graph) and unchanged(_tables(old), _tables(new))
    if isinstance(old, np.ndarray):
        alike = isinstance(new, np.ndarray) and old.dtype == new.dtype
        return alike and np.array_equal(old, new, equal_nan=old.dtype.kind in "fc")
    if isinstance(old, list | tuple):
        alike = isinstance(new, list | tuple) and len(old) == len(new)
        return alike and all(map(unchanged, old, new))
    if isinstance(old, dict):
        alike = isinstance(new, dict) and old.keys() == new.keys()
        return alike and all(unchanged(old[key], new[key]) for key in old)
    if isinstance(old, _PLAIN) or old is None:
        return bool(old == new) or (old != old and new != new)
    return True


def _tables(graph: nx.Graph) -> list[dict[Any, Any]]:
    """The nodes and the edges of a graph, with what is stored of them."""
    return [dict(graph.nodes(data=True)), nx.to_dict_of_dicts(graph)]


def _shares(answer: Any, argument: Any) -> bool:  # noqa: ANN401
    """Whether an answer, or a part of it, lies in the memory of an argument."""
    if not isinstance(argument, np.ndarray):
        return False
    found: Iterable[Any] = answer if isinstance(answer, tuple | list) else [answer]
    return any(isinstance(a, np.ndarray) and np.may_share_memory(a, argument) for a in found)


def calling(
    hints: Hints | None = None,
    said: Mapping[str, str] | None = None,
    run: Callable[..., Any] | None = None,
) -> Callable[..., Any]:
    """A way to call a student's function that explains its errors; see `explained`.

    Args:
        hints: see there.
        said: see there.
        run: (student, *case) calls it, where that is more than one call; what it demands in vain is
            said of this case.
    """

    def invoke(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        try:
            return (run or call)(student, *arguments)
        except NotImplementedError:
            raise
        except WrongAnswer as wrong:
            if run is None:
                raise
            raise WrongAnswer(f"{what}: {wrong}") from None
        except Exception as error:
            raise WrongAnswer(f"{what}: {explained(error, hints, said)}") from error

    return invoke


def keeping(
    right: Callable[..., Any],
    words: str,
    invoke: Callable[[str, Callable[[], Any]], Any],
    inner: Mapping[str, str] | None = None,
    apart: str = "",
) -> Callable[..., Any]:
    """A way to call a student's function that demands that its arguments stay as they are.

    Args:
        right: the rule; its parameters name the arguments.
        words: what to do instead of changing one.
        invoke: calls the function, as `calling` does.
        inner: by argument, what to say instead where a dictionary has its keys still.
        apart: what to say of an answer that shares dictionaries with the first argument; nothing
            if empty.
    """
    names = list(signature(right).parameters)

    def keeps(what: str, student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        given = copy.deepcopy(arguments)
        got = invoke(what, partial(student, *given))
        for name, old, new in zip(names, arguments, given, strict=False):
            if not unchanged(old, new):
                within = inner[name] if inner and name in inner and old.keys() == new.keys() else ""
                said = f"your function changes its argument {name}; {within or words}"
                raise WrongAnswer(f"{what}: {said}")
            if isinstance(new, set) and got is new:
                raise WrongAnswer(
                    f"{what}: what came back is your argument {name} itself; return a new set, "
                    "also where nothing changes"
                )
        shared = apart and isinstance(got, dict) and {*map(id, got.values())}
        if shared and not shared.isdisjoint(map(id, given[0].values())):
            raise WrongAnswer(f"{what}: {apart}")
        return returned(what, got)

    return keeps


def beside(run: Callable[..., Any]) -> Callable[..., Any]:
    """A way to call a function of the library, with the student's, where the student's runs.

    For arguments that cannot be sent to another process, as a network that is trained.
    """

    def invoke(student: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        elsewhere = getattr(student, "run_beside", None)  # of marking's stand-in
        return elsewhere(run, *arguments) if elsewhere else run(student, *arguments)

    return invoke


def returned(what: str, got: Any) -> Any:  # noqa: ANN401 - whatever students return
    """An answer that is not None; `WrongAnswer` if it is."""
    if got is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    return got


def parts(what: str, got: object, count: int, words: str) -> list[Any]:
    """The parts of an answer; `WrongAnswer` with `words`, on what to return, if not `count`."""
    got = returned(what, got)
    if not isinstance(got, tuple | list) or len(got) != count:
        raise WrongAnswer(f"{what}: {words}")
    return list(got)


def as_floats(got: object) -> Array:
    """What holds real numbers, as an array of floats; NumPy would take text and complex ones, too.

    Raises:
        TypeError or ValueError: when it holds anything else.
    """
    values = np.asarray(got)
    odd = values.dtype.kind == "O" and not all(
        isinstance(value, SupportsFloat) and not isinstance(value, np.complexfloating)
        for value in values.flat
    )
    if values.dtype.kind not in "biufO" or odd:
        raise TypeError
    return values.astype(float)


def numbers(what: str, got: object, shape: tuple[int, ...]) -> Array:
    """An answer as an array of this shape, or as a number if that is (); `WrongAnswer` if not."""
    got = returned(what, got)
    if shape and not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return a numpy array")
    try:
        values = as_floats(got)
    except (TypeError, ValueError):
        if isinstance(got, np.ndarray):
            words = f"an array of {got.dtype} came back; return real numbers"
            raise WrongAnswer(f"{what}: {words}") from None
        words = "isn't an array of numbers; return one" if shape else "isn't a number; return one"
        raise WrongAnswer(f"{what}: {kind(got)} {words}") from None
    if values.shape != shape:
        raise WrongAnswer(f"{what}: shape {values.shape}, but {shape} is needed")
    return values


def mask(what: str, got: object, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """An answer of True and False, as an array of this shape; `WrongAnswer` if it is none."""
    got = returned(what, got)
    if not isinstance(got, np.ndarray):
        raise WrongAnswer(f"{what}: {kind(got)} came back; return a numpy array")
    if got.dtype != bool:
        raise WrongAnswer(f"{what}: return True or False for each, not numbers ({got.dtype})")
    if got.shape != shape:
        raise WrongAnswer(f"{what}: shape {got.shape}, but {shape} is needed")
    return got
