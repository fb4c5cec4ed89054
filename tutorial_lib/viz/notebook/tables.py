"""Tables as output of notebook cells."""

import html
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, instances, one_of


@dataclass(frozen=True)
class Table:
    """A table as a cell's output: HTML, and text where that is not shown.

    Attributes:
        columns: their names.
        rows: the cells' texts.
        bold: (row, column) of the best values.
        right: the columns of numbers, which are set to the right.
        caption: above the table; empty for none.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    bold: frozenset[tuple[int, int]]
    right: frozenset[int]
    caption: str = ""

    def _repr_html_(self) -> str:
        head = "".join(self._cell("th", i, html.escape(n)) for i, n in enumerate(self.columns))
        body = ""
        for number, row in enumerate(self.rows):
            cells = ""
            for i, text in enumerate(row):
                shown = html.escape(text)
                cells += self._cell(
                    "td", i, f"<b>{shown}</b>" if (number, i) in self.bold else shown
                )
            body += f"<tr>{cells}</tr>"
        caption = f"<caption>{html.escape(self.caption)}</caption>" if self.caption else ""
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def _cell(self, tag: str, column: int, text: str) -> str:
        side = "right" if column in self.right else "left"
        return f'<{tag} style="text-align:{side};padding:2px 10px">{text}</{tag}>'

    def __repr__(self) -> str:
        wide = [max(map(len, column)) for column in zip(self.columns, *self.rows, strict=True)]
        lines = [self.caption] if self.caption else []
        for row in (self.columns, *self.rows):
            cells = (
                text.rjust(w) if i in self.right else text.ljust(w)
                for i, (text, w) in enumerate(zip(row, wide, strict=True))
            )
            lines.append("  ".join(cells).rstrip())
        return "\n".join(lines)


def table(
    columns: Mapping[str, str],
    rows: Sequence[Sequence[Any]],
    best: Mapping[str, Callable[..., Any]] | None = None,
    caption: str = "",
) -> Table:
    """A table as a cell's last line, or for `display`.

    Args:
        columns: names, and the format of the numbers below each, as in ``".1%"``; empty for words.
        rows: the values; None leaves a cell empty.
        best: for columns, `max` or `min`: which of the numbers is the best, and set in bold.
        caption: above the table.

    Raises:
        InputError: when a row has not as many values as there are columns, or one does not fit its
            column's format.

    >>> table({"planner": "", "success": ".0%"}, [["ours", 0.9], ["theirs", 0.5]], {"success": max})
    planner  success
    ours         90%
    theirs       50%
    """
    names, formats = list(instance("columns", columns, Mapping)), list(columns.values())
    rows, caption = instances("rows", rows, Sequence), instance("caption", caption, str)
    for row in rows:
        if len(row) != len(names):
            raise InputError(f"rows: {len(row)} values in a row; give {len(names)}")
    try:
        texts = [
            ["" if v is None else format(v, f) for v, f in zip(row, formats, strict=True)]
            for row in rows
        ]
    except (TypeError, ValueError) as error:
        raise InputError(f"columns, rows: {error}; give values that fit the formats") from error
    bold = set()
    for name, choose in instance("best", {} if best is None else best, Mapping).items():
        i = names.index(one_of("best", name, names))
        known = [row[i] for row in rows if row[i] is not None]
        bold |= {(n, i) for n, row in enumerate(rows) if known and row[i] == choose(known)}
    right = frozenset(i for i, form in enumerate(formats) if form)
    return Table(names, texts, frozenset(bold), right, caption)
