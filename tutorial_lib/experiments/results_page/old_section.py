"""A section of the page: what was measured, by which commands, and what was found."""

from __future__ import annotations

from collections.abc import Callable
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
        sources: names of the reports that it shows.
        paragraphs: of its text: what is measured, then tables and remarks.
        reads: names of other reports, whose commands stand in other sections.
    """

    title: str
    sources: tuple[str, ...]
    paragraphs: Callable[[Results], list[str]]
    reads: tuple[str, ...] = ()

    def text(self, results: Results) -> str:
        """The section in Markdown; the commands, if it has any, stand below its first paragraph.

        Raises:
            InputError: naming the reports, if one lacks a row, a column or a note.
        """
        try:
            measured, *found = self.paragraphs(results)
        except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
            names = (*self.sources, *self.reads)
            files = ", ".join(f"{name}.json" for name in names)
            advice = "; ".join(remedy(name) for name in names)
            raise InputError(f"{files}: damaged ({error!r}); {advice}") from error
        return "\n\n".join([f"### {self.title}", measured, *self._commands(results), *found])

    def _commands(self, results: Results) -> list[str]:
        """One block of the commands; none without a command."""
        lines = [
            f"{command_of(name)}   # {duration(report.seconds)}{mark_of(report)}"
            for name, report in ((name, results.reports[name]) for name in self.sources)
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
