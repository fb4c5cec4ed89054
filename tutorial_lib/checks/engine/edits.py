"""Known mistakes as edits of a rule's own text."""

import inspect
import re
import textwrap
from collections.abc import Callable
from functools import cache
from itertools import groupby
from typing import Any

from tutorial_lib.errors import InputError

Function = Callable[..., Any]
_ARROW = " -> "


def mistakes_of(rule: Function, text: str) -> dict[str, Function]:
    """For what to say of each mistake, the rule with its edits.

    Args:
        rule: a function whose source is there.
        text: what to say, in a line or several, and below it indented lines ``old -> new``, which
            all are applied, in their order; what is to be replaced stands in the rule exactly once.
            A long edit may be broken before its arrow.

    Raises:
        InputError: when an edit does not apply.

    >>> def twice(x):
    ...     return 2 * x
    >>> mistakes_of(twice, '''
    ... twice, not three times
    ...     2 * x -> 3 * x
    ... ''')["twice, not three times"](1)
    3
    """
    found: dict[str, list[tuple[str, str]]] = {}
    words = ""
    rows = filter(str.strip, re.sub(rf"\n\s+{_ARROW.lstrip()}", _ARROW, text).splitlines())
    for indented, group in groupby(rows, key=lambda row: row[0].isspace()):
        if not indented:
            words = " ".join(group)
            found[words] = []
            continue
        for row in group:
            old, arrow, new = row.strip().partition(_ARROW)
            if not words or not arrow:
                raise InputError(f"mistakes: {row.strip()!r}; give 'old{_ARROW}new' below words")
            found[words].append((old, new))
    return {words: edited(rule, edits) for words, edits in found.items()}


def edited(rule: Function, edits: list[tuple[str, str]]) -> Function:
    """The function whose source has each text replaced, which stands there exactly once."""
    source = _source(rule)
    for old, new in edits:
        if source.count(old) != 1:
            raise InputError(
                f"{rule.__name__}: {old!r} stands there {source.count(old)} times, not once"
            )
        source = source.replace(old, new)
    names = dict(rule.__globals__)
    exec(compile(source, f"<{rule.__name__}, edited>", "exec"), names)
    return names[rule.__name__]


@cache
def _source(rule: Function) -> str:
    return textwrap.dedent(inspect.getsource(rule))
