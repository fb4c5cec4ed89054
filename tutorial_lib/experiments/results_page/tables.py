"""Rows of a report, and tables that are made of them by short specifications."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import (
    Row,
    counted,
    interval,
    table,
    with_best_bold,
)

Text = str | Callable[[Any], str]
"""What a cell says of a row: a format of its columns, as in "{edges:,} edges", or a function."""


@dataclass(frozen=True)
class Best:
    """What the cells of a column say, the best of which is bold.

    Attributes:
        text: of a row.
        key: of its value in the row, or a function; a None takes no part.
        least: whether the least value is the best.
    """

    text: Text
    key: str | Callable[[Row], float | None]
    least: bool = False

    def value(self, row: Row) -> float | None:
        """By which rows are compared."""
        return row[self.key] if isinstance(self.key, str) else self.key(row)


def matching(rows: Rows, **values: Any) -> Rows:  # noqa: ANN401 - any value of a row
    """The rows that have those values."""
    return [row for row in rows if all(row[key] == value for key, value in values.items())]


def one(rows: Rows, **values: Any) -> Row:  # noqa: ANN401 - any value of a row
    """The only row that has those values.

    Raises:
        LookupError: when there is none, or there are several.
    """
    found = matching(rows, **values)
    if len(found) != 1:
        raise LookupError(f"{len(found)} rows with {values}")
    return found[0]


def column(rows: Rows, key: str) -> list[Any]:
    """The values of a column.

    >>> column([{"world": 3}, {"world": 4}], "world")
    [3, 4]
    """
    return [row[key] for row in rows]


def total(rows: Rows, method: str) -> Row:
    """Trials and success of a method in all worlds together."""
    found = matching(rows, method=method)
    trials = sum(row["trials"] for row in found)
    succeeded = sum(round(row["success"] * row["trials"]) for row in found)
    return {"method": method, "trials": trials, "success": succeeded / trials}


def named(rows: Rows, key: str, names: Mapping[Any, str], **values: Any) -> Rows:  # noqa: ANN401
    """The only row for each name in a column, in the order of the names, with its words as `name`.

    >>> named([{"fault": "blocked"}], "fault", {"blocked": "path blocked"})
    [{'fault': 'blocked', 'name': 'path blocked'}]
    """
    return [one(rows, **{key: name}, **values) | {"name": words} for name, words in names.items()]


def called(key: str, names: Mapping[Any, str]) -> Callable[[Row], str]:
    """What the page calls the value of a column.

    >>> called("agent", {"nts": "NTS"})({"agent": "nts"})
    'NTS'
    """
    return lambda row: names[row[key]]


def without(bounds: Collection[str], name: str, key: str) -> Callable[[Row], float | None]:
    """By what rows are compared: the value of a column, for all but those with some names.

    >>> judged = without(("oracle",), "agent", "success")
    >>> judged({"agent": "oracle", "success": 1.0}), judged({"agent": "meng", "success": 0.5})
    (None, 0.5)
    """
    return lambda row: None if row[name] in bounds else row[key]


def success(row: Row) -> str:
    """The share that succeeded, with its interval."""
    return interval(row, "success")


def share(key: str) -> Callable[[Row], str]:
    """A share whose interval is in columns named after its own; nothing for None.

    >>> share("lost")({"lost": 0.5, "lost_low": 0.25, "lost_high": 0.75})
    '50.0% (25.0 to 75.0)'
    """
    return lambda row: "" if row[key] is None else interval(row, key, f"{key}_low", f"{key}_high")


def part(key: str, whole: str, digits: int = 1) -> Callable[[Row], str]:
    """A share of a column's count, with the count behind it; nothing for None.

    >>> part("lost", "trials")({"lost": 0.5, "trials": 80})
    '50.0% (40 of 80)'
    """
    return lambda row: counted(row[key], row[whole], digits)


success_count = part("success", "trials")
"""The share of trials that succeeded, with their count."""


def success_and_spl(row: Row) -> str:
    """The share that succeeded, and SPL.

    >>> success_and_spl({"success": 0.9, "spl": 0.8123})
    '90.0% / 0.812'
    """
    return "{success:.1%} / {spl:,.3f}".format_map(row)


def table_of(
    *columns: tuple[str, Text | Best],
    names: tuple[str, Mapping[Any, str]] | None = None,
    **values: Any,  # noqa: ANN401 - any value of a row
) -> Callable[[Rows], str]:
    """A listing as a specification, which is called with the rows of a report.

    Args:
        columns: as of a listing.
        names: a column whose values the lines have in the order of these names, see `named`.
        values: of the rows that get a line.

    >>> worlds = table_of(("world", "{world}"), ("share", "{share:.0%}"), light=True)
    >>> print(worlds([{"world": 3, "share": 0.5, "light": True}, {"world": 4, "light": False}]))
    | world | share |
    |---|---|
    | 3 | 50% |
    """
    if names is None:
        return lambda rows: listing(matching(rows, **values), *columns)
    return lambda rows: listing(named(rows, *names, **values), *columns)


def listing(rows: Iterable[Row], *columns: tuple[str, Text | Best]) -> str:
    """A table with a line for each row; a column is a head and what its cells say.

    >>> rows = [{"world": 3, "share": 0.5}, {"world": 4, "share": 0.25}]
    >>> print(listing(rows, ("world", "{world}"), ("success", Best("{share:.0%}", "share"))))
    | world | success |
    |---|---|
    | 3 | **50%** |
    | 4 | 25% |
    """
    return table([head for head, _ in columns], lines_of(rows, *columns))


def lines_of(rows: Iterable[Row], *columns: tuple[str, Text | Best]) -> list[list[str]]:
    """The lines of a listing, without its head."""
    rows = list(rows)
    return transposed([_cells(rows, spec) for _, spec in columns])


def pivot(
    rows: Rows, lines: Sequence[Row], across: Sequence[Row], text: Text | Best
) -> list[list[str]]:
    """Cells whose line and column say together which row they tell of.

    >>> rows = [{"world": w, "frames": n, "vertices": w + n} for w in (3, 4) for n in (10, 20)]
    >>> pivot(rows, asked(world=(3, 4)), asked(frames=(10, 20)), "{vertices}")
    [['13', '23'], ['14', '24']]
    """
    return [_cells([one(rows, **line, **keys) for keys in across], text) for line in lines]


def of(rows: Rows, text: Text, *keys: str, **values: Any) -> Callable[[Row], str]:  # noqa: ANN401
    """What a cell says of the only row that has these values, and those of its line.

    Args:
        rows: of a report.
        text: of the row.
        keys: columns of the line that count; all unless given.
        values: that the row has besides.

    >>> steps = of([{"agent": "nts", "goals": 10, "spl": 0.5}], "{spl:.2f}", goals=10)
    >>> steps({"agent": "nts"})
    '0.50'
    """
    return lambda line: said(text, one(rows, **{key: line[key] for key in keys or line}, **values))


def said(text: Text, row: Row) -> str:
    """What a cell says of a row."""
    return text.format_map(row) if isinstance(text, str) else text(row)


def asked(**values: Iterable[Any]) -> Rows:
    """What lines or columns ask for: all combinations of the values of some columns.

    >>> asked(method=("meng", "sptm"), goals=(1,))
    [{'method': 'meng', 'goals': 1}, {'method': 'sptm', 'goals': 1}]
    """
    return [dict(zip(values, found, strict=True)) for found in product(*values.values())]


def transposed(cells: Iterable[Iterable[str]]) -> list[list[str]]:
    """Lines of columns, or columns of lines."""
    return [list(line) for line in zip(*cells, strict=True)]


def _cells(rows: Rows, spec: Text | Best) -> list[str]:
    if isinstance(spec, Best):
        values = [spec.value(row) for row in rows]
        return with_best_bold(_cells(rows, spec.text), values, spec.least)
    return [said(spec, row) for row in rows]
