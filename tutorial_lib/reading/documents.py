"""JSON and YAML: plain data of a sane size and depth."""

import json
import re
from collections import Counter
from collections.abc import Callable
from itertools import accumulate
from pathlib import Path
from typing import Any, ClassVar, NoReturn

import yaml

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_DEPTH, MAX_JSON, MAX_YAML
from tutorial_lib.reading.regular import failure, read_text

# Neither can go back and try again: text of a few megabytes would take hours.
_ESCAPE, _STRING = re.compile(r"\\.", re.DOTALL), re.compile(r'"[^"]*"?')
_BRACKET = re.compile(r"[\[\]{}]")
# The plain scalars of YAML 1.2's core schema that are not text: each with what it begins with.
_SCALARS = {
    "null": (r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    "bool": (r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    "int": (r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", list("-+0123456789")),
    "float": (
        r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
        r"|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
        list("-+.0123456789"),
    ),
}


def read_json(path: str | Path, advice: str = "", limit: int = MAX_JSON) -> Any:  # noqa: ANN401
    """What a JSON file holds.

    Args:
        path: of the file.
        advice: what to do about a file that cannot be read.
        limit: in bytes.

    Raises:
        InputError: when it cannot be read, or is no JSON; about a damaged file it ends with the
            advice.
    """
    return parse_json(read_text(path, limit, advice), str(path), advice)


def parse_json(text: str, where: str, advice: str = "") -> Any:  # noqa: ANN401
    """What JSON text holds; as NaN and Infinity do, which who reads numbers has to refuse.

    Raises:
        InputError: naming `where` it stands, when it is no JSON, has a key twice, or is deeper
            than `MAX_DEPTH`.
    """
    try:
        if len(text) > MAX_DEPTH and _depth(text) > MAX_DEPTH:
            raise InputError(
                f"more than {MAX_DEPTH} lists and mappings within each other; give fewer"
            )
        return json.loads(text, object_pairs_hook=_mapping)
    except InputError as error:
        raise failure(where, error, "") from None
    except ValueError as error:
        raise failure(where, f"damaged, or not JSON ({error})", advice) from None


def _depth(text: str) -> int:
    """How deep lists and mappings lie within each other, so far as text is JSON."""
    brackets = _BRACKET.findall(_STRING.sub("", _ESCAPE.sub("", text)))
    return max(accumulate(1 if bracket in "[{" else -1 for bracket in brackets), default=0)


def _mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A mapping in which no key was given twice: nobody can know which one is meant."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = next(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        raise InputError(f"the key {twice!r} is given twice; keep one")
    return found


def read_yaml(path: str | Path, advice: str = "") -> Any:  # noqa: ANN401
    """What a YAML file holds: plain mappings, lists and values.

    Numbers are those of YAML 1.2, as in yaml-cpp: 010 is ten, and 0_1, 1:30 or 2001-12-14 are text.
    Anchors, aliases, merges and tags are refused, since a few lines of them mean gigabytes or
    objects; so is a key that is given twice.

    Raises:
        InputError: when it cannot be read or is not such YAML; it ends with the advice.
    """
    text = read_text(path, MAX_YAML, advice)
    try:
        return yaml.load(text, Loader=_PlainLoader)  # a SafeLoader
    # Python's errors for a number with too many digits, or a key that is a list, come as they are.
    except Exception as error:
        mark = getattr(error, "problem_mark", None)
        where = f" near line {mark.line + 1}" if mark else ""
        said = getattr(error, "problem", None) or error
        raise failure(path, f"is no valid YAML{where} ({said})", advice) from None


def scalar_of(text: str) -> str | int | float | bool | None:
    """What YAML 1.2 reads where this text stands without quotes.

    >>> [scalar_of(text) for text in ("010", "0o10", "5e-2", "0_1", "no")]
    [10, 8, 0.05, '0_1', 'no']
    """
    for kind, (pattern, _) in _SCALARS.items():
        if re.fullmatch(pattern, text):
            return _VALUES[kind](text)
    return text


def _whole(text: str) -> int:
    return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))


_VALUES: dict[str, Callable[[str], Any]] = {
    "null": lambda _: None,
    "bool": lambda text: text.lower() == "true",
    "int": _whole,
    "float": lambda text: float(re.sub(r"\.(inf|nan)", r"\1", text.lower())),
}


class _PlainLoader(yaml.SafeLoader):
    """Refuses what is more than data."""

    depth = 0
    # Not those of YAML 1.1. The stubs take what PyYAML keeps in the class for an instance's.
    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}  # pyrefly: ignore[bad-override]

    def scan_to_next_token(self) -> None:
        """Skip tabs as well, as yaml-cpp does, but where they would indent a line."""
        super().scan_to_next_token()
        while self.peek() == "\t":
            before = self.buffer[self.pointer - self.column : self.pointer]
            if not (self.flow_level or before.strip(" \t")):
                mark = self.get_mark()
                raise yaml.MarkedYAMLError(
                    problem="a tab indents it; use spaces", problem_mark=mark
                )
            self.forward()
            super().scan_to_next_token()

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        event = self.peek_event()
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            self._refuse(event, "anchors and aliases are not read")
        if getattr(event, "tag", None):
            self._refuse(event, "tags are not read")
        if isinstance(event, yaml.ScalarEvent) and event.value == "<<":
            self._refuse(event, "merges are not read")
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self._refuse(event, f"more than {MAX_DEPTH} lists and mappings within each other")
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def _refuse(self, event: yaml.Event, problem: str) -> NoReturn:
        # The stubs know of libyaml's marks as well, in events but not in errors.
        mark = event.start_mark
        raise yaml.MarkedYAMLError(problem=problem, problem_mark=mark)  # pyrefly: ignore[bad-argument-type]

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        found = super().construct_mapping(node, deep)
        if len(found) < len(node.value):
            known: set[Any] = set()
            for key, _ in node.value:
                name = self.construct_object(key, deep)
                if name in known:
                    raise yaml.MarkedYAMLError(
                        problem=f"the key {name!r} is given twice", problem_mark=key.start_mark
                    )
                known.add(name)
        return found


for _kind, (_pattern, _first) in _SCALARS.items():
    _tag = f"tag:yaml.org,2002:{_kind}"
    _PlainLoader.add_implicit_resolver(_tag, re.compile(f"(?:{_pattern})\\Z"), _first)
    _PlainLoader.add_constructor(_tag, lambda _, node, make=_VALUES[_kind]: make(node.value))
