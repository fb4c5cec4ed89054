"""The whole page of results, and the block of the project's README."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.results_page import (
    aliasing,
    compared,
    exploring,
    following,
    lifelong,
    local_control,
    maps,
    navigation,
    probability,
    reachability,
    speed,
    worlds,
)
from tutorial_lib.experiments.results_page.markdown import link
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, load_results
from tutorial_lib.experiments.results_page.summary import results_in_short
from tutorial_lib.experiments.results_page.templates import render_chapter
from tutorial_lib.files import make_folder, write_text
from tutorial_lib.world.worlds import TRAINING_SEEDS

BEGIN, END = "<!-- results: begin -->", "<!-- results: end -->"
"""Around the block of the project's README."""
PAGE = "tutorial_lib/results/README.md"
"""The page, seen from the project's README."""
COMMAND = ".venv/bin/python -m tutorial_lib results"


@dataclass(frozen=True)
class Chapter:
    """Sections under one heading.

    Attributes:
        title: of the chapter.
        sections: in order.
    """

    title: str
    sections: tuple[Section, ...]


CHAPTERS = (
    local_control,
    reachability,
    following,
    maps,
    navigation,
    probability,
    aliasing,
    lifelong,
    exploring,
    worlds,
    speed,
    Chapter(compared.TITLE, compared.SECTIONS),
)


def page_of(results: Results) -> str:
    """The page in Markdown."""
    parts = [introduction(results)]
    for chapter in CHAPTERS:
        if not isinstance(chapter, Chapter):
            parts.append(render_chapter(results, chapter)[0])
            continue
        parts.append(f"## {chapter.title}")
        parts += [section.text(results) for section in chapter.sections]
    chapters = "\n\n".join(parts[1:])
    parts.insert(1, contents(chapters))
    return "\n\n".join(parts) + "\n"


def introduction(results: Results) -> str:
    """What holds for all sections."""
    reports = results.reports.values()
    seeds = sorted({report.seed for report in reports})
    quick = [report.name for report in reports if report.quick]
    if quick:
        raise InputError(f"{', '.join(quick)}: a quick run; run it again without --quick")
    return "\n\n".join(
        [
            "# Results",
            f"This page is made from the JSON files beside it by `{COMMAND}`. Each section has "
            f"the command that measures its numbers again, and the time that it took on a small "
            f"server with two cores, which also had other work at times.",
            f"**Protocol and worlds.** Where a table or figure of Meng 2020 (*Scaling Local "
            f"Control to Large-Scale Topological Navigation*) or of Chaplot et al. 2020 (*Neural "
            f"Topological SLAM for Visual Navigation*) is named, the protocol is the paper's, but "
            f"the world is easier: 2D floor plans, images by raycasting, a simulated robot. The "
            f"papers' numbers stand beside ours for orientation; only rows of one table can be "
            f"compared. Test worlds have seeds from {WORLDS[0]:,} on; networks are trained "
            f"in seeds below {TRAINING_SEEDS.stop:,}, and thresholds and calibrations chosen in "
            f"validation worlds between the two. Nothing is tuned on the test worlds or on Nav2's "
            f"maps. Everything else that is random comes from seed {', '.join(map(str, seeds))}. "
            f"Each network was trained once: intervals do not hold the variation from one "
            f"training to the next. Every table and figure of the papers, whether what is measured "
            f"here agrees, and what is ours: {link(compared.TITLE)}.",
            "**Names.** *C* is local control with k images of context on either side of the "
            "target image, *RE* the reachability estimator, *Meng* the agent of the paper as it "
            "is built here, *NTS* that of Chaplot et al. 2020; *SPTM* (Savinov 2018) is the first "
            "paper's baseline, *random* knows nothing and the *oracle* the floor plan, its pose "
            "and the goal's.",
            "**Intervals** in brackets are of 95 %. Over ten worlds or more they are bootstrapped "
            "over worlds; for one world they are Wilson's, over trials. For three or five worlds "
            "together, too few for a bootstrap, the count is given, or each world. Where all "
            "worlds have the same share the bootstrap has no width, and the interval is left out. "
            "**Bold** is the best of its kind in a column or row; oracles and bounds take no "
            "part, and a bold number need not differ from the next one by more than chance.",
        ]
    )


def contents(chapters: str) -> str:
    """The table of contents: links to all headings of the chapters."""
    headings = re.findall(r"^##(#?) (.*)$", chapters, re.MULTILINE)
    return "\n".join(f"{'  ' if deeper else ''}- {link(title)}" for deeper, title in headings)


def block_of(results: Results) -> str:
    """The block of the project's README, markers included."""
    lines = [
        BEGIN,
        results_in_short(results),
        "",
        f"[All results]({PAGE}), each with its protocol, its intervals and the command that makes "
        f"it. The world is easier than the paper's.",
        END,
    ]
    return "\n".join(lines)


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
