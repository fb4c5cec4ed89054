"""The whole results page, and the block of the project's README."""

import re
from collections.abc import Sequence
from functools import reduce
from pathlib import Path

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.results_page import (
    aliasing,
    exploring,
    following,
    lifelong,
    lives,
    local_control,
    maps,
    navigation,
    papers,
    probability,
    reachability,
    speed,
    worlds,
)
from tutorial_lib.experiments.results_page.markdown import link
from tutorial_lib.experiments.results_page.sources import Results, load_results
from tutorial_lib.experiments.results_page.templates import blaming, render, render_chapter
from tutorial_lib.files import make_folder, write_text

BEGIN, END = "<!-- results: begin -->", "<!-- results: end -->"
"""Around the block of the project's README."""
PAGE = "tutorial_lib/results/README.md"
"""The page, seen from the project's README."""
CHAPTERS = (
    *(local_control, reachability, following, maps, navigation, probability, aliasing),
    *(lifelong, exploring, lives, worlds, speed, papers),
)
"""Modules of their tables; each has a template of its name."""


def page_of(results: Results) -> str:
    """The page in Markdown.

    Raises:
        InputError: naming a report of a quick run, or one that is damaged.
    """
    if quick := [report.name for report in results.reports.values() if report.quick]:
        raise InputError(f"{', '.join(quick)}: a quick run; run it again without --quick")
    chapters = "\n\n".join(render_chapter(results, tables)[0] for tables in CHAPTERS)
    parts = [render(results, "introduction"), contents(chapters), chapters]
    return "\n\n".join(parts) + "\n"


def contents(chapters: str) -> str:
    """The table of contents: links to all headings of the chapters."""
    headings = re.findall(r"^##(#?) (.*)$", chapters, re.MULTILINE)
    return "\n".join(f"{'  ' if deeper else ''}- {link(title)}" for deeper, title in headings)


def block_of(results: Results) -> str:
    """The block of the project's README, markers included."""
    with blaming(results):
        return f"{BEGIN}\n{render(results, 'in_short')}\n{END}"


def with_block(readme: str, block: str) -> str:
    """A README with a block in place of what is between the block's markers, its ends.

    Raises:
        InputError: unless it has both markers once, in order.
    """
    first, *_, last = block.splitlines()
    before, begin, rest = readme.partition(first)
    _, end, after = rest.partition(last)
    if not (begin and end) or first in rest or last in after:
        raise InputError(f"README.md: write {first} and {last} once, where the block belongs")
    return f"{before}{block}{after}"


def write_results(
    readme: Path, page: Path, folder: Path = FOLDER, blocks: Sequence[str] = ()
) -> list[Path]:
    """Write the page of a folder of reports, and the blocks of a README if there is one.

    Args:
        readme: the project's.
        page: where the page belongs.
        folder: of the reports.
        blocks: of the README, beside that of the results.

    Raises:
        InputError: naming a report that is missing or damaged and the command that makes it.
    """
    results = load_results(folder)
    make_folder(page.parent)
    texts = {page: page_of(results)}
    if readme.is_file():
        parts = (block_of(results), *blocks)
        texts[readme] = reduce(with_block, parts, readme.read_text(encoding="utf-8"))
    for path, text in texts.items():
        write_text(path, text)
    return list(texts)
