"""What is ours: a place where the course departs from a paper, and the list of them on the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tutorial_lib.experiments.results_page.markdown import link, listed

NOTEBOOKS = {
    "02": "02_local_control",
    "03": "03_reachability",
    "04": "04_sparsification",
    "05": "05_map_building",
    "06": "06_probabilistic_planning",
    "07": "07_aliasing",
    "08": "08_lifelong_maps",
    "09": "09_ghost_nodes",
}


@dataclass(frozen=True)
class Departure:
    """Something that a paper has not, or has otherwise.

    Attributes:
        section: of the paper.
        what: the course has instead.
        where: files of the library, and numbers of notebooks.
        measured: section of the page that shows what it changes; none if empty.
    """

    section: str
    what: str
    where: tuple[str, ...]
    measured: str = ""


def departures(found: Sequence[Departure]) -> str:
    """A list in Markdown."""
    lines = []
    for one in found:
        places = listed([_place(where) for where in one.where])
        measured = f"; {link(one.measured)}" if one.measured else ""
        lines.append(f"- {one.section}: {one.what} ({places}{measured}).")
    return "\n".join(lines)


def _place(where: str) -> str:
    """A link to a notebook or a file, seen from the page.

    >>> _place("09"), _place("topology/planner.py")
    ('[09](../../notebooks/09_ghost_nodes.ipynb)', '[planner.py](../topology/planner.py)')
    """
    if where in NOTEBOOKS:
        return f"[{where}](../../notebooks/{NOTEBOOKS[where]}.ipynb)"
    return f"[{where.rpartition('/')[2]}](../{where})"
