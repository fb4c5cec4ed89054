"""A section of the page: what was measured, by which commands, and what was found."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.provenance import CHANGED, NETWORK, standing_of
from tutorial_lib.experiments.results_page.sources import Results, command_of, remedy

LONG = 120
"""Seconds from which on a duration is given in minutes."""


@dataclass(frozen=True)
class Section:
    """One experiment on the page.

    Attributes:
        title: of the section.
        sources: names of the reports whose commands it shows.
        text: of the section in Markdown, heading included.
    """

    title: str
    sources: tuple[str, ...]
    text: str


def section_of(
    results: Results, title: str, sources: tuple[str, ...], body: Callable[[], str]
) -> Section:
    """A section, with the commands of its sources, if it has any, below its first paragraph.

    `body` makes its text in Markdown, without heading and commands.

    Raises:
        InputError: naming the reports that were read, if one lacks a row, a column or a note.
    """
    with blaming(results, sources):
        measured, *found = paragraphs(body())
    text = "\n\n".join([f"### {title}", measured, *_commands(results, sources), *found])
    return Section(title, sources, text)


@contextmanager
def blaming(results: Results, sources: tuple[str, ...] = ()) -> Iterator[None]:
    """Reports that are read within are to blame for what goes wrong there.

    Raises:
        InputError: naming the reports, `sources` first, and their commands, if one lacks a row, a
            column or a note.
    """
    results.read.clear()
    try:
        yield
    except InputError:
        raise
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        names = tuple(dict.fromkeys((*sources, *results.read)))
        files = ", ".join(f"{name}.json" for name in names)
        advice = "; ".join(remedy(name) for name in names)
        raise InputError(f"{files}: damaged ({error!r}); {advice}") from error


def paragraphs(text: str) -> list[str]:
    r"""What empty lines divide.

    >>> paragraphs("one\n\n\n| two |\n|---|\n")
    ['one', '| two |\n|---|']
    """
    return re.split(r"\n\n+", text.strip("\n"))


def _commands(results: Results, names: tuple[str, ...]) -> list[str]:
    """One block of the commands; none without a command."""
    lines = [
        f"{command_of(name)}   # {duration(report.seconds)}{mark_of(report)}"
        for name, report in ((name, results.reports[name]) for name in names)
    ]
    return ["\n".join(["```sh", *lines, "```"])] if lines else []


def mark_of(report: Report) -> str:
    """What the page says of a result that no longer fits the library."""
    standing = standing_of(report)
    return f"; STALE: {standing.words}" if standing.kind in (NETWORK, CHANGED) else ""


def duration(seconds: float) -> str:
    """How long something took.

    >>> duration(7.66), duration(998.7)
    ('8 s', '17 min')
    """
    return f"{seconds:.0f} s" if seconds < LONG else f"{seconds / 60:.0f} min"
