"""Plain data taken apart and put together: what may come back from an answer.

Numbers, text, arrays, graphs, and the library's plain records. An object of any other class comes
back as one that has its name, words, items and number.
"""

import dataclasses
import itertools
import re
import sys
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import one_line

_ITEMS = 100_000  # of an iterator, which may have no end
_LIBRARY = "tutorial_lib."
_KINDS = re.compile(r"[<>|=][biufcUSMm]\d+(\[\w+\])?")
_GRAPHS = (nx.MultiDiGraph, nx.MultiGraph, nx.DiGraph, nx.Graph)
_PLAIN: tuple[type, ...] = (dict, list, tuple, set, frozenset, str, bytes, int, float)


def parts(value: Any) -> tuple[Any, ...]:  # noqa: ANN401
    """The parts of a value that `made` takes."""
    kind = type(value)
    if isinstance(value, np.ndarray | np.generic) and _KINDS.fullmatch(value.dtype.str):
        plain = np.asarray(value)
        return "array", plain.dtype.str, plain.shape, plain.tobytes(), isinstance(value, np.generic)
    if isinstance(value, np.ndarray) and value.dtype == object:
        return "objects", value.shape, list(value.flat)
    if kind is complex:
        return "complex", value.real, value.imag
    for graph in _GRAPHS:
        if isinstance(value, graph):
            edges = (
                value.edges(keys=True, data=True)
                if isinstance(value, nx.MultiGraph)
                else value.edges.data()
            )
            return "graph", graph.__name__, dict(value.graph), list(value.nodes.data()), list(edges)
    if kind.__module__.startswith(_LIBRARY):
        where = kind.__module__, kind.__qualname__
        if isinstance(value, Enum):
            return "library", *where, [value.value]
        if isinstance(value, tuple):
            return "library", *where, list(value)
        if dataclasses.is_dataclass(kind):
            return "library", *where, [getattr(value, f.name) for f in dataclasses.fields(kind)]
    for plain in _PLAIN:
        if isinstance(value, plain):
            return "plain", plain(value)
    return _foreign_parts(value)


def _foreign_parts(value: Any) -> tuple[Any, ...]:  # noqa: ANN401
    """The name, words, items, array and number of an object of any class."""
    array = number = items = None
    tracked = False
    if hasattr(value, "__array__"):
        detached = value.detach() if hasattr(value, "detach") else value
        array = np.asarray(detached)
        array = array if _KINDS.fullmatch(array.dtype.str) else None
        tracked = bool(getattr(value, "requires_grad", False))  # torch's
    elif hasattr(value, "__iter__") and not isinstance(value, type):
        items = list(itertools.islice(value, _ITEMS))
    if (
        hasattr(value, "__float__")
        and not isinstance(value, type)
        and not getattr(value, "ndim", 0)
    ):
        number = float(value)
    shown = one_line(repr(value), 100) if type(value).__repr__ is not object.__repr__ else ""
    can = [name for name in ("__len__", "__getitem__") if hasattr(value, name)]
    return "foreign", type(value).__name__, shown, items, can, array, number, tracked


def made(kind: str, *parts: Any) -> Any:  # noqa: ANN401
    """A value of its parts, which may be anything: no code of their choice runs."""
    return _MAKERS[kind](*parts)


def _array(kind: str, shape: tuple[int, ...], data: bytes, scalar: bool) -> Any:  # noqa: ANN401
    if not _KINDS.fullmatch(kind):
        raise ValueError(kind)
    array = np.frombuffer(data, kind).reshape(shape).copy()
    return array[()] if scalar else array


def _objects(shape: tuple[int, ...], items: list[Any]) -> Any:  # noqa: ANN401
    array = np.empty(len(items), dtype=object)
    array[:] = items
    return array.reshape(shape)


def _graph(name: str, about: dict, nodes: list, edges: list) -> nx.Graph:
    graph = {kind.__name__: kind for kind in _GRAPHS}[name]()
    graph.graph.update(about)
    graph.add_nodes_from(nodes)
    graph.add_edges_from(edges)
    return graph


def _library(module: str, name: str, values: list[Any]) -> Any:  # noqa: ANN401
    kind = getattr(sys.modules.get(module), name, None)
    if not (isinstance(kind, type) and module.startswith(_LIBRARY)):
        raise ValueError(f"{module}.{name}")
    if issubclass(kind, Enum):
        return kind(values[0])
    if issubclass(kind, tuple):
        return kind._make(values)
    if not dataclasses.is_dataclass(kind):
        raise ValueError(name)
    made = object.__new__(kind)
    for field, value in zip(dataclasses.fields(kind), values, strict=True):
        object.__setattr__(made, field.name, value)
    return made


def _foreign(
    name: str,
    shown: str,
    items: list | None,
    can: list[str],
    array: NDArray | None,
    number: float | None,
    tracked: bool,
) -> Any:  # noqa: ANN401
    methods: dict[str, Any] = {"__repr__": lambda self: shown} if shown else {}
    if items is not None:
        methods["__iter__"] = lambda self: iter(items)
        own = {"__len__": lambda self: len(items), "__getitem__": lambda self, i: items[i]}
        methods |= {name: own[name] for name in can}
    if array is not None:
        methods["__array__"] = lambda self, dtype=None, copy=None: np.array(array, dtype)
        methods |= {"item": lambda self: array.item(), "requires_grad": tracked}
    if number is not None:
        methods["__float__"] = lambda self: number
    return type(identifier(name), (), methods)()


_MAKERS: Mapping[str, Callable[..., Any]] = {
    "array": _array,
    "objects": _objects,
    "complex": complex,
    "graph": _graph,
    "library": _library,
    "plain": lambda value: value,
    "foreign": _foreign,
}


def identifier(name: object) -> str:
    """A name that a class may have."""
    return name if isinstance(name, str) and name.isidentifier() and len(name) < 80 else "object"
