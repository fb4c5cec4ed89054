"""The templates of the page: prose in Markdown, whose numbers are short expressions.

A section tells of one experiment: what was measured, by which commands, and what was found.
"""

import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from inspect import getmembers, isfunction, ismethod
from statistics import fmean
from traceback import extract_tb
from types import ModuleType
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, TemplateError
from jinja2.utils import missing

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.provenance import CHANGED, NETWORK, standing_of
from tutorial_lib.experiments.results_page import markdown, paper, tables
from tutorial_lib.experiments.results_page.library import LIBRARY
from tutorial_lib.experiments.results_page.sources import (
    GONE,
    MAPS,
    RETIRED,
    Results,
    command_of,
    goal_words,
    remedy,
)
from tutorial_lib.world.worlds import TRAINING_SEEDS

LONG = 120
"""Seconds from which on a duration is given in minutes."""
TEMPLATES = FOLDER / "page"
FUNCTIONS = (goal_words, math.ceil, math.degrees, math.floor, max, min, sum)
"""What every template may call, besides `mean`, what makes tables, and the methods of `Results`."""


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


class Missing(StrictUndefined):
    """A column that a row lacks is the report's fault; a name that is not there the template's."""

    def __init__(self, *given: Any, obj: Any = missing, **more: Any) -> None:  # noqa: ANN401
        super().__init__(*given, obj=obj, **more)
        if isinstance(obj, dict | list):
            raise LookupError(self._undefined_message)


ENVIRONMENT = Environment(
    loader=FileSystemLoader(TEMPLATES), undefined=Missing, trim_blocks=True, lstrip_blocks=True
)
GIVEN: dict[str, Any] = {
    **LIBRARY,
    **dict(getmembers(markdown, isfunction) + getmembers(tables, isfunction)),
    **{function.__name__: function for function in FUNCTIONS},
    "MAPS": MAPS,
    "TRAINING_SEEDS": TRAINING_SEEDS,
    "mean": fmean,
    "paper": paper,
}
ENVIRONMENT.globals.update(GIVEN)


def render(results: Results, name: str, **more: Any) -> str:  # noqa: ANN401
    """What a template, named without its endings, says of the reports; it may use `more`.

    Raises:
        InputError: naming the template and the line, if it is not valid.
    """
    file = f"{name}.md.j2"
    given = dict(getmembers(results, ismethod)) | {"results": results} | more
    try:
        return ENVIRONMENT.get_template(file).render(given).strip("\n")
    except TemplateError as error:
        places = extract_tb(error.__traceback__)
        lines = [place.lineno for place in places if not place.filename.endswith(".py")]
        line = getattr(error, "lineno", None) or (lines or [1])[-1]
        raise InputError(f"{TEMPLATES / file}, line {line}: {error}") from error


def render_chapter(
    results: Results, chapter: ModuleType, only: str = ""
) -> tuple[str, list[Section]]:
    """A chapter, and its sections: all, or `only` that of this title.

    The module of its tables has the name of its template. A section shows the commands of its
    sources, if it has any, below its first paragraph, and names those that are retired.

    Raises:
        InputError: naming the reports that a section read, if one lacks a row, a column or a note.
    """
    found: list[Section] = []

    def section(title: str, *sources: str, caller: Callable[[], str]) -> str:
        if only not in ("", title):
            return ""
        with blaming(results, sources):
            measured, *rest = paragraphs(caller())
        text = "\n\n".join([f"### {title}", measured, *_commands(results, sources), *rest])
        found.append(Section(title, sources, text))
        return f"{text}\n"

    name = chapter.__name__.rpartition(".")[2]
    return render(results, name, tables=chapter, section=section), found


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
    """One block of the commands, none without a command; and which reports have none any more."""
    lines = [
        f"{command_of(name)}   # {duration(report.seconds)}{mark_of(report)}"
        for name, report in ((name, results.reports[name]) for name in names)
        if name not in RETIRED
    ]
    block = ["\n".join(["```sh", *lines, "```"])] if lines else []
    gone = ", ".join(f"`{name}.json`" for name in names if name in RETIRED)
    return [*block, f"{GONE} ({gone})."] if gone else block


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
