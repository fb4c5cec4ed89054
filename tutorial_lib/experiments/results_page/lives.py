"""Tables of ten visits: what a memory is worth over the life of a robot in one building."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.race.ten_visits import CHANGED, PARTS, STAYS
from tutorial_lib.experiments.results_page.markdown import Row, interval, percent
from tutorial_lib.experiments.results_page.tables import (
    Text,
    listing,
    matching,
    one,
    success,
)

AGENTS = {
    "combined": "combined",
    "no_closing": "without closing loops",
    "no_looks": "recalls nodes only",
    "no_metric": "drives from node to node",
    "no_travel": "whatever the drive to a ghost costs",
    "no_relocating": "does not notice a carry",
    "nts": "NTS, graph kept",
    "nts_closing": "NTS, closing loops",
    "nts_forgets": "NTS, forgets with each goal",
    "fbe": "nearest frontier, grid kept",
    "fbe_recalls": "nearest frontier, grid and pictures kept",
    "ans_like": "learned choice of frontier, grid kept",
    "ans_recalls": "learned choice of frontier, grid and pictures kept",
    "ans_corrected": "learned choice of frontier, grid and pictures kept, odometry corrected",
    "il_forgets": "imitation",
    "random_forgets": "random walk",
    "oracle": "oracle",
    "meng_toured": "Meng, after a tour",
    "sptm_toured": "SPTM, after a tour",
    "ltvn_toured": "LTVN, after a tour",
    "meng_explores": "Meng, after a tour, with NTS where it has no path",
    "meng_explored": "Meng, after exploring",
    "sptm_explored": "SPTM, after exploring",
    "ltvn_explored": "LTVN, after exploring",
}
"""How agents are called on the page."""
FIRST, LAST, ALL = PARTS


def lives(rows: Rows) -> str:
    """Success and SPL of every agent by visits, and where the goal had been passed or not."""
    return listing(
        matching(rows, visits=LAST),
        ("agent", lambda row: AGENTS.get(row["agent"], row["agent"])),
        (f"visits {FIRST}", _in(rows, FIRST)),
        (f"visits {LAST}", _in(rows, LAST)),
        (f"combined - this, visits {LAST}", lambda row: "" if _is_first(rows, row) else _gap(row)),
        (f"actions, visits {LAST}", "{steps:,.0f}"),
        ("goal passed before", lambda row: _where(row, "passed")),
        ("goal never passed", lambda row: _where(row, "missed")),
    )


def carried(rows: Rows) -> str:
    """Lives with a carry: success, and how soon a robot finds itself again."""
    return listing(
        matching(rows, visits=ALL),
        ("agent", lambda row: AGENTS[row["agent"]]),
        ("all visits", _in(rows, ALL)),
        (f"visits {LAST}", _in(rows, LAST)),
        ("found again", lambda row: _soon(row, "again")),
        ("the same, put down where it had been", lambda row: _soon(row, "again_known")),
        ("wrongly", lambda row: percent(row["again_wrong"])),
    )


def changed(rows: Rows) -> str:
    """Lives in a building that changes, beside the same lives where it stays."""
    later = matching(rows, visits=LAST)

    def beside(kind: str) -> Text:
        def text(row: Row) -> str:
            found = one(later, agent=row["agent"], building=kind)
            return f"{success(found)}, SPL {found['spl']:.2f}"

        return text

    return listing(
        matching(later, building=CHANGED),
        ("agent", lambda row: AGENTS[row["agent"]]),
        (f"the building stays, visits {LAST}", beside(STAYS)),
        (f"it changes, visits {LAST}", beside(CHANGED)),
        ("stays - changes", _gap),
    )


def _in(rows: Rows, visits: str) -> Text:
    """Success with its interval, and SPL, in some visits of an agent."""

    def text(row: Row) -> str:
        found = one(rows, agent=row["agent"], visits=visits)
        return f"{success(found)}, SPL {found['spl']:.2f}"

    return text


def _is_first(rows: Rows, row: Row) -> bool:
    return row["agent"] == rows[0]["agent"]


def _gap(row: Row) -> str:
    return interval(row, "gap", "gap_low", "gap_high")


def _where(row: Row, name: str) -> str:
    """Success and SPL where a goal had been passed or not, and how many goals these are."""
    if row[name] is None:
        return ""
    return f"{row[name]:.0%}, SPL {row[f'{name}_spl']:.2f} ({row[f'{name}_goals']})"


def _soon(row: Row, name: str) -> str:
    return percent(row[name]) if row[name] else ""
