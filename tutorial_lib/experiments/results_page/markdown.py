"""Numbers as text, and tables in Markdown."""

import re
from collections.abc import Sequence
from typing import Any

Row = dict[str, Any]
"""A row of a report."""


def percent(share: float | None, digits: int = 1) -> str:
    """A share as text; nothing for None.

    >>> percent(0.9184, 2), percent(None)
    ('91.84%', '')
    """
    return "" if share is None else f"{share:.{digits}%}"


def number(value: float | None, digits: int = 3) -> str:
    """A number with so many decimals; nothing for None.

    >>> number(0.96785), number(None)
    ('0.968', '')
    """
    return "" if value is None else f"{value:,.{digits}f}"


def percents(shares: Sequence[float], digits: int = 1) -> list[str]:
    """Shares as texts.

    >>> percents([0.5, 0.25])
    ['50.0%', '25.0%']
    """
    return [percent(share, digits) for share in shares]


def count(number: float) -> str:
    """A count as text.

    >>> count(12_000)
    '12,000'
    """
    return f"{number:,}"


def brief(value: float) -> str:
    """A setting as text, with as few digits as it has.

    >>> brief(0.30), brief(2.0)
    ('0.3', '2')
    """
    return f"{value:g}"


def interval(row: Row, key: str, low: str = "low", high: str = "high") -> str:
    """A share and its 95% interval, without one where all worlds are the same.

    >>> interval({"success": 0.87, "low": 0.8163, "high": 0.9097}, "success")
    '87.0% (81.6 to 91.0)'
    >>> interval({"success": 1.0, "low": 1.0, "high": 1.0}, "success")
    '100.0%'
    """
    if row[low] == row[high]:
        return percent(row[key])
    return f"{percent(row[key])} ({100 * row[low]:.1f} to {100 * row[high]:.1f})"


def number_interval(row: Row, key: str) -> str:
    """A number and its 95% interval, which is in columns named after the number's.

    >>> number_interval({"auc": 0.9, "auc_low": 0.88, "auc_high": 0.9123}, "auc")
    '0.900 (0.880 to 0.912)'
    """
    low, high = row[f"{key}_low"], row[f"{key}_high"]
    return number(row[key]) + ("" if low is None else f" ({number(low)} to {number(high)})")


def counted(share: float | None, whole: int | None, digits: int = 1) -> str:
    """A share with the count behind it; nothing for None.

    >>> counted(0.984, 1000), counted(None, None)
    ('98.4% (984 of 1,000)', '')
    """
    if share is None or whole is None:
        return ""
    return f"{percent(share, digits)} ({round(share * whole):,} of {whole:,})"


def points(gap: float) -> str:
    """A difference of shares.

    >>> points(0.25), points(-0.004)
    ('+25.0 points', '-0.4 points')
    """
    return f"{100 * gap:+.1f} points"


def listed(items: Sequence[str]) -> str:
    """Items as a sentence has them.

    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    *first, last = items
    return f"{', '.join(first)} and {last}" if first else last


def capital(text: str) -> str:
    """A text with which a sentence begins.

    >>> capital("a path of Meng's")
    "A path of Meng's"
    """
    return f"{text[0].upper()}{text[1:]}"


def span(values: Sequence[float], digits: int = 1) -> str:
    """From the least to the greatest of some shares.

    >>> span([0.957, 0.846])
    '84.6% to 95.7%'
    """
    return f"{percent(min(values), digits)} to {percent(max(values), digits)}"


def with_best_bold(
    cells: Sequence[str], values: Sequence[float | None], least: bool = False
) -> list[str]:
    """The cells of a column, with the best value bold; a None takes no part.

    >>> with_best_bold(["10%", "20%", "100%"], [0.1, 0.2, None])
    ['10%', '**20%**', '100%']
    """
    known = [value for value in values if value is not None]
    best = (min if least else max)(known) if known else None
    # Two that read the same are both best.
    bold = [v is not None and best is not None and round(v, 3) == round(best, 3) for v in values]
    return [f"**{cell}**" if is_best else cell for cell, is_best in zip(cells, bold, strict=True)]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table.

    >>> print(table(["a", "b"], [["1", "2"]]))
    | a | b |
    |---|---|
    | 1 | 2 |
    """
    lines = [f"| {' | '.join(row)} |" for row in (head, *rows)]
    lines.insert(1, "|---" * len(head) + "|")
    return "\n".join(lines)


def anchor(title: str) -> str:
    """The anchor that GitHub gives a heading.

    >>> anchor("Table II: navigation on Nav2's maps")
    'table-ii-navigation-on-nav2s-maps'
    """
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def link(title: str, words: str = "") -> str:
    """A link to a heading of the page, by its title unless other words are given.

    >>> link("Fig. 8: whole maps"), link("Fig. 8: whole maps", "Fig. 8")
    ('[Fig. 8: whole maps](#fig-8-whole-maps)', '[Fig. 8](#fig-8-whole-maps)')
    """
    return f"[{words or title}](#{anchor(title)})"
