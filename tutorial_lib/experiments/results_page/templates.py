"""The templates of the page: prose in Markdown, whose numbers are short expressions."""

from __future__ import annotations

import math
from collections.abc import Callable
from inspect import getmembers, isfunction, ismethod
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
from tutorial_lib.world.worlds import TRAINING_SEEDS

TEMPLATES = FOLDER / "page"
FUNCTIONS = (goal_words, math.ceil, math.degrees, math.floor, max, min, sum)
"""What every template may call, besides `mean`, what makes tables, and the methods of `Results`."""


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

    The module of its tables has the name of its template.
    """
    found: list[Section] = []

    def section(title: str, *sources: str, caller: Callable[[], str]) -> str:
        if only not in ("", title):
            return ""
        found.append(section_of(results, title, sources, caller))
        return f"{found[-1].text}\n"

    name = chapter.__name__.rpartition(".")[2]
    return render(results, name, tables=chapter, section=section), found
