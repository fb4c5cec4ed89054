"""JSON and YAML: plain data of a sane size and depth."""

import json
import re
from itertools import accumulate
from pathlib import Path
from typing import Any, NoReturn

import yaml

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_DEPTH, MAX_JSON, MAX_YAML
from tutorial_lib.reading.regular import failure, read_text

# Neither can go back and try again: text of a few megabytes would take hours.
_ESCAPE, _STRING = re.compile(r"\\.", re.DOTALL), re.compile(r'"[^"]*"?')
_BRACKET = re.compile(r"[\[\]{}]")


def read_json(path: str | Path, advice: str = "", limit: int = MAX_JSON) -> Any:  # noqa: ANN401
    """What a JSON file holds.

    Args:
        path: of the file.
        advice: what to do about a file that cannot be read.
        limit: in bytes.

    Raises:
        InputError: when it cannot be read, or is no JSON; it ends with the advice.
    """
    return parse_json(read_text(path, limit, advice), str(path), advice)


def parse_json(text: str, where: str, advice: str = "") -> Any:  # noqa: ANN401
    """What JSON text holds; as NaN and Infinity do, which who reads numbers has to refuse.

    Raises:
        InputError: naming `where` it stands, when it is no JSON, or deeper than `MAX_DEPTH`.
    """
    try:
        if len(text) > MAX_DEPTH and _depth(text) > MAX_DEPTH:
            raise InputError(f"more than {MAX_DEPTH} lists and mappings within each other")
        return json.loads(text)
    except ValueError as error:
        raise failure(where, f"damaged, or not JSON ({error})", advice) from None


def _depth(text: str) -> int:
    """How deep lists and mappings lie within each other, so far as text is JSON."""
    brackets = _BRACKET.findall(_STRING.sub("", _ESCAPE.sub("", text)))
    return max(accumulate(1 if bracket in "[{" else -1 for bracket in brackets), default=0)


def read_yaml(path: str | Path, advice: str = "") -> Any:  # noqa: ANN401
    """What a YAML file holds: plain mappings, lists and values.

    Anchors, aliases, merges and tags are refused: a few lines of them mean gigabytes or objects.

    Raises:
        InputError: when it cannot be read or is not such YAML; it ends with the advice.
    """
    text = read_text(path, MAX_YAML, advice)
    try:
        return yaml.load(text, Loader=_PlainLoader)  # a SafeLoader
    # Its constructors have a dozen errors for a value that only looks like a number or a date.
    except Exception as error:
        mark = getattr(error, "problem_mark", None)
        where = f" near line {mark.line + 1}" if mark else ""
        said = getattr(error, "problem", None) or error
        raise failure(path, f"is no valid YAML{where} ({said})", advice) from None


class _PlainLoader(yaml.SafeLoader):
    """Refuses what is more than data."""

    depth = 0

    def compose_node(self, parent: yaml.Node | None, index: object) -> yaml.Node | None:
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
        raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)
