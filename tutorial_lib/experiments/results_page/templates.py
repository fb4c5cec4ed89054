"""The templates of the page: prose in Markdown, whose numbers are short expressions."""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import fmean
from traceback import extract_tb
from types import ModuleType
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, TemplateError
from jinja2.utils import missing

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.results_page import markdown, paper, tables
from tutorial_lib.experiments.results_page.library import LIBRARY
from tutorial_lib.experiments.results_page.section import Section, section_of
from tutorial_lib.experiments.results_page.sources import MAPS, Results, goal_words

TEMPLATES = FOLDER / "page"


class Missing(StrictUndefined):
    """A column that a row lacks is the report's fault; a name that is not there the template's."""

    def __init__(self, hint: str | None = None, obj: Any = missing, *rest: Any) -> None:  # noqa: ANN401
        super().__init__(hint, obj, *rest)
        if isinstance(obj, dict | list):
            raise LookupError(self._undefined_message)


ENVIRONMENT = Environment(
    loader=FileSystemLoader(TEMPLATES), undefined=Missing, trim_blocks=True, lstrip_blocks=True
)
ENVIRONMENT.globals |= LIBRARY
ENVIRONMENT.globals |= {
    function.__name__: function
    for function in (
        *(markdown.brief, markdown.capital, markdown.count, markdown.counted, markdown.interval),
        *(markdown.link, markdown.listed, markdown.number, markdown.percent, markdown.percents),
        *(
            markdown.points,
            markdown.span,
            tables.column,
            tables.matching,
            tables.of_each,
            tables.one,
            goal_words,
        ),
        *(math.ceil, math.degrees, math.floor, max, min, sum),
    )
}
ENVIRONMENT.globals |= {"MAPS": MAPS, "mean": fmean, "paper": paper}


def render(results: Results, name: str, **more: Any) -> str:  # noqa: ANN401
    """What a template says of the reports.

    Args:
        results: the reports.
        name: of the template, without its endings.
        more: what it may use besides.

    Raises:
        InputError: naming the template and the line, if it is not valid.
    """
    file = TEMPLATES / f"{name}.md.j2"
    given = {
        "results": results,
        "rows": results.rows,
        "row": results.row,
        "on_maps": results.on_maps,
        "note": results.note,
        "notes": results.notes,
        "worlds": results.worlds,
    }
    try:
        return ENVIRONMENT.get_template(file.name).render(given | more).strip("\n")
    except TemplateError as error:
        lines = [
            place.lineno for place in extract_tb(error.__traceback__) if place.name == "template"
        ]
        raise InputError(f"{file}, line {getattr(error, 'lineno', lines)}: {error}") from error


def render_chapter(
    results: Results, tables_of: ModuleType, only: str = ""
) -> tuple[str, list[Section]]:
    """A chapter, and its sections.

    Args:
        results: the reports.
        tables_of: the module of the chapter's tables, which has the name of its template.
        only: the title of a section, if no other is to be made.
    """
    found: list[Section] = []

    def section(title: str, *sources: str, caller: Callable[[], str]) -> str:
        if only not in ("", title):
            return ""
        found.append(section_of(results, title, sources, caller))
        return f"{found[-1].text}\n"

    name = tables_of.__name__.rpartition(".")[2]
    return render(results, name, tables=tables_of, section=section), found
